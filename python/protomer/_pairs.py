"""Results of pairs of bodies, of assemblies at equilibrium, and of what both look like from outside."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._assembly import nearest
from ._chart import Axis, Cells, Chart, Counts, Curve, Level, salt_axis
from ._errors import unknown
from ._result import Result, numbers

Numbers = NDArray[np.float64]


class PairResult(Result):
    """Two bodies over a grid of salt and pH: one entry of `conditions` for each.

    Examples
    --------
    >>> pair = pm.pair(plus, minus, salt_molar=[0.05, 0.1], output="association")      # doctest: +SKIP
    >>> pair.kd_molar, pair.pose_files                                                 # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "pair.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("pair",)

    @property
    def pose_files(self) -> list[Path]:
        """The structure files of the bound poses of all conditions, the most stable of each first."""
        return sorted(self.directory.glob("**/poses/pose_*.cif"))

    def poses(self, *, salt_molar: float | None = None, ph: float | None = None) -> tuple[Numbers, Numbers, Numbers]:
        """The bound poses of one condition: the second body in the frame of the first.

        Parameters
        ----------
        salt_molar, ph
            The condition; what all conditions share may be left out

        Returns
        -------
        tuple
            Positions, Å, (P, 3), orientations, scalar first, (P, 4), and energies, kT, (P,); the most stable first

        Raises
        ------
        KeyError
            If there is no such condition, or several; it lists those that exist

        Examples
        --------
        >>> positions, turns, energies_kt = pair.poses(salt_molar=0.05)        # doctest: +SKIP
        """
        rows = list(self._fields["conditions"])
        for key, asked in (("salt_M", salt_molar), ("ph", ph)):
            if asked is not None:
                known = [row[key] for row in rows if row[key] is not None]
                value = known[nearest(known, asked, key)]
                rows = [row for row in rows if row[key] == value]
        if len(rows) != 1:
            unknown("single condition", (salt_molar, ph), [(row["salt_M"], row["ph"]) for row in rows])
        poses = rows[0]["poses"]
        return (
            np.array([pose["position_angstrom"] for pose in poses]).reshape(-1, 3),
            np.array([pose["orientation_wxyz"] for pose in poses]).reshape(-1, 4),
            np.array([pose["energy_kt"] for pose in poses], dtype=np.float64),
        )

    def _column(self, name: str) -> Numbers:
        return numbers([row[name] for row in self._fields["conditions"]])

    @property
    def salt_molar(self) -> Numbers:
        """Salt concentrations, mol/L, (C,); NaN where a Debye length was stated."""
        return self._column("salt_M")

    @property
    def ph(self) -> Numbers:
        """pH values, (C,); NaN for body files, whose charges are fixed."""
        return self._column("ph")

    @property
    def b2_angstrom3(self) -> Numbers:
        """Second virial coefficients, Å³, (C,)."""
        return self._column("b2_angstrom3")

    @property
    def b2_error_angstrom3(self) -> Numbers:
        """Their standard errors, Å³, (C,)."""
        return self._column("b2_error_angstrom3")

    @property
    def b22_mol_ml_per_g2(self) -> Numbers:
        """The same as scattering measures it, mol mL/g², (C,); NaN where the molar mass is not known."""
        return self._column("b22_mol_ml_per_g2")

    @property
    def kd_molar(self) -> Numbers:
        """Dissociation constants, mol/L, (C,); NaN where contacts are not favoured."""
        return self._column("kd_molar")

    def _chart(self, quantity: str | None) -> Chart:
        """The second virial coefficient against salt with its error, a line for each pH (`salt`); as a map over salt and pH (`map`);
        or the potential of mean force (kT) against the distance (Å) (`distance`).

        The map needs several salts and pH values. Its colours are symmetric about zero: red for attraction.
        """
        if quantity not in (None, "salt", "map", "distance"):
            unknown("quantity", quantity, ["salt", "map", "distance"])
        if quantity == "distance":
            return self._against_distance()
        if np.any(np.isnan(self.salt_molar)):
            raise ValueError('the salt is not known, because a Debye length was stated; use quantity="distance"')
        return self._map() if quantity == "map" else self._against_salt()

    def _against_salt(self) -> Chart:
        values, errors, label = self._b2()
        curves = [
            Curve(self.salt_molar[own] * 1000.0, values[own], name, errors[own], marker="o") for name, own in self._lines()
        ]
        return Chart(salt_axis(self.salt_molar), Axis(label), [*curves, Level(0.0, dashed=False)])

    def _map(self) -> Chart:
        salts, phs = np.unique(self.salt_molar), np.unique(self.ph[np.isfinite(self.ph)])
        if salts.size < 2 or phs.size < 2:
            raise ValueError("a map needs at least two salts and two pH values; call pm.pair with salt= and ph= of several each")
        values, _, label = self._b2()
        cells = np.full((phs.size, salts.size), np.nan)
        cells[np.searchsorted(phs, self.ph), np.searchsorted(salts, self.salt_molar)] = values
        x = Axis("salt (mM)", ticks=(np.arange(salts.size) + 0.5, [f"{salt:g}" for salt in salts * 1000.0]))
        y = Axis("pH", ticks=(np.arange(phs.size) + 0.5, [f"{ph:g}" for ph in phs]))
        return Chart(x, y, [Cells(cells, label)])

    def _against_distance(self) -> Chart:
        curves = []
        for row in self._fields["conditions"]:
            # Near the contact w(r) is all error; where there is no error it has no value.
            own = [at for at in row["mean_force"] if at["w_error_kt"] is not None and at["w_error_kt"] < 0.5]
            parts = [] if row["ph"] is None else [f"pH {row['ph']:g}"]
            parts += [] if row["salt_M"] is None else [f"{row['salt_M'] * 1000.0:g} mM"]
            distance, energy = (numbers([at[key] for at in own]) for key in ("distance_angstrom", "w_kt"))
            curves.append(Curve(distance, energy, ", ".join(parts) or None))
        return Chart(Axis("distance of the origins (Å)"), Axis("w (kT)"), [*curves, Level(0.0, dashed=False)])

    def _b2(self) -> tuple[Numbers, Numbers, str]:
        """B2 and its error per condition, with their unit: per mass where the molar masses are known."""
        b22 = self.b22_mol_ml_per_g2
        if np.all(np.isfinite(b22)):
            return b22 * 1e4, self._column("b22_error_mol_ml_per_g2") * 1e4, "B22 (10⁻⁴ mol mL/g²)"
        return self.b2_angstrom3 / 1000.0, self.b2_error_angstrom3 / 1000.0, "B2 (10³ Å³)"

    def _lines(self) -> list[tuple[str, NDArray[Any]]]:
        """The conditions of each pH, in rising order of salt, with a name."""
        ph = self.ph
        if np.all(np.isnan(ph)):
            return [("bodies as they are", np.argsort(self.salt_molar))]
        own = ((value, np.flatnonzero(ph == value)) for value in np.unique(ph))
        return [(f"pH {value:g}", rows[np.argsort(self.salt_molar[rows])]) for value, rows in own]


class StabilityResult(Result):
    """An assembly and its parts at equilibrium: one entry of `conditions` for each pH and salt.

    Examples
    --------
    >>> found = pm.stability("4hhb.cif.gz", salt_molar=[0.05, 0.5], output="yields")   # doctest: +SKIP
    >>> found.equilibrated, found.half_salt_molar, found.yields                        # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "stability.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("equilibrium",)

    @property
    def salt_molar(self) -> Numbers:
        """Salt concentrations, mol/L, (C,)."""
        return numbers([row["salt_M"] for row in self._fields["conditions"]])

    @property
    def ph(self) -> Numbers:
        """pH values, (C,); NaN where none is stated."""
        return numbers([row["ph"] for row in self._fields["conditions"]])

    @property
    def concentration_molar(self) -> Numbers:
        """Total concentrations of the bodies, mol/L, (M,)."""
        return numbers(self._fields["settings"]["concentration_M"])

    @property
    def yields(self) -> Numbers:
        """Shares of the bodies in whole assemblies, (C, M)."""
        rows = [[mixture["yield"] for mixture in row["mixtures"]] for row in self._fields["conditions"]]
        return np.asarray(rows, dtype=np.float64)

    @property
    def free_energies_kt(self) -> Numbers:
        """Standard free energies of the parts against free bodies at 1 mol/L, kT, (C, P); NaN without room."""
        rows = [[part["free_energy_kt"] for part in row["parts"]] for row in self._fields["conditions"]]
        return np.asarray(rows, dtype=np.float64)

    def _chart(self, quantity: str | None) -> Chart:
        """The share of the bodies in whole assemblies against salt, a line for each pH and concentration."""
        curves = []
        for value in np.unique(self.ph):
            chosen = np.isnan(self.ph) if np.isnan(value) else self.ph == value
            order = np.argsort(self.salt_molar[chosen])
            salts, shares = self.salt_molar[chosen][order] * 1000.0, self.yields[chosen][order]
            for number, molar in enumerate(self.concentration_molar):
                name = f"{molar:.1e} M" if np.isnan(value) else f"{molar:.1e} M, pH {value:g}"
                curves.append(Curve(salts, shares[:, number], name, marker="o"))
        return Chart(salt_axis(self.salt_molar), Axis("bodies in whole assemblies", range=(0.0, 1.05)), curves)


class ScatteringResult(Result):
    """What light and X-rays see: one entry of `states` for each salt concentration, or for the assembly.

    Examples
    --------
    >>> seen = pm.scattering("stability")                              # doctest: +SKIP
    >>> seen.salt_molar, seen.hydrodynamic_radius_angstrom             # doctest: +SKIP
    >>> seen.q_per_angstrom, seen.structure_factor.shape               # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "scattering.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("sweep", "simulation")

    def _column(self, name: str, part: str) -> Numbers:
        return numbers([state[name][part] for state in self._fields["states"]])

    def _curves(self, name: str) -> Numbers:
        return np.array([numbers([row[name] for row in state["curve"]]) for state in self._fields["states"]])

    @property
    def salt_molar(self) -> Numbers:
        """Salt concentrations, mol/L, (S,); NaN for an assembly."""
        return numbers([state["salt_M"] for state in self._fields["states"]])

    @property
    def q_per_angstrom(self) -> Numbers:
        """Wave numbers, Å⁻¹, (Q,)."""
        first: Numbers = self._curves("q_per_angstrom")[0]
        return first

    @property
    def structure_factor(self) -> Numbers:
        """S(q) between the origins of the bodies, (S, Q)."""
        return self._curves("structure_factor")

    @property
    def structure_factor_error(self) -> Numbers:
        """Its standard error, (S, Q); NaN where there is one frame."""
        return self._curves("structure_factor_error")

    @property
    def form_factor(self) -> Numbers:
        """P(q) of the bodies, weighted with their squared volumes, (Q,)."""
        first: Numbers = self._curves("form_factor")[0]
        return first

    @property
    def intensity(self) -> Numbers:
        """I(q) of all bodies over the sum of their squared volumes, (S, Q)."""
        return self._curves("intensity")

    @property
    def intensity_error(self) -> Numbers:
        """Its standard error, (S, Q); NaN where there is one frame."""
        return self._curves("intensity_error")

    @property
    def hydrodynamic_radius_angstrom(self) -> Numbers:
        """Hydrodynamic radius as dynamic light scattering averages it, Å, (S,)."""
        return self._column("hydrodynamic_radius_angstrom", "mean")

    @property
    def hydrodynamic_radius_error_angstrom(self) -> Numbers:
        """Its standard error, Å, (S,); NaN where there is one frame."""
        return self._column("hydrodynamic_radius_angstrom", "error")

    @property
    def fraction_of_bodies(self) -> Numbers:
        """Fraction of the bodies in clusters of 1, 2, ... bodies, (S, K)."""
        states = self._fields["states"]
        largest = max(len(state["cluster_sizes"]) for state in states)
        fractions = np.zeros((len(states), largest))
        for row, state in zip(fractions, states):
            row[: len(state["cluster_sizes"])] = [size["fraction_of_bodies"] for size in state["cluster_sizes"]]
        return fractions

    def _chart(self, quantity: str | None) -> Chart:
        """I(q) (`intensity`) or S(q) (`structure_factor`), a line for each salt, or the distribution of cluster sizes (`clusters`)."""
        labels = {"intensity": "I(q)", "structure_factor": "S(q) of the centres", "clusters": "fraction of the bodies"}
        if quantity is not None and quantity not in labels:
            unknown("quantity", quantity, labels)
        quantity = quantity or "intensity"
        names = [None if np.isnan(salt) else f"{salt * 1000.0:g} mM" for salt in self.salt_molar]
        if quantity == "clusters":
            sizes = np.arange(1, self.fraction_of_bodies.shape[1] + 1)
            shares = [Curve(sizes, row, name, marker="o") for name, row in zip(names, self.fraction_of_bodies)]
            return Chart(Axis("bodies in a cluster"), Axis(labels[quantity]), shares)
        curves = []
        for name, curve, errors in zip(names, getattr(self, quantity), getattr(self, f"{quantity}_error")):
            curves.append(Curve(self.q_per_angstrom, curve, name, None if np.all(np.isnan(errors)) else errors))
        return Chart(Axis("q (1/Å)"), Axis(labels[quantity], log=quantity == "intensity"), curves)


class PotentialResult(Result):
    """A solved Poisson-Boltzmann equation."""

    @property
    def potentials_kt_per_e(self) -> Numbers:
        """The potential at the requested points, kT/e, (P,); NaN outside the grid."""
        return numbers(self._fields.get("potentials_kT_per_e") or [])

    def _chart(self, quantity: str | None) -> Chart:
        """The potentials at the requested points, kT/e: a histogram (`histogram`), or one value per point (`line`)."""
        if quantity not in (None, "histogram", "line"):
            unknown("quantity", quantity, ["histogram", "line"])
        potentials = self.potentials_kt_per_e
        if potentials.size == 0:
            raise ValueError("no points were requested; call pm.potential with points=")
        if quantity == "line":
            return Chart(Axis("point"), Axis("potential (kT/e)"), [Curve(np.arange(1, potentials.size + 1), potentials, marker="o")])
        return Chart(Axis("potential (kT/e)"), Axis("points"), [Counts(potentials[np.isfinite(potentials)])])
