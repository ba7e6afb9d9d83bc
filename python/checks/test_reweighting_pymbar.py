"""Curves from all frames of a sweep, by pymbar from the energies that `reweight` writes."""

import csv
import json

import numpy as np
import pymbar
import pytest

from conftest import sphere_mesh_off

SALTS_MOLAR = (0.05, 0.1, 0.3)


@pytest.fixture(scope="module")
def weighted(tmp_path_factory, protomer):
    """The answer of `reweight` and the rows of its frames."""
    folder = tmp_path_factory.mktemp("reweight")
    (folder / "ball.off").write_text(sphere_mesh_off(8.0, bands=4))
    for name, charge in [("plus", 5), ("minus", -5)]:
        (folder / f"{name}.xyzq").write_text(f"3 0 0 {charge}\n-3 0 0 1\n")
        protomer("body", "--mesh", folder / "ball.off", "--charges", folder / f"{name}.xyzq", "-o", folder / f"{name}.body", parse=False)
    placements = [
        {"body": ["plus", "minus"][k % 2], "position_angstrom": [18.0 * k, 0, 0], "orientation_wxyz": [1, 0, 0, 0]} for k in range(2)
    ]
    bodies = [{"name": name, "file": f"{name}.body"} for name in ["plus", "minus"]]
    assembly = {"box_angstrom": [100, 100, 100], "bodies": bodies, "placements": placements}
    (folder / "two.json").write_text(json.dumps(assembly))
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
