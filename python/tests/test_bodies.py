"""Bodies as arrays."""

from pathlib import Path

import numpy as np
import pytest

import protomer as pm

BPTI = Path(__file__).resolve().parents[2] / "data" / "structures" / "5pti.cif.gz"

TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def test_a_body_is_arrays_in_angstrom_and_e(bodies):
    body = pm.Body.read(bodies / "plus.body")
    assert body.vertices_angstrom.shape[1] == body.triangles.shape[1] == 3
    assert body.triangles.max() == len(body.vertices_angstrom) - 1
    assert body.charges_e.shape == body.radii_angstrom.shape == (len(body.charge_positions_angstrom),)
    assert body.charges_e.sum() == pytest.approx(body.net_charge_e, abs=1e-9)
    # The volume by the divergence theorem, and the area, from the arrays alone.
    a, b, c = np.moveaxis(body.vertices_angstrom[body.triangles], 1, 0)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(body.volume_angstrom3, rel=1e-9)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(body.area_angstrom2, rel=1e-9)
    assert "plus" in repr(body) and "<table>" in body._repr_html_()


def test_the_hard_core_of_a_structure_lies_within_its_surface():
    body = pm.Body.from_structure(BPTI)
    a, b, c = np.moveaxis(body.core_vertices_angstrom[body.core_triangles], 1, 0)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert 0.5 * body.volume_angstrom3 < volume < body.volume_angstrom3
    hard = pm.Body.from_structure(BPTI, core="surface")
    assert hard.core_vertices_angstrom is None and hard.core_triangles is None


def test_a_titrated_body_has_the_capacitances_of_its_groups():
    body = pm.Body.from_structure(BPTI, ph=4.0, protonation="structure")
    assert body.capacitances_e2.shape == body.charges_e.shape
    # Acids near their pKa give; less than a quarter of e² for each of eight acids.
    assert 0.3 < body.capacitances_e2.sum() < 2.0
    assert pm.Body.from_structure(BPTI).capacitances_e2.size == 0


def test_a_body_comes_from_a_structure_without_leaving_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body = pm.Body.from_structure(BPTI, ph=7.4, name="bpti")
    assert body.name == "bpti" and body.net_charge_e == pytest.approx(5.79, abs=0.05)
    assert list(tmp_path.iterdir()) == []


def test_a_body_of_arrays_comes_back_from_its_file(tmp_path):
    made = pm.Body.from_arrays(
        vertices_angstrom=TETRAHEDRON,
        triangles=FACES,
        charge_positions_angstrom=[[0.5, 0.5, 0.5]],
        charges_e=[-1.5],
        name="pyramid",
    )
    assert made.volume_angstrom3 == pytest.approx(4.5) and made.net_charge_e == -1.5
    made.write(tmp_path / "pyramid.body")
    read = pm.Body.read(tmp_path / "pyramid.body")
    assert read.name == "pyramid"
    np.testing.assert_array_equal(read.vertices_angstrom, made.vertices_angstrom)
    np.testing.assert_array_equal(read.charge_positions_angstrom, made.charge_positions_angstrom)


def test_meshes_that_bound_nothing_are_refused():
    with pytest.raises(pm.GeometryError):
        pm.Body.from_arrays(vertices_angstrom=TETRAHEDRON, triangles=FACES[:3])
    with pytest.raises(pm.ProtomerError, match="vertex 9 of 4"):
        pm.Body.from_arrays(vertices_angstrom=TETRAHEDRON, triangles=[[0, 1, 9]])
    with pytest.raises(pm.ProtomerError, match=r"U\+000A"):
        pm.Body.from_arrays(name="a\nopen x", vertices_angstrom=TETRAHEDRON, triangles=FACES)
    with pytest.raises(pm.ProtomerError, match="2 charges at 1 positions"):
        pm.Body.from_arrays(
            vertices_angstrom=TETRAHEDRON, triangles=FACES, charge_positions_angstrom=[[1, 1, 1]], charges_e=[1, 2]
        )


def test_bodies_go_to_mdanalysis_and_back(bodies):
    pytest.importorskip("MDAnalysis", reason="MDAnalysis is not installed")
    body = pm.Body.read(bodies / "plus.body")
    universe = body.to_universe()
    assert len(universe.atoms) == len(body.charges_e)
    np.testing.assert_allclose(universe.atoms.positions, body.charge_positions_angstrom, atol=1e-4)
    np.testing.assert_allclose(universe.atoms.charges, body.charges_e)
    assert pm.Body.from_universe(universe).name == "universe"
    back = pm.Body.from_universe(universe, name="back")
    assert back.name == "back"
    # The file in between has three decimals; the surface is made again from the same atoms.
    assert back.volume_angstrom3 == pytest.approx(body.volume_angstrom3, rel=5e-3)
    assert back.net_charge_e == pytest.approx(body.net_charge_e, abs=0.05)


def test_plots_take_axes(bodies):
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    axes = pm.Body.read(bodies / "minus.body").plot(axes="xz")
    assert axes.get_ylabel() == "z (Å)"
