"""The scores of many complexes."""

from __future__ import annotations

import csv
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._result import Result, numbers

Numbers = NDArray[np.float64]


class ScoreResult(Result):
    """Scores of many complexes: how many there are, how many failed, and the table.

    Examples
    --------
    >>> scores = pm.score("designs", columns=["energy", "area"], output="scores")      # doctest: +SKIP
    >>> scores.to_dataframe().sort_values("energy_kt_150mM")                                  # doctest: +SKIP
    >>> scores.to_dataframe().to_parquet("scores.parquet")                                    # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "score.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("scores",)

    def to_dataframe(self, rows: str | None = None) -> Any:
        """The table with a row for each complex, as a table of pandas.

        Parameters
        ----------
        rows
            A field with a list, as for other results; the table of all complexes if left out

        Raises
        ------
        ImportError
            Without pandas
        """
        import pandas

        return super().to_dataframe(rows) if rows else pandas.read_csv(self._file("score.csv"))

    def to_polars(self) -> Any:
        """The table with a row for each complex, as a table of polars.

        Raises
        ------
        ImportError
            Without polars
        """
        import polars

        return polars.read_csv(self._file("score.csv"))

    def columns_of_numbers(self) -> dict[str, Numbers]:
        """The columns that hold numbers, each an array of (N,); NaN where a value does not exist.

        Examples
        --------
        >>> scores.columns_of_numbers()["buried_area_angstrom2"].mean()                # doctest: +SKIP
        """
        with self._file("score.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        columns: dict[str, Numbers] = {}
        for name in rows[0] if rows else ():
            try:
                columns[name] = numbers([float(row[name]) if row[name] else None for row in rows])
            except ValueError:
                continue
        return columns
