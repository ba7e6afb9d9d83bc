"""Converts keyword arguments to the words of a command, and its answer to a result."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from . import _protomer
from ._errors import PartialError, failures
from ._objects import Files
from ._result import Result, missing

R = TypeVar("R", bound=Result)


def call(
    result: type[R],
    verb: Sequence[str],
    places: Sequence[object],
    flags: Mapping[str, object],
    progress: Callable[[int, int, str], None] | None,
    client: Any = None,
    parts: int | None = None,
    repeated: Sequence[str] = (),
) -> R:
    """Runs a verb and wraps its answer; with a client, workers do most of the work first.

    The program reads a flag in `repeated` once per value, and every other list from one word with commas.
    """
    output: Any = flags.get("--output")
    with Files(verb, output, replace=bool(flags.get("--force"))) as files:
        words, placed = words_of(verb, places, flags, files, repeated)
        if verb[0] in _GOES_ON:
            for word in placed:
                if not os.path.exists(word):
                    remedy = f"; protomer.fetch({word!r}) downloads the entry" if _ENTRY.fullmatch(word) else ""
                    raise missing(f"cannot read {word}: there is no such file or folder{remedy}", word)
        if placed:
            words += ["--", *placed]
        if client is not None:
            from . import _cluster

            _cluster.share_out(words, client, parts, progress)
            progress = None
        done, answer, warned, figure = _protomer.call(words, progress)
    for line in warned:
        warnings.warn(line.removeprefix("warning: "), stacklevel=3)
    answered = result({} if answer is None else answer, output, figure)
    if not done:
        failed = failures(answer)
        if failed:
            raise PartialError(f"{'; '.join(failed)} (the attribute 'result' holds the rest)", answered)
        warnings.warn("some of the work was not done; the result says what", stacklevel=3)
    return answered


def words_of(
    verb: Sequence[str],
    places: Sequence[object],
    flags: Mapping[str, object],
    files: Files,
    repeated: Sequence[str] = (),
) -> tuple[list[str], list[str]]:
    """The words of a command and those of its places, with objects written as files."""
    words = list(verb)
    for flag, value in flags.items():
        words += _flag(flag, files.named(value), once_per_value=flag in repeated)
    return words, [word for value in places for word in _words(files.named(value))]


# A verb that goes on if a file fails would count a wrong name among the failures.
_GOES_ON = frozenset({"ingest"})
# An entry of the Protein Data Bank.
_ENTRY = re.compile(r"[0-9][A-Za-z0-9]{3}|pdb_[A-Za-z0-9]{8}")


def salts(verb: str, salt: Any, salt_molar: Any, *, required: bool = False) -> Any:
    """The value of the flag for salt, from text with units or from numbers in mol/L.

    Raises
    ------
    ConfigError
        If both are given, or neither where one is required
    """
    if salt is not None and salt_molar is not None:
        raise _protomer.ConfigError("salt and salt_molar say the same; give one of them")
    if salt_molar is None:
        if salt is None and required:
            raise _protomer.ConfigError(f'{verb} needs a salt concentration; give salt="100mM" or salt_molar=0.1')
        _require_units(salt)
        return salt
    values = np.atleast_1d(np.asarray(salt_molar, dtype=np.float64))
    if values.ndim != 1 or values.size == 0:
        raise _protomer.ConfigError(f"salt_molar has the shape {values.shape}; give a number or a row of numbers in mol/L")
    return [f"{_word(float(value))}M" for value in values]


def _require_units(salt: Any) -> None:
    """Refuses numbers as `salt`, which may mean mol/L or mmol/L; zero is the same in both."""
    values = salt if _is_many(salt) else [salt]
    numbers = [value for value in values if isinstance(value, (int, float, np.number)) and not isinstance(value, bool)]
    if not any(numbers):
        return
    shown = ", ".join(f"{float(value):g}" for value in numbers)
    molar = [float(value) if float(value) < 1 else float(value) / 1e3 for value in numbers]
    one_or_all: Any = molar if _is_many(salt) else molar[0]
    texts = [f"{1e3 * value:g}mM" for value in molar]
    text: Any = texts if _is_many(salt) else texts[0]
    raise _protomer.ConfigError(
        f"salt has {'numbers' if len(numbers) > 1 else 'a number'} without a unit ({shown}); give salt_molar={one_or_all!r} in "
        f"mol/L, or salt={text!r}"
    )


def _flag(flag: str, value: object, *, once_per_value: bool) -> list[str]:
    if value is None or value is False:
        return []
    if value is True:
        return [flag]
    if _is_many(value) and not once_per_value:
        return [f"{flag}={','.join(_words(value))}"]
    # One word, so that values may start with a minus sign.
    return [f"{flag}={word}" for word in _words(value)]


def _is_many(value: object) -> bool:
    return isinstance(value, Iterable) and not isinstance(value, (str, bytes, os.PathLike))


def _words(value: Any) -> list[str]:
    if value is None:
        return []
    if _is_many(value):
        return [_word(item) for item in np.ravel(value).tolist()] if isinstance(value, np.ndarray) else [*map(_word, value)]
    return [_word(value)]


def _word(value: Any) -> str:
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    # Numbers of NumPy are floats too, but show their type.
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)
