"""Curves from all frames of a sweep, by pymbar from the energies that `reweight` writes."""

import csv

import numpy as np
import pymbar
import pytest

from conftest import write_row

SALTS_MOLAR = (0.05, 0.1, 0.3)


@pytest.fixture(scope="module")
def weighted(tmp_path_factory, protomer):
    """The answer of `reweight` and the rows of its frames."""
    folder = tmp_path_factory.mktemp("reweight")
    write_row(folder / "two.json", protomer, 2, charge=5, box=100, bands=4)
    protomer("sweep", folder / "two.json", "--salt", "50mM,100mM,300mM", "--replicas", 2, "--sweeps", 2000, "--equilibration", 100,
             "--trajectory-every", 10, "--exchange-every", 10, "--energy", "direct", "-o", folder / "sweep", "-q", parse=False)
    answer = protomer("reweight", folder / "sweep", "--salt", "50mM,100mM,300mM", "-o", folder / "curves", "-q", "--json")
    with open(folder / "curves" / "samples.csv") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    return answer, rows


def agrees_with_pymbar(answer, rows):
    rows = sorted(rows, key=lambda row: row["salt_M"])
    counts = np.array([sum(row["salt_M"] == salt for row in rows) for salt in SALTS_MOLAR])
    energies = np.array([[row[f"energy_at_{salt}M_kT"] for row in rows] for salt in SALTS_MOLAR])
    mbar = pymbar.MBAR(energies, counts, solver_protocol="robust")
    np.testing.assert_allclose(mbar.f_k - mbar.f_k[0], answer["free_energy_kT"], atol=1e-5)
    bound = np.array([row["bound_fraction"] for row in rows])
    points = answer["concentrations"][0]["points"]
    expected = mbar.compute_expectations(bound)["mu"]
    np.testing.assert_allclose([point["bound_fraction"]["mean"] for point in points], expected, atol=1e-6)


def test_curves_are_those_of_pymbar(weighted):
    answer, rows = weighted
    assert len(rows) == 960 and answer["frames"] == 960
    bound = [point["bound_fraction"]["mean"] for point in answer["concentrations"][0]["points"]]
    assert bound[0] > 2 * bound[-1] > 0, "the curve falls"
    agrees_with_pymbar(answer, rows)
    damaged = [{**row, "energy_at_0.1M_kT": 1.1 * row["energy_at_0.1M_kT"]} for row in rows]
    with pytest.raises(AssertionError):
        agrees_with_pymbar(answer, damaged)
