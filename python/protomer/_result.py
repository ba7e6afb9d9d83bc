"""The base of all results: the fields of a verb's JSON as attributes, lists of numbers as arrays."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import _protomer
from ._chart import Chart, carried
from ._errors import unknown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

R = TypeVar("R", bound="Result")


class Result:
    """The fields that `--json` prints.

    Numbers and text are attributes, objects are results themselves, and lists of numbers are NumPy arrays (null is NaN).
    `to_dict()` gives the plain values.

    Examples
    --------
    >>> result = pm.inspect("ring.json", salt="100mM")                 # doctest: +SKIP
    >>> result.energy_kT, result["energy_kT"]                          # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = None
    """The file of a directory that holds these fields."""
    _KINDS: ClassVar[tuple[str, ...]] = ()
    """How `run.json` calls such directories."""

    def __init__(
        self, fields: dict[str, Any] | list[Any], output: Path | str | None = None, figure: dict[str, Any] | None = None
    ) -> None:
        self._fields: dict[str, Any] = fields if isinstance(fields, dict) else {"items": fields}
        self._figure = figure
        # Absolute: the working directory may change.
        self._output = None if output is None else Path(output).absolute()

    @classmethod
    def read(cls: type[R], directory: Path | str) -> R:
        """Reads the result of work that is done, as the verb returned it.

        Parameters
        ----------
        directory
            The directory that the verb wrote into

        Returns
        -------
        Result
            Of the class that it is called on

        Raises
        ------
        MissingFileError
            If there is no such directory, or it holds no result of this kind yet; also a `FileNotFoundError`
        ProtomerError
            If the class has no file of its own, or the directory belongs to another verb

        Examples
        --------
        >>> pm.SweepResult.read("stability").salt_molar                # doctest: +SKIP
        >>> pm.PairResult.read("association").kd_molar                 # doctest: +SKIP
        """
        return cls(cls._fields_of(Path(directory)), directory)

    @classmethod
    def _fields_of(cls, directory: Path) -> Any:
        if cls._FILE is None:
            raise _protomer.ProtomerError(f"a {cls.__name__} is not kept in a directory; call its verb")
        if not directory.is_dir():
            raise missing(f"there is no directory {directory}", directory)
        record = directory / "run.json"
        kind = json.loads(record.read_text(encoding="utf-8")).get("kind") if record.exists() else None
        if kind is not None and kind not in cls._KINDS:
            raise _protomer.ProtomerError(f"{directory} holds a {kind}, which is no {cls.__name__}")
        file = directory / cls._FILE
        if not file.exists():
            raise missing(f"{directory} holds no {cls._FILE}; finish the work first", file)
        return json.loads(file.read_text(encoding="utf-8"))

    @property
    def directory(self) -> Path:
        """The directory, or the file, that the verb wrote.

        Raises
        ------
        ValueError
            If it was called without `output`
        """
        return self._file("")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return _value(self._fields[name])
        except KeyError:
            known = ", ".join(self._fields)
            raise AttributeError(f"{type(self).__name__} has no {name!r}; it has {known}") from None

    def __getitem__(self, name: str) -> Any:
        if name not in self._fields:
            unknown("field", name, self._fields)
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
        """The plain values, as in the JSON."""
        return self._fields

    def to_dataframe(self, rows: str | None = None) -> Any:
        """A list of objects as a table of pandas: a row for each, and a column for each field.

        Parameters
        ----------
        rows
            The field with the list; the first one if left out

        Returns
        -------
        pandas.DataFrame
            Fields of objects within a row have the names of both, `first_residue`; a mean with its error has two columns,
            `energy_kt` and `energy_kt_error`

        Raises
        ------
        KeyError
            If there is no such list; it names those that exist
        ImportError
            Without pandas

        Examples
        --------
        >>> held = pm.residues("stability", mutations=True)            # doctest: +SKIP
        >>> held.to_dataframe().nsmallest(10, "energy_kt")             # doctest: +SKIP
        >>> held.to_dataframe("mutations")["half_salt_molar"]          # doctest: +SKIP
        """
        import pandas

        lists = {name: value for name, value in self._fields.items() if _is_table(value)}
        if rows is None and lists:
            rows = next(iter(lists))
        if rows not in lists:
            unknown("list of objects", rows, lists)
        return pandas.DataFrame([_flat(row) for row in lists[rows]])

    def plot(self, ax: Axes | None = None, *, quantity: str | None = None, kind: str | None = None) -> Axes:
        """Draws a quantity of the result.

        Parameters
        ----------
        ax
            Axes of matplotlib; new ones if left out
        quantity
            What to draw, if there is a choice; the most telling one if left out. The guide to Python lists the choices, and so does
            the error for another name
        kind
            Another name for `quantity`

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        UnknownNameError
            If there is no such quantity; also a `KeyError`
        ValueError
            If the result has nothing to draw
        ImportError
            Without matplotlib

        Examples
        --------
        >>> pm.SweepResult.read("stability").plot(quantity="native_contacts")  # doctest: +SKIP
        """
        return self._chart(kind if quantity is None else quantity).draw(ax)

    def _chart(self, quantity: str | None) -> Chart:
        """What `plot` draws: a panel of the figure that the answer carries, by its label."""
        if self._figure is None:
            raise ValueError(f"this {type(self).__name__} has no figure; only the answer of some verbs carries one")
        return carried(self._figure, quantity)

    def _file(self, name: str) -> Path:
        """A file of the directory that the verb wrote into."""
        if self._output is None:
            raise ValueError(f"this {type(self).__name__} has no directory; call the verb with output=")
        return self._output / name


def _is_table(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(row, dict) for row in value)


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """A row without objects in it."""
    flat: dict[str, Any] = {}
    for name, value in row.items():
        if not isinstance(value, dict):
            flat[name] = value
        elif set(value) == {"mean", "error"}:
            flat |= {name: value["mean"], f"{name}_error": value["error"]}
        else:
            flat |= {f"{name}_{inner}": cell for inner, cell in _flat(value).items()}
    return flat


def missing(message: str, path: Path | str) -> _protomer.MissingFileError:
    """The error for a path that does not exist."""
    error = _protomer.MissingFileError(message)
    error.path = str(path)
    return error


def numbers(values: list[Any]) -> NDArray[np.float64]:
    """Numbers as an array; None is NaN."""
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, (int, float)) and not isinstance(value, bool))


def _value(value: Any) -> Any:
    if isinstance(value, dict):
        return Result(value)
    if not isinstance(value, list) or not value:
        return value
    if all(_is_number(item) for item in value) and any(item is not None for item in value):
        return numbers(value) if any(item is None for item in value) else np.array(value)
    if all(isinstance(item, list) and item and all(map(_is_number, item)) for item in value):
        return np.array(value, dtype=np.float64) if len({len(item) for item in value}) == 1 else value
    return [Result(item) if isinstance(item, dict) else item for item in value]


def _short(value: Any, length: int = 80) -> str:
    text = repr(value)
    return text if len(text) <= length else f"{text[: length - 1]}…"
