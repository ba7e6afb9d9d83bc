"""Exceptions that are made in Python, and dictionaries that say which names they have."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NoReturn, TypeVar

from ._protomer import ProtomerError

V = TypeVar("V")


class UnknownNameError(KeyError, ValueError):
    """A name that is not there; the message lists those that are. A `KeyError`."""

    def __str__(self) -> str:
        # KeyError would show the representation of the message, in quotes.
        return str(self.args[0]) if self.args else ""


class PartialError(ProtomerError):
    """Some of the inputs failed; `result` holds the answer for the others, and what failed.

    Attributes
    ----------
    result
        The result of the verb, as if nothing had failed
    """

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result


class Named(dict[str, V]):
    """A dictionary whose KeyError lists the names that exist."""

    def __init__(self, values: Any = (), *, what: str = "entry") -> None:
        super().__init__(values)
        self._what = what

    def __missing__(self, name: object) -> V:
        unknown(self._what, name, self)

    def __reduce__(self) -> Any:
        return (_restored, (dict(self), self._what))


def _restored(values: dict[str, Any], what: str) -> Named[Any]:
    return Named(values, what=what)


def unknown(what: str, name: object, known: Iterable[object]) -> NoReturn:
    """Raises UnknownNameError with the names that exist."""
    names = ", ".join(map(str, known))
    raise UnknownNameError(f"there is no {what} {name!r}; {_list(names)}") from None


def _list(names: str) -> str:
    return f"there is {names}" if names and "," not in names else (f"there are {names}" if names else "there is none")


def failures(fields: Any) -> Sequence[str]:
    """The messages of the inputs that failed, from the answer of a verb."""
    found: list[str] = []
    if isinstance(fields, list):
        for item in fields:
            found += failures(item)
    elif isinstance(fields, dict):
        for value in fields.values():
            if isinstance(value, list):
                found += [item["error"] for item in value if isinstance(item, dict) and item.get("error")]
    return found
