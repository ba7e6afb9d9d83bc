"""The results of verbs, with plots.

Every `plot(ax=None)` draws into axes of matplotlib, new ones if none are given, and returns them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ._assembly import Assembly, Trajectory, nearest
from ._errors import unknown
from ._log import read_log
from ._phases import HardBodySweepResult, PhaseDiagramResult
from ._result import Result, missing, new_axes, numbers
from ._scores import ScoreResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "BenchResult",
    "CompareResult",
    "FrameworkResult",
    "HardBodySweepResult",
    "LatticeResult",
    "LatticeSweepResult",
    "PairResult",
    "PhaseDiagramResult",
    "PotentialResult",
    "PredictResult",
    "Result",
    "ScatteringResult",
    "SimulationResult",
    "ScoreResult",
    "StabilityResult",
    "SweepResult",
    "TrainResult",
    "TuneResult",
    "VoxelizeResult",
]

Numbers = NDArray[np.float64]


def _replica(directory: Path, salt_molar: float, replica: int) -> Path:
    """The folder of a simulation."""
    return directory / f"salt_{salt_molar:.6f}M" / f"replica_{replica}"


def _assembly_of(directory: Path) -> Assembly:
    """The assembly that a run was begun with, as its record names it."""
    record = directory / "run.json"
    if not record.exists():
        raise missing(f"{directory} holds no run.json, which names the assembly; finish the work first", record)
    named = json.loads(record.read_text(encoding="utf-8")).get("details", {}).get("assembly")
    if named is None:
        raise missing(f"{record} names no assembly; read it with pm.Assembly.read", record)
    return Assembly.read(directory / named)


def _trajectory(path: Path) -> Trajectory:
    if not path.exists():
        raise missing(f"there is no {path}; a run writes it after its equilibration, unless trajectory_every is 0", path)
    return Trajectory(path)


class SimulationResult(Result):
    """Averages of one simulation.

    Examples
    --------
    >>> run = pm.simulate("ring.json", salt="100mM", output="run")     # doctest: +SKIP
    >>> run.trajectory()[-1].positions_angstrom                        # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "sweep.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("sweep", "simulation")

    @classmethod
    def _fields_of(cls, directory: Path) -> Any:
        fields = super()._fields_of(directory)
        replicas = [replica for row in fields["replicas"] for replica in row]
        if len(replicas) != 1:
            raise ValueError(f"{directory} holds {len(replicas)} simulations; use SweepResult.read")
        effective = fields["salts"][0].get("effective_bodies")
        return replicas[0] if effective is None else {**replicas[0], "effective_bodies": effective}

    @property
    def trajectories(self) -> list[Path]:
        """The file of its trajectory; none if it was run with `trajectory_every=0`."""
        return sorted(self.directory.glob("salt_*/replica_*/trajectory.gsd"))

    def trajectory(self) -> Trajectory:
        """Opens its trajectory.

        Returns
        -------
        Trajectory
            The poses of production, frame by frame

        Raises
        ------
        MissingFileError
            If it has none; also a `FileNotFoundError`

        Examples
        --------
        >>> run.trajectory().positions_angstrom.shape                  # doctest: +SKIP
        (20, 4, 3)
        """
        found = self.trajectories
        return _trajectory(found[0] if found else self.directory / "trajectory.gsd")

    def assembly(self, frame: int | None = None) -> Assembly:
        """The assembly that the run was begun with, or its bodies at a frame.

        Parameters
        ----------
        frame
            A frame of the trajectory, counted from zero, or from the end if negative; the start if left out

        Returns
        -------
        Assembly

        Raises
        ------
        MissingFileError
            If the assembly or the trajectory is not there; also a `FileNotFoundError`
        IndexError
            If there is no such frame

        Examples
        --------
        >>> pm.export(run.assembly(-1), output="end.cif")              # doctest: +SKIP
        """
        return _at(_assembly_of(self.directory), self.trajectory()[frame] if frame is not None else None)

    @property
    def log(self) -> dict[str, NDArray[Any]]:
        """The columns of its log, one entry per sampled sweep, (T,) each."""
        return read_log(self._file(""))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Radius of gyration of the bodies' centres, Å, against the sweep, with its mean."""
        log = self.log
        ax = new_axes(ax)
        ax.plot(log["sweep"], log["r_g_angstrom"])
        ax.axhline(self._fields["r_g_angstrom"]["mean"], color="0.5", linestyle="--")
        ax.set_xlabel("sweep")
        ax.set_ylabel("radius of gyration (Å)")
        return ax


def _at(assembly: Assembly, frame: Any) -> Assembly:
    return assembly if frame is None else assembly.with_poses(frame.positions_angstrom, frame.orientations_wxyz)


class SweepResult(Result):
    """Stability against salt: one entry per salt concentration.

    Examples
    --------
    >>> sweep = pm.SweepResult.read("stability")                       # doctest: +SKIP
    >>> sweep.half_salt_molar                                          # doctest: +SKIP
    >>> sweep.trajectory(salt_molar=0.05, replica=1)[-1]               # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "sweep.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("sweep", "simulation")

    def _folders(self) -> list[Path]:
        """The folders of the simulations, by salt and replica as in the settings."""
        settings = self._fields["settings"]
        return [
            _replica(self.directory, salt, replica) for salt in settings["salt_M"] for replica in range(settings["replicas"])
        ]

    def _folder(self, salt_molar: float | None, replica: int) -> Path:
        settings = self._fields["settings"]
        salts: list[float] = settings["salt_M"]
        if salt_molar is None:
            if len(salts) > 1:
                unknown("salt concentration", None, salts)
            salt_molar = salts[0]
        salt = salts[nearest(salts, salt_molar, "salt concentration (mol/L)")]
        if replica not in range(settings["replicas"]):
            unknown("replica", replica, range(settings["replicas"]))
        return _replica(self.directory, salt, replica)

    @property
    def trajectories(self) -> list[Path]:
        """The files of the trajectories, by salt and replica; without those that a run does not have."""
        paths = (folder / "trajectory.gsd" for folder in self._folders())
        return [path for path in paths if path.exists()]

    def trajectory(self, *, salt_molar: float | None = None, replica: int = 0) -> Trajectory:
        """Opens the trajectory of one simulation.

        Parameters
        ----------
        salt_molar
            Its salt concentration, mol/L; may be left out if there is only one
        replica
            Its replica, counted from zero

        Returns
        -------
        Trajectory
            The poses of production, frame by frame

        Raises
        ------
        KeyError
            If there is no such salt or replica; it lists those that exist
        MissingFileError
            If the simulation has no trajectory; also a `FileNotFoundError`

        Examples
        --------
        >>> sweep.trajectory(salt_molar=0.05).positions_angstrom.shape         # doctest: +SKIP
        (20, 4, 3)
        """
        return _trajectory(self._folder(salt_molar, replica) / "trajectory.gsd")

    def log(self, *, salt_molar: float | None = None, replica: int = 0) -> dict[str, NDArray[Any]]:
        """The log of one simulation.

        Parameters
        ----------
        salt_molar, replica
            As in `trajectory`

        Returns
        -------
        dict
            Its columns, one entry per sampled sweep, (T,) each

        Raises
        ------
        KeyError
            If there is no such salt or replica; it lists those that exist

        Examples
        --------
        >>> sweep.log(salt_molar=0.05)["energy_kT"].mean()             # doctest: +SKIP
        """
        return read_log(self._folder(salt_molar, replica))

    def assembly(self, frame: int | None = None, *, salt_molar: float | None = None, replica: int = 0) -> Assembly:
        """The assembly that the sweep was begun with, or its bodies at a frame of one simulation.

        Parameters
        ----------
        frame
            A frame of the trajectory, counted from zero, or from the end if negative; the start if left out
        salt_molar, replica
            As in `trajectory`

        Returns
        -------
        Assembly

        Raises
        ------
        KeyError
            If there is no such salt or replica; it lists those that exist
        MissingFileError
            If the assembly or the trajectory is not there; also a `FileNotFoundError`

        Examples
        --------
        >>> pm.export(sweep.assembly(-1, salt_molar=0.3), output="end.cif")    # doctest: +SKIP
        """
        opened = None if frame is None else self.trajectory(salt_molar=salt_molar, replica=replica)[frame]
        return _at(_assembly_of(self.directory), opened)

    def _column(self, name: str) -> Numbers:
        # Results of earlier versions lack some columns.
        return numbers([row.get(name) for row in self._fields["salts"]])

    @property
    def salt_molar(self) -> Numbers:
        """Salt concentrations, mol/L, (S,)."""
        return self._column("salt_M")

    @property
    def r_g_angstrom(self) -> Numbers:
        """Mean radius of gyration of the bodies' centres over the replicas, Å, (S,)."""
        return self._column("r_g_mean_angstrom")

    @property
    def r_g_sd_angstrom(self) -> Numbers:
        """Standard deviation of it between replicas, Å, (S,)."""
        return self._column("r_g_sd_angstrom")

    @property
    def r_g_se_angstrom(self) -> Numbers:
        """Standard error of it from the replicas' own, which are corrected for autocorrelation, Å, (S,)."""
        return self._column("r_g_se_angstrom")

    @property
    def native_contacts(self) -> Numbers:
        """Surviving fraction of the initial contacts, (S,); NaN if there were none."""
        return self._column("native_contacts_mean")

    @property
    def native_contacts_sd(self) -> Numbers:
        """Standard deviation of it between replicas, (S,)."""
        return self._column("native_contacts_sd")

    @property
    def largest_cluster(self) -> Numbers:
        """Mean number of bodies in the largest cluster, (S,)."""
        return self._column("largest_cluster_mean")

    @property
    def largest_cluster_sd(self) -> Numbers:
        """Standard deviation of it between replicas, (S,)."""
        return self._column("largest_cluster_sd")

    @property
    def contacts(self) -> Numbers:
        """Mean number of pairs of bodies in contact, (S,); NaN in results of earlier versions."""
        return self._column("contacts_mean")

    @property
    def contacts_sd(self) -> Numbers:
        """Standard deviation of it between replicas, (S,)."""
        return self._column("contacts_sd")

    @property
    def bound_fraction(self) -> Numbers:
        """Mean fraction of the bodies that touch another, (S,); NaN in results of earlier versions."""
        return self._column("bound_fraction_mean")

    @property
    def bound_fraction_sd(self) -> Numbers:
        """Standard deviation of it between replicas, (S,)."""
        return self._column("bound_fraction_sd")

    @property
    def energy_kt(self) -> Numbers:
        """Mean energy, kT, (S,)."""
        return self._column("energy_mean_kT")

    @property
    def energy_sd_kt(self) -> Numbers:
        """Standard deviation of it between replicas, kT, (S,)."""
        return self._column("energy_sd_kT")

    def plot(
        self,
        ax: Axes | None = None,
        *,
        quantity: Literal["r_g", "native_contacts", "contacts", "bound_fraction", "largest_cluster", "energy"] = "r_g",
    ) -> Axes:
        """A quantity against salt with the spread between replicas.

        Radius of gyration (Å), contacts, bodies that touch another, largest cluster, or energy (kT).
        """
        columns = {
            "r_g": ("r_g_mean_angstrom", "r_g_sd_angstrom", "radius of gyration (Å)"),
            "native_contacts": ("native_contacts_mean", "native_contacts_sd", "native contacts left"),
            "contacts": ("contacts_mean", "contacts_sd", "pairs of bodies in contact"),
            "bound_fraction": ("bound_fraction_mean", "bound_fraction_sd", "bodies that touch another"),
            "largest_cluster": ("largest_cluster_mean", "largest_cluster_sd", "bodies in the largest cluster"),
            "energy": ("energy_mean_kT", "energy_sd_kT", "energy (kT)"),
        }
        if quantity not in columns:
            unknown("quantity", quantity, columns)
        mean, deviation, label = columns[quantity]
        ax = new_axes(ax)
        ax.errorbar(self.salt_molar * 1000.0, self._column(mean), yerr=self._column(deviation), marker="o", capsize=3)
        ax.set_ylabel(label)
        return _against_salt(ax, self.salt_molar)


class CompareResult(Result):
    """Several sweeps side by side."""

    def plot(self, ax: Axes | None = None) -> Axes:
        """Radius of gyration against salt with the spread between replicas, a line for each sweep."""
        ax = new_axes(ax)
        salts = [numbers(sweep["salt_M"]) for sweep in self._fields["sweeps"]]
        for sweep, salt in zip(self._fields["sweeps"], salts):
            mean, deviation = numbers(sweep["r_g_mean_angstrom"]), numbers(sweep["r_g_sd_angstrom"])
            ax.errorbar(salt * 1000.0, mean, yerr=deviation, marker="o", capsize=3, label=sweep["name"])
        ax.set_ylabel("radius of gyration (Å)")
        ax.legend()
        return _against_salt(ax, np.concatenate(salts))


class LatticeResult(Result):
    """One run of a lattice of squares; lengths, times and energies in its units."""

    @property
    def log(self) -> dict[str, NDArray[Any]]:
        """The columns of its log, one entry per logged step, (T,) each."""
        return read_log(self._file("log.csv"))

    def plot(self, ax: Axes | None = None, *, quantity: str = "angle_spread") -> Axes:
        """A column of the log against time: `angle_spread` (rad), `strain_xx`, `checkerboard_fraction`, ..."""
        log = self.log
        if quantity not in log:
            unknown("column of the log", quantity, log)
        ax = new_axes(ax)
        ax.plot(log["time"], log[quantity])
        ax.set_xlabel("time")
        ax.set_ylabel(quantity.replace("_", " "))
        return ax


class LatticeSweepResult(Result):
    """Lattices of several rod lengths and κ: one entry of `conditions` for each."""

    _FILE: ClassVar[str | None] = "lattice.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("lattice sweep",)

    def plot(self, ax: Axes | None = None, *, quantity: str = "poisson_ratio_xy") -> Axes:
        """An estimate of the conditions against the length of the rods, a line for each κ, with its standard error."""
        rows = self._fields["conditions"]
        known = [name for name, value in rows[0].items() if isinstance(value, dict)]
        if quantity not in known:
            unknown("estimate", quantity, known)
        ax = new_axes(ax)
        for kappa in sorted({row["kappa"] for row in rows}):
            own = sorted((row for row in rows if row["kappa"] == kappa), key=lambda row: float(row["r0"]))
            r0 = numbers([row["r0"] for row in own])
            mean, error = (numbers([row[quantity][key] for row in own]) for key in ("mean", "error"))
            ax.errorbar(r0, mean, yerr=error, marker="o", capsize=3, label=f"κ = {kappa:g}")
        ax.set_xlabel("length of the rods r₀")
        ax.set_ylabel(quantity.replace("_", " "))
        ax.legend()
        return ax


class FrameworkResult(Result):
    """Elastic constants of a network of rods and hinges."""

    def plot(self, ax: Axes | None = None, *, quantity: Literal["e", "nu"] = "e") -> Axes:
        """Young's modulus (GPa), or the size of Poisson's ratio, against the direction of the load in the plane from y.

        Negative ratios are drawn with dashes. `ax` must be polar.
        """
        rows = self._fields["polar"]
        if not rows:
            raise ValueError("a network in three dimensions has no directions in a plane; see c_gpa")
        ax = new_axes(ax, subplot_kw={"projection": "polar"})
        if ax.name != "polar":
            raise ValueError('the axes are not polar; make them with subplot_kw={"projection": "polar"}')
        # Half a turn brings every direction back to itself.
        angle = np.deg2rad(np.concatenate([numbers([row["angle_deg"] for row in rows]) + turn for turn in (0.0, 180.0)]))
        angle = np.append(angle, angle[0] + 2.0 * np.pi)
        if quantity == "e":
            values = numbers([row["e_gpa"] for row in rows])
            ax.plot(angle, np.append(np.tile(values, 2), values[0]), label="E (GPa)")
        else:
            values = numbers([row["nu"] for row in rows])
            around = np.append(np.tile(values, 2), values[0])
            ax.plot(angle, np.where(around >= 0.0, around, np.nan), label="ν")
            ax.plot(angle, np.where(around < 0.0, -around, np.nan), linestyle="--", label="-ν")
        ax.legend()
        return ax


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

    def plot(self, ax: Axes | None = None, *, kind: Literal["salt", "map", "distance"] = "salt") -> Axes:
        """Draws the second virial coefficient against salt with its error, a line for each pH; as a map over salt and pH;
        or the potential of mean force (kT) against the distance (Å).

        The map needs several salts and pH values. Its colours are symmetric about zero: red for attraction.
        """
        if kind not in ("salt", "map", "distance"):
            raise ValueError(f"there is no plot of kind {kind!r}; choose salt, map or distance")
        if kind == "distance":
            return self._plot_distance(new_axes(ax))
        if np.any(np.isnan(self.salt_molar)):
            raise ValueError('the salt is not known, because a Debye length was stated; use kind="distance"')
        return self._plot_map(ax) if kind == "map" else self._plot_salt(new_axes(ax))

    def _plot_salt(self, ax: Axes) -> Axes:
        values, errors, label = self._b2()
        for name, own in self._lines():
            ax.errorbar(self.salt_molar[own] * 1000.0, values[own], yerr=errors[own], marker="o", capsize=3, label=name)
        ax.axhline(0.0, color="0.5", linewidth=0.8)
        ax.set_ylabel(label)
        ax.legend()
        return _against_salt(ax, self.salt_molar)

    def _plot_map(self, ax: Axes | None) -> Axes:
        salts, phs = np.unique(self.salt_molar), np.unique(self.ph[np.isfinite(self.ph)])
        if salts.size < 2 or phs.size < 2:
            raise ValueError("a map needs at least two salts and two pH values; call pm.pair with salt= and ph= of several each")
        values, _, label = self._b2()
        cells = np.full((phs.size, salts.size), np.nan)
        cells[np.searchsorted(phs, self.ph), np.searchsorted(salts, self.salt_molar)] = values
        limit = np.nanmax(np.abs(cells)) or 1.0
        ax = new_axes(ax)
        # Red where the bodies attract each other, as in the figure of the run.
        mesh = ax.pcolormesh(cells, cmap="RdBu", vmin=-limit, vmax=limit, edgecolors="white")
        ax.figure.colorbar(mesh, ax=ax, label=label)
        ax.set_xticks(np.arange(salts.size) + 0.5, [f"{salt:g}" for salt in salts * 1000.0])
        ax.set_yticks(np.arange(phs.size) + 0.5, [f"{ph:g}" for ph in phs])
        ax.set_xlabel("salt (mM)")
        ax.set_ylabel("pH")
        return ax

    def _plot_distance(self, ax: Axes) -> Axes:
        for row in self._fields["conditions"]:
            # Near the contact w(r) is all error; where there is no error it has no value.
            own = [at for at in row["mean_force"] if at["w_error_kt"] is not None and at["w_error_kt"] < 0.5]
            parts = [] if row["ph"] is None else [f"pH {row['ph']:g}"]
            parts += [] if row["salt_M"] is None else [f"{row['salt_M'] * 1000.0:g} mM"]
            distance, energy = (numbers([at[key] for at in own]) for key in ("distance_angstrom", "w_kt"))
            ax.plot(distance, energy, label=", ".join(parts) or None)
        ax.axhline(0.0, color="0.5", linewidth=0.8)
        ax.set_xlabel("distance of the origins (Å)")
        ax.set_ylabel("w (kT)")
        if ax.get_legend_handles_labels()[1]:
            ax.legend()
        return ax

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

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the share of the bodies in whole assemblies against salt, a line for each pH and concentration."""
        ax = new_axes(ax)
        for value in np.unique(self.ph):
            chosen = np.isnan(self.ph) if np.isnan(value) else self.ph == value
            for number, molar in enumerate(self.concentration_molar):
                name = f"{molar:.1e} M" if np.isnan(value) else f"{molar:.1e} M, pH {value:g}"
                order = np.argsort(self.salt_molar[chosen])
                salts, shares = self.salt_molar[chosen][order], self.yields[chosen][order, number]
                ax.plot(salts * 1000.0, shares, marker="o", label=name)
        ax.set_ylabel("bodies in whole assemblies")
        ax.set_ylim(0.0, 1.05)
        ax.legend()
        return _against_salt(ax, self.salt_molar)


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

    def plot(self, ax: Axes | None = None, *, quantity: Literal["structure_factor", "intensity", "clusters"] = "intensity") -> Axes:
        """Draws I(q) or S(q), a line for each salt, or the distribution of cluster sizes.

        Parameters
        ----------
        ax
            Axes of matplotlib; new ones if left out
        quantity
            What to draw

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        KeyError
            For another quantity

        Examples
        --------
        >>> seen.plot(quantity="structure_factor")                     # doctest: +SKIP
        """
        labels = {"structure_factor": "S(q) of the centres", "intensity": "I(q)", "clusters": "fraction of the bodies"}
        if quantity not in labels:
            unknown("quantity", quantity, labels)
        ax = new_axes(ax)
        names = [None if np.isnan(salt) else f"{salt * 1000.0:g} mM" for salt in self.salt_molar]
        if quantity == "clusters":
            sizes = np.arange(1, self.fraction_of_bodies.shape[1] + 1)
            for name, fractions in zip(names, self.fraction_of_bodies):
                ax.plot(sizes, fractions, marker="o", label=name)
            ax.set_xlabel("bodies in a cluster")
        else:
            for name, curve, errors in zip(names, getattr(self, quantity), getattr(self, f"{quantity}_error")):
                ax.errorbar(self.q_per_angstrom, curve, yerr=None if np.all(np.isnan(errors)) else errors, label=name)
            ax.set_xlabel("q (1/Å)")
            if quantity == "intensity":
                ax.set_yscale("log")
        ax.set_ylabel(labels[quantity])
        if any(names):
            ax.legend()
        return ax


class PotentialResult(Result):
    """A solved Poisson-Boltzmann equation."""

    @property
    def potentials_kt_per_e(self) -> Numbers:
        """The potential at the requested points, kT/e, (P,); NaN outside the grid."""
        return numbers(self._fields.get("potentials_kT_per_e") or [])

    def plot(self, ax: Axes | None = None, *, kind: Literal["histogram", "line"] = "histogram") -> Axes:
        """Draws the potentials at the requested points, kT/e: a histogram, or one value per point."""
        potentials = self.potentials_kt_per_e
        if potentials.size == 0:
            raise ValueError("no points were requested; call pm.potential with points=")
        ax = new_axes(ax)
        if kind == "line":
            ax.plot(np.arange(1, potentials.size + 1), potentials, marker="o")
            ax.set_xlabel("point")
            ax.set_ylabel("potential (kT/e)")
            return ax
        ax.hist(potentials[np.isfinite(potentials)], bins="auto")
        ax.set_xlabel("potential (kT/e)")
        ax.set_ylabel("points")
        return ax


class VoxelizeResult(Result):
    """A set of voxels made of structures."""

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the number of structures that became samples, and the numbers excluded by reason."""
        reasons = [exclusion["reason"] for exclusion in self._fields["excluded"]]
        counts = {"samples": self._fields["samples"], **{name: reasons.count(name) for name in sorted(set(reasons))}}
        ax = new_axes(ax)
        ax.bar(list(counts), list(counts.values()))
        ax.set_ylabel("structures")
        return ax


class TrainResult(Result):
    """Scores of a training, compared with predictions without voxels."""

    @property
    def history(self) -> dict[str, NDArray[Any]]:
        """The columns of `history.csv`, one entry per epoch, (E,) each; losses in nats."""
        return read_log(self._file("history.csv"))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Balanced accuracy on the test part with its 95 % interval, next to the baselines and guessing."""
        ax = new_axes(ax)
        accuracy = self._fields["balanced_accuracy"]
        interval = self._fields["bootstrap_95"]["balanced_accuracy"]
        reach = [[max(accuracy - interval["low"], 0.0)], [max(interval["high"] - accuracy, 0.0)]]
        baselines = self._fields["baselines"]
        ax.bar(["network"], [accuracy], yerr=reach, capsize=3)
        names = [name.replace("_", " ") for name in baselines]
        ax.bar(names, [baselines[name]["balanced_accuracy"] for name in baselines], color="0.7")
        ax.axhline(1.0 / len(self._fields["classes"]), color="0.3", linestyle="--")
        ax.set_ylim(0.0, 1.0)
        ax.set_ylabel("balanced accuracy")
        ax.tick_params(axis="x", rotation=30)
        return ax

    def plot_history(self, ax: Axes | None = None) -> Axes:
        """Losses of the training and the validation part, nats, against the epoch; a vertical line marks the kept epoch."""
        history = self.history
        ax = new_axes(ax)
        for part in ("training", "validation"):
            ax.plot(history["epoch"], history[f"{part}_loss_nats"], label=part)
        ax.axvline(self._fields["best_epoch"], color="0.5", linestyle="--")
        ax.set_xlabel("epoch")
        ax.set_ylabel("loss (nats)")
        ax.legend()
        return ax


class TuneResult(Result):
    """Trials of a search, best first."""

    @property
    def validation_loss_nats(self) -> Numbers:
        """Smallest loss of each trial on the validation part, nats, (N,); NaN where it diverged."""
        return numbers([trial["validation_loss_nats"] for trial in self._fields["trials"]])

    @property
    def learning_rate(self) -> Numbers:
        """Learning rate of each trial, (N,)."""
        return numbers([trial["settings"]["training"]["learning_rate"] for trial in self._fields["trials"]])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Smallest loss of each trial on the validation part, nats, against its learning rate."""
        ax = new_axes(ax)
        ax.plot(self.learning_rate, self.validation_loss_nats, marker="o", linestyle="none")
        ax.set_xscale("log")
        ax.set_xlabel("learning rate")
        ax.set_ylabel("validation loss (nats)")
        return ax


class PredictResult(Result):
    """Predictions for the samples of a set, one entry per sample that could be read."""

    @property
    def names(self) -> list[str]:
        """Names of the samples, N of them."""
        return [sample["name"] for sample in self._fields["samples"]]

    @property
    def predicted(self) -> list[str]:
        """The most probable class of each sample, N of them."""
        return [sample["predicted"] for sample in self._fields["samples"]]

    @property
    def probabilities(self) -> Numbers:
        """Probability of each class for each sample, (N, C), in the order of `classes`."""
        return np.array([sample["probabilities"] for sample in self._fields["samples"]], dtype=np.float64)

    @property
    def predicted_numbers(self) -> Numbers:
        """The predicted number of each sample, (N,); NaN if the network predicts classes that are not those of a number."""
        return numbers([sample.get("predicted_number") for sample in self._fields["samples"]])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the confusion matrix, with a separate row for samples of unknown class; of numbers, the predicted against the true
        ones."""
        if np.isfinite(self.predicted_numbers).any():
            return self._plot_numbers(ax)
        classes: list[str] = self._fields["classes"]
        samples = self._fields["samples"]
        rows = [*classes, "unknown"] if any(sample["class"] is None for sample in samples) else classes
        counts = np.zeros((len(rows), len(classes)))
        for sample in samples:
            counts[rows.index(sample["class"] or "unknown"), classes.index(sample["predicted"])] += 1
        ax = new_axes(ax)
        ax.imshow(counts, cmap="Blues")
        for (row, column), count in np.ndenumerate(counts):
            ax.text(column, row, f"{count:.0f}", ha="center", va="center")
        ax.set_xticks(range(len(classes)), classes)
        ax.set_yticks(range(len(rows)), rows)
        ax.set_xlabel("predicted")
        ax.set_ylabel("class")
        return ax

    def _plot_numbers(self, ax: Axes | None) -> Axes:
        known = np.array([sample["class"] is not None for sample in self._fields["samples"]])
        true = np.array([float(sample["label"]) for sample in self._fields["samples"] if sample["class"] is not None])
        ax = new_axes(ax)
        ax.plot(true, self.predicted_numbers[known], marker="o", linestyle="none")
        if true.size:
            ends = [true.min(), true.max()]
            ax.plot(ends, ends, color="0.5", linestyle="--")
        ax.set_xlabel("true number")
        ax.set_ylabel("predicted number")
        return ax


class BenchResult(Result):
    """Speeds of the engine."""

    def plot(self, ax: Axes | None = None) -> Axes:
        """Trial moves per CPU-second against the charges of a body, a line for each way to compute energies."""
        rows = self._fields.get("charges") or []
        if not rows:
            raise ValueError('only the table of charges can be drawn; call pm.bench without an assembly, with part=["charges"]')
        ax = new_axes(ax)
        for energy in dict.fromkeys(row["energy"] for row in rows):
            own = [row for row in rows if row["energy"] == energy]
            rates = [row["moves_per_cpu_second"] for row in own]
            ax.plot([row["charges"] for row in own], rates, marker="o", label=energy)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel("charges of a body")
        ax.set_ylabel("trial moves per CPU-second")
        ax.legend()
        return ax


def _against_salt(ax: Axes, salt_molar: Numbers) -> Axes:
    """The salt axis; logarithmic unless a concentration is zero."""
    from matplotlib.ticker import LogLocator, NullFormatter

    if np.all(salt_molar > 0.0):
        ax.set_xscale("log")
        # Plain labels 20, 50, 100: otherwise less than two decades would be labelled illegibly densely.
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel("salt (mM)")
    return ax
