"""Scores of many complexes: the table as arrays and as data frames."""

import numpy as np
import pytest

import protomer as pm
from conftest import ROOT

TABLE = ROOT / "data" / "complexes.csv"

COLUMNS = ["charge", "area"]


@pytest.fixture(scope="module")
def scores(tmp_path_factory):
    return pm.score(TABLE, columns=COLUMNS, output=tmp_path_factory.mktemp("scores") / "out")


def test_scores_are_counted_and_read_again(scores):
    assert (scores.rows, scores.failed) == (3, 1)
    assert scores.table.endswith("score.csv") and pm.ScoreResult.read(scores.directory) == scores


def test_columns_of_numbers_are_arrays_with_nan(scores):
    columns = scores.columns_of_numbers()
    area = columns["buried_area_angstrom2"]
    assert area.shape == (3,) and np.isnan(area[2]) and 3600 < area[0] < 3700
    assert "status" not in columns and "kind" not in columns


def test_the_table_is_a_data_frame(scores):
    pandas = pytest.importorskip("pandas")
    frame = scores.to_dataframe()
    assert isinstance(frame, pandas.DataFrame) and list(frame["status"]) == ["ok", "ok", "failed"]
    assert list(frame["kind"])[0] == "protease"


def test_further_columns_are_added(scores):
    more = pm.score(TABLE, columns=[*COLUMNS, "contacts"], output=scores.directory)
    assert more.columns_of_numbers()["residue_contacts"][0] == 117
    with pytest.raises(pm.ProtomerError, match="two salt concentrations"):
        pm.score(TABLE, columns="slope", output=scores.directory)
