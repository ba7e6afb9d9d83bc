"""Results of lattices and frameworks."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._chart import Axis, Chart, Curve
from ._errors import unknown
from ._log import read_log
from ._result import Result, numbers

Numbers = NDArray[np.float64]


class LatticeResult(Result):
    """One run of a lattice of squares; lengths, times and energies in its units."""

    @property
    def log(self) -> dict[str, NDArray[Any]]:
        """The columns of its log, one entry per logged step, (T,) each."""
        return read_log(self._file("log.csv"))

    def _chart(self, quantity: str | None) -> Chart:
        """A column of the log against time: `angle_spread` (rad), `strain_xx`, `checkerboard_fraction`, ..."""
        log, name = self.log, quantity or "angle_spread"
        if name not in log:
            unknown("column of the log", name, log)
        return Chart(Axis("time"), Axis(name.replace("_", " ")), [Curve(log["time"], log[name])])


class LatticeSweepResult(Result):
    """Lattices of several rod lengths and κ: one entry of `conditions` for each."""

    _FILE: ClassVar[str | None] = "lattice.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("lattice sweep",)

    def _chart(self, quantity: str | None) -> Chart:
        """An estimate of the conditions against the length of the rods, a line for each κ, with its standard error."""
        rows, name = self._fields["conditions"], quantity or "poisson_ratio_xy"
        known = [name for name, value in rows[0].items() if isinstance(value, dict)]
        if name not in known:
            unknown("estimate", name, known)
        curves = []
        for kappa in sorted({row["kappa"] for row in rows}):
            own = sorted((row for row in rows if row["kappa"] == kappa), key=lambda row: float(row["r0"]))
            mean, error = (numbers([row[name][key] for row in own]) for key in ("mean", "error"))
            curves.append(Curve(numbers([row["r0"] for row in own]), mean, f"κ = {kappa:g}", error, marker="o"))
        return Chart(Axis("length of the rods r₀"), Axis(name.replace("_", " ")), curves)


class FrameworkResult(Result):
    """Elastic constants of a network of rods and hinges."""

    def _chart(self, quantity: str | None) -> Chart:
        """Young's modulus (`e`, GPa), or the size of Poisson's ratio (`nu`), against the direction of the load in the plane from y.

        Negative ratios are drawn with dashes. The axes are polar.
        """
        rows = self._fields["polar"]
        if not rows:
            raise ValueError("a network in three dimensions has no directions in a plane; see c_gpa")
        if quantity not in (None, "e", "nu"):
            unknown("quantity", quantity, ["e", "nu"])
        # Half a turn brings every direction back to itself.
        angle = np.deg2rad(np.concatenate([numbers([row["angle_deg"] for row in rows]) + turn for turn in (0.0, 180.0)]))
        angle = np.append(angle, angle[0] + 2.0 * np.pi)
        values = numbers([row["nu" if quantity == "nu" else "e_gpa"] for row in rows])
        around = np.append(np.tile(values, 2), values[0])
        curves = [Curve(angle, around, "E (GPa)")]
        if quantity == "nu":
            positive, negative = np.where(around >= 0.0, around, np.nan), np.where(around < 0.0, -around, np.nan)
            curves = [Curve(angle, positive, "ν"), Curve(angle, negative, "-ν", line="--")]
        return Chart(Axis(), Axis(), curves, polar=True)
