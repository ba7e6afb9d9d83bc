"""What verbs answer: the fields of their JSON as attributes, lists of numbers as arrays."""

from __future__ import annotations

import html
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Result:
    """The fields that `--json` prints.

    Numbers and text are attributes, objects are results themselves, and lists of numbers are NumPy arrays (null is NaN).
    `to_dict()` gives the plain values.
    """

    def __init__(self, fields: dict[str, Any] | list[Any]) -> None:
        self._fields = fields if isinstance(fields, dict) else {"items": fields}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return _value(self._fields[name])
        except KeyError:
            known = ", ".join(self._fields)
            raise AttributeError(f"{type(self).__name__} has no {name!r}; it has {known}") from None

    def __getitem__(self, name: str) -> Any:
        return _value(self._fields[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Result) and self._fields == other._fields

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        shown = ", ".join(f"{name}={_short(value)}" for name, value in self._fields.items())
        return f"{type(self).__name__}({shown})"

    def _repr_html_(self) -> str:
        row = "<tr><th style='text-align:left'>{}</th><td style='text-align:left'>{}</td></tr>"
        rows = (row.format(html.escape(name), html.escape(_short(value))) for name, value in self._fields.items())
        return f"<table><caption>{type(self).__name__}</caption>{''.join(rows)}</table>"

    def to_dict(self) -> dict[str, Any]:
        """The plain values, as JSON has them."""
        return self._fields


class SweepResult(Result):
    """Stability against salt: one entry per salt concentration."""

    def _column(self, name: str) -> NDArray[np.float64]:
        return _array([row[name] for row in self._fields["salts"]])

    @property
    def salt_molar(self) -> NDArray[np.float64]:
        """Salt concentrations, mol/L, (S,)."""
        return self._column("salt_M")

    @property
    def r_g_angstrom(self) -> NDArray[np.float64]:
        """Mean radius of gyration of the bodies' centres over the replicas, Å, (S,)."""
        return self._column("r_g_mean_angstrom")

    @property
    def r_g_sd_angstrom(self) -> NDArray[np.float64]:
        """Standard deviation of it between replicas, Å, (S,)."""
        return self._column("r_g_sd_angstrom")

    @property
    def native_contacts(self) -> NDArray[np.float64]:
        """Surviving fraction of the contacts at the start, (S,)."""
        return self._column("native_contacts_mean")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Radius of gyration against salt with the spread of the replicas, on a logarithmic axis of salt."""
        ax = _axes(ax)
        from matplotlib.ticker import LogLocator, NullFormatter

        ax.errorbar(self.salt_molar * 1000.0, self.r_g_angstrom, yerr=self.r_g_sd_angstrom, marker="o", capsize=3)
        ax.set_xscale("log")
        # 20, 50, 100 as they are: less than two decades would otherwise be labelled so densely that nothing can be read.
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set_xlabel("salt (mM)")
        ax.set_ylabel("radius of gyration (Å)")
        return ax


class PotentialResult(Result):
    """A solved Poisson-Boltzmann equation."""

    @property
    def potentials_kt_per_e(self) -> NDArray[np.float64]:
        """The potential at the points asked for, kT/e, (P,); NaN outside the grid."""
        return _array(self._fields.get("potentials_kT_per_e") or [])


class TrainResult(Result):
    """Scores of a training beside those of what knows nothing of the voxels."""


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install 'protomer[plot]'") from error
    return plt.subplots()[1]


def _array(values: list[Any]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, (int, float)) and not isinstance(value, bool))


def _value(value: Any) -> Any:
    if isinstance(value, dict):
        return Result(value)
    if not isinstance(value, list) or not value:
        return value
    if all(_is_number(item) for item in value) and any(item is not None for item in value):
        return _array(value) if any(item is None for item in value) else np.array(value)
    if all(isinstance(item, list) and item and all(map(_is_number, item)) for item in value):
        return np.array(value, dtype=np.float64) if len({len(item) for item in value}) == 1 else value
    return [Result(item) if isinstance(item, dict) else item for item in value]


def _short(value: Any, length: int = 80) -> str:
    text = repr(value)
    return text if len(text) <= length else f"{text[: length - 1]}…"
