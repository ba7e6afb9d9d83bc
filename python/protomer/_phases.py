"""Results of hard bodies: equations of state and phases that coexist."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ._chart import Axis, Chart, Curve
from ._result import Result, numbers

Numbers = NDArray[np.float64]


class HardBodySweepResult(Result):
    """An equation of state: one entry of `points` for each condition.

    Examples
    --------
    >>> cubes = pm.hpmc.sweep("cubes", shape="cube", packing_fractions=[0.1, 0.2, 0.3])  # doctest: +SKIP
    >>> cubes.packing_fraction, cubes.compressibility_factor                              # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "equation.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("hard bodies sweep",)

    def _column(self, name: str) -> Numbers:
        return numbers([point.get(name) for point in self._fields["points"]])

    @property
    def packing_fraction(self) -> Numbers:
        """The part of the box that the bodies fill, (P,)."""
        return self._column("packing_fraction")

    @property
    def compressibility_factor(self) -> Numbers:
        """βP/ρ, (P,)."""
        return self._column("compressibility_factor")

    @property
    def compressibility_factor_error(self) -> Numbers:
        """Its standard error, (P,); NaN where it is not known."""
        return self._column("compressibility_factor_error")

    @property
    def free_volume_fraction(self) -> Numbers:
        """Free volume of the first depletant as a part of the box, (P,); NaN without depletants."""
        return self._column("free_volume_fraction")

    def _chart(self, quantity: str | None) -> Chart:
        """The compressibility factor against the packing fraction, with its standard error."""
        error = np.nan_to_num(self.compressibility_factor_error)
        curve = Curve(self.packing_fraction, self.compressibility_factor, error=error, marker="o")
        return Chart(Axis("packing fraction"), Axis("compressibility factor"), [curve])


class PhaseDiagramResult(Result):
    """Phases that coexist: one entry of `coexistences` for each pair.

    Examples
    --------
    >>> phases = pm.phase_diagram(size_ratio=0.5, reservoir="0.4,0.5,0.6")  # doctest: +SKIP
    >>> phases.packing_fractions, phases.reservoir_packing_fraction         # doctest: +SKIP
    """

    def _column(self, name: str) -> Numbers:
        return numbers([tie.get(name) for tie in self._fields["coexistences"]])

    @property
    def packing_fractions(self) -> Numbers:
        """Of both phases, ascending, (C, 2)."""
        pairs = [tie["packing_fractions"] for tie in self._fields["coexistences"]]
        return np.array(pairs, dtype=np.float64).reshape(-1, 2)

    @property
    def packing_fraction_errors(self) -> Numbers:
        """Their standard errors, (C, 2); NaN where phases were not measured."""
        unknown = [np.nan, np.nan]
        pairs = [tie.get("packing_fractions_error", unknown) for tie in self._fields["coexistences"]]
        return np.array(pairs, dtype=np.float64).reshape(-1, 2)

    @property
    def reservoir_packing_fraction(self) -> Numbers:
        """Packing fraction of the depletants in the reservoir, (C,); NaN without one."""
        return self._column("reservoir_packing_fraction")

    @property
    def pressure(self) -> Numbers:
        """Pressure of each coexistence, (C,)."""
        return self._column("pressure")

    @property
    def chemical_potential(self) -> Numbers:
        """Chemical potential of the bodies, (C,)."""
        return self._column("chemical_potential")

    def _chart(self, quantity: str | None) -> Chart:
        """Packing fractions of coexisting phases, joined, at the packing fraction of the reservoir."""
        heights = self.reservoir_packing_fraction
        if heights.size == 0 or np.any(np.isnan(heights)):
            raise ValueError("there is no coexistence with a reservoir to draw; call pm.phase_diagram with reservoir=")
        curves = []
        colours: dict[str, str] = {}
        errors = np.nan_to_num(self.packing_fraction_errors)
        for tie, ends, error, height in zip(self._fields["coexistences"], self.packing_fractions, errors, heights):
            name = ", ".join(tie["phases"])
            label = None if name in colours else name
            colour = colours.setdefault(name, f"C{len(colours)}")
            curves.append(Curve(ends, [height, height], label, error_x=error, marker="o", colour=colour))
        x = Axis("packing fraction of the bodies")
        return Chart(x, Axis("packing fraction of the depletants in the reservoir"), curves)
