"""The tables that verbs write, as arrays."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import Named
from ._result import missing


def read_log(path: Path | str) -> dict[str, NDArray[Any]]:
    """The columns of a log, or of any other table (CSV) of protomer.

    Parameters
    ----------
    path
        The file, or the directory of a simulation or a lattice run, whose `log.csv` is read; that of one replica of a sweep is
        `SWEEP/salt_0.030000M/replica_0`

    Returns
    -------
    dict
        An array (T,) for each column under its name in the file, which ends in the unit (`r_g_angstrom`, `energy_kT`): whole
        numbers as int64, other numbers as float64 with NaN where there is none, everything else as text. A `time` without a
        unit, as all lengths and energies of lattices, is in the units of the lattice. A name that it does not have raises a
        `KeyError` that lists the columns.

    Raises
    ------
    MissingFileError
        If there is no such file or directory; also a `FileNotFoundError`
    ValueError
        If rows and columns disagree

    Examples
    --------
    >>> log = pm.read_log("run")                               # doctest: +SKIP
    >>> log["sweep"], log["r_g_angstrom"].mean()               # doctest: +SKIP
    """
    file = _log_of(Path(path))
    with open(file, newline="", encoding="utf-8") as opened:
        rows = list(csv.reader(opened))
    if not rows:
        raise ValueError(f"{file} is empty; give a table with a heading")
    heading, *rows = rows
    for line, row in enumerate(rows, start=2):
        if len(row) != len(heading):
            raise ValueError(f"{file}:{line} has {len(row)} cells under {len(heading)} columns; is it still being written?")
    columns = {name: _column([row[place] for row in rows]) for place, name in enumerate(heading)}
    return Named(columns, what=f"column of {file.name}")


def _log_of(path: Path) -> Path:
    """The log of a simulation is in the folder of its only replica."""
    if not path.exists():
        raise missing(f"cannot read {path}: there is no such file or directory", path)
    if not path.is_dir():
        return path
    found = [path / "log.csv"] if (path / "log.csv").exists() else sorted(path.glob("salt_*/replica_*/log.csv"))
    if not found:
        raise missing(f"{path} holds no log.csv; give the directory of a simulation or of a lattice run", path)
    if len(found) > 1:
        raise ValueError(f"{path} holds {len(found)} logs; give the directory of one of them, such as {found[0].parent}")
    return found[0]


def _column(cells: list[str]) -> NDArray[Any]:
    for kind in (np.int64, np.float64):
        try:
            return np.array([kind(cell) if cell or kind is np.int64 else np.nan for cell in cells], dtype=kind)
        except (ValueError, OverflowError):
            continue
    return np.array(cells, dtype=str)
