"""The scores of many complexes."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._result import Result, numbers

if TYPE_CHECKING:
    import pandas
    import polars

Numbers = NDArray[np.float64]


class ScoreResult(Result):
    """Scores of many complexes: how many there are, how many failed, and the table.

    Examples
    --------
    >>> scores = pm.score("designs", columns=["energy", "area"], output="scores")      # doctest: +SKIP
    >>> scores.frame().sort_values("energy_kt_150mM")                                  # doctest: +SKIP
    >>> scores.frame().to_parquet("scores.parquet")                                    # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "score.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("scores",)

    def frame(self) -> pandas.DataFrame:
        """The table with a row for each complex, as a pandas `DataFrame`.

        Raises
        ------
        ImportError
            Without pandas
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("a data frame needs pandas: pip install pandas") from error
        return pandas.read_csv(self._file("score.csv"))

    def polars(self) -> polars.DataFrame:
        """The same table as a polars `DataFrame`.

        Raises
        ------
        ImportError
            Without polars
        """
        try:
            import polars
        except ImportError as error:
            raise ImportError("a data frame needs polars: pip install polars") from error
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
