"""What a result draws, as data, and the one function that draws it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import unknown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """One axis: quantity and unit, and how it is divided."""

    label: str = ""
    log: bool = False
    range: tuple[float, float] | None = None
    ticks: tuple[ArrayLike, Sequence[str]] | None = None
    slanted: bool = False


@dataclass(frozen=True)
class Curve:
    """Points of one colour with their errors, joined by a line unless `line` is empty."""

    x: ArrayLike
    y: ArrayLike
    name: str | None = None
    error: ArrayLike | None = None
    error_x: ArrayLike | None = None
    marker: str = ""
    line: str = "-"
    colour: str | None = None

    def draw(self, ax: Axes) -> None:
        """Draws the points; those without error bars as a plain line."""
        style: dict[str, Any] = {"marker": self.marker, "linestyle": self.line, "label": self.name, "color": self.colour}
        if self.error is None and self.error_x is None:
            ax.plot(self.x, self.y, **style)
        else:
            ax.errorbar(self.x, self.y, yerr=self.error, xerr=self.error_x, capsize=3, **style)


@dataclass(frozen=True)
class Bars:
    """Bars by name."""

    names: Sequence[str]
    heights: ArrayLike
    error: Any = None
    colour: str | None = None

    def draw(self, ax: Axes) -> None:
        """Draws the bars."""
        ax.bar(list(self.names), self.heights, yerr=self.error, capsize=3, color=self.colour)


@dataclass(frozen=True)
class Counts:
    """How often values occur."""

    values: Numbers

    def draw(self, ax: Axes) -> None:
        """Draws a histogram."""
        ax.hist(self.values, bins="auto")


@dataclass(frozen=True)
class Cells:
    """A table of numbers as colours: symmetric about zero with a scale, or written into the cells."""

    values: Numbers
    label: str = ""
    written: bool = False

    def draw(self, ax: Axes) -> None:
        """Draws the table, its first row at the bottom, or at the top if the numbers are written."""
        if self.written:
            ax.imshow(self.values, cmap="Blues")
            for (row, column), value in np.ndenumerate(self.values):
                ax.text(column, row, f"{value:.0f}", ha="center", va="center")
            return
        limit = np.nanmax(np.abs(self.values)) or 1.0
        # Red where bodies attract each other, as in the figure of the run.
        mesh = ax.pcolormesh(self.values, cmap="RdBu", vmin=-limit, vmax=limit, edgecolors="white")
        ax.figure.colorbar(mesh, ax=ax, label=self.label)


@dataclass(frozen=True)
class Level:
    """A straight line at a value of y, or of x."""

    at: float
    vertical: bool = False
    dashed: bool = True

    def draw(self, ax: Axes) -> None:
        """Draws the line across the axes."""
        style: dict[str, Any] = {"linestyle": "--"} if self.dashed else {"linewidth": 0.8}
        (ax.axvline if self.vertical else ax.axhline)(self.at, color="0.5", **style)


Mark = Curve | Bars | Counts | Cells | Level


@dataclass(frozen=True)
class Chart:
    """Marks on two axes."""

    x: Axis
    y: Axis
    marks: Sequence[Mark] = field(default_factory=tuple)
    polar: bool = False

    def draw(self, ax: Axes | None) -> Axes:
        """Draws into the given axes, or into those of a new figure.

        Raises
        ------
        ValueError
            If the chart is polar and the given axes are not
        ImportError
            Without matplotlib
        """
        ax = new_axes(ax, **({"subplot_kw": {"projection": "polar"}} if self.polar else {}))
        if self.polar and ax.name != "polar":
            raise ValueError('the axes are not polar; make them with subplot_kw={"projection": "polar"}')
        for mark in self.marks:
            mark.draw(ax)
        for name, axis in (("x", self.x), ("y", self.y)):
            _divide(ax, name, axis)
        if ax.get_legend_handles_labels()[1]:
            ax.legend()
        return ax


def _divide(ax: Axes, name: str, axis: Axis) -> None:
    if axis.log:
        getattr(ax, f"set_{name}scale")("log")
    if axis.range is not None:
        getattr(ax, f"set_{name}lim")(*axis.range)
    if axis.ticks is not None:
        getattr(ax, f"set_{name}ticks")(*axis.ticks)
    if axis.slanted:
        ax.tick_params(axis="x" if name == "x" else "y", rotation=30)
    if axis.label:
        getattr(ax, f"set_{name}label")(axis.label)
    if axis.log and axis.label == _SALT:
        from matplotlib.ticker import LogLocator, NullFormatter

        # Plain labels 20, 50, 100: otherwise less than two decades would be labelled illegibly densely.
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())


_SALT = "salt (mM)"


def salt_axis(salt_molar: Numbers) -> Axis:
    """The salt axis; logarithmic unless a concentration is zero."""
    return Axis(_SALT, log=bool(np.all(salt_molar > 0.0)))


def carried(figure: dict[str, Any], quantity: str | None) -> Chart:
    """A panel of the figure that an answer carries: the first one, or the one with this label.

    Raises
    ------
    UnknownNameError
        If there is no such panel; it lists those that exist
    """
    panels = {panel["y"]["label"]: panel for panel in figure["panels"]}
    label = next(iter(panels)) if quantity is None else quantity
    if label not in panels:
        unknown("panel", quantity, panels)
    panel = panels[label]
    marks: list[Any] = []
    for number, series in enumerate(panel["series"]):
        marks += _marks(series, f"C{number}")
    return Chart(_axis(figure["x"]), _axis(panel["y"]), marks)


def _axis(axis: dict[str, Any]) -> Axis:
    return Axis(axis["label"], log=axis["log"], range=None if axis["range"] is None else tuple(axis["range"]))


def _marks(series: dict[str, Any], colour: str) -> list[Curve]:
    """The points of a series, the single measurements behind them, and intervals."""
    name = series["name"] or None
    marks = []
    if series["points"]:
        x, y, error = (_column(series["points"], key) for key in ("x", "y", "error"))
        line = "-" if series["line"] else ""
        bars = None if np.isnan(error).all() else error
        # A line with a few points has markers; a course of hundreds is a line.
        marker = "o" if not series["line"] or len(x) <= 30 else ""
        marks.append(Curve(x, y, name, bars, marker=marker, line=line, colour=colour))
    if series["replicas"]:
        measured = np.array(series["replicas"], dtype=np.float64)
        marks.append(Curve(measured[:, 0], measured[:, 1], None if marks else name, marker=".", line="", colour=colour))
    if series.get("spans"):
        x, y, low, high = (_column(series["spans"], key) for key in ("x", "y", "from", "to"))
        marks.append(Curve(x, y, None if marks else name, error_x=[x - low, high - x], marker="D", line="", colour=colour))
    return marks


def _column(rows: list[dict[str, Any]], key: str) -> Numbers:
    return np.array([np.nan if row.get(key) is None else row[key] for row in rows], dtype=np.float64)


def new_axes(ax: Axes | None, **settings: Any) -> Axes:
    """The given axes, or those of a new figure."""
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install './python[plot]' from the root of the project") from error
    axes: Axes = plt.subplots(**settings)[1]
    return axes
