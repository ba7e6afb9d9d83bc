"""Converts keyword arguments to the words of a command, and its answer to a result."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias, TypeVar, Union

from . import _protomer
from ._result import Result

Path: TypeAlias = Union[str, "os.PathLike[str]"]
Paths: TypeAlias = Union[Path, Sequence[Path]]
Number: TypeAlias = Union[float, str]
"""A number in the documented unit, or text with a unit such as "150mM"."""
Numbers: TypeAlias = Union[Number, Sequence[Number]]
Integer: TypeAlias = Union[int, str]
"""A whole number, or text with a unit such as "500MB"."""
Integers: TypeAlias = Union[Integer, Sequence[Integer]]
Text: TypeAlias = Union[str, float, Sequence[Union[str, float]]]
"""Text as on the command line; sequences are joined with commas."""
Quantity: TypeAlias = Union[str, Sequence[str]]
"""Text with a unit such as "150mM", or several."""
Progress: TypeAlias = Callable[[int, int, str], None]
Client: TypeAlias = Any
"""A `distributed.Client`, or text: the address of a scheduler, or "local"."""

R = TypeVar("R", bound=Result)


def call(
    result: type[R],
    verb: Sequence[str],
    places: Sequence[object],
    flags: Mapping[str, object],
    progress: Progress | None,
    client: Client | None = None,
    parts: int | None = None,
) -> R:
    """Runs a verb and wraps its answer; with a client, workers do most of the work first."""
    words = list(verb)
    for flag, value in flags.items():
        words += _flag(flag, value)
    placed = [word for value in places for word in _words(value)]
    if placed:
        words += ["--", *placed]
    if client is not None:
        from . import _cluster

        _cluster.share_out(words, client, parts, progress)
        progress = None
    done, answer, warned = _protomer.call(words, progress)
    for line in warned:
        warnings.warn(line.removeprefix("warning: "), stacklevel=3)
    if not done:
        warnings.warn("some of the inputs failed; the result names them", stacklevel=3)
    output: Any = flags.get("--output")
    return result({} if answer is None else answer, output)


def _flag(flag: str, value: object) -> list[str]:
    if value is None or value is False:
        return []
    if value is True:
        return [flag]
    if isinstance(value, (list, tuple)) and flag not in _REPEATED:
        return [f"{flag}={','.join(map(_word, value))}"]
    # One word, so that values may start with a minus sign.
    return [f"{flag}={word}" for word in _words(value)]


# Flags that are repeated for each value; all others take a comma-separated list.
_REPEATED = frozenset({"--part"})


def _words(value: object) -> list[str]:
    if value is None:
        return []
    if isinstance(value, (list, tuple)):
        return [_word(item) for item in value]
    return [_word(value)]


def _word(value: Any) -> str:
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if isinstance(value, float):
        return repr(value)
    return str(value)
