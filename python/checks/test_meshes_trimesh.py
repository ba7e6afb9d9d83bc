"""Areas, volumes, centroids and inertia of meshes against trimesh and coxeter.

`surface` prints area and volume of the mesh that it writes, `lattice square` the inertia of a body about an axis. For its
inertia coxeter sums absolute volumes of tetrahedra about the centroid, which holds for star-shaped bodies only: the
reference for a sphere is coxeter, and for a protein trimesh.
"""

import re

import coxeter
import numpy as np
import pytest
import trimesh

from conftest import ROOT, STRUCTURES, read_container, write_sphere_body

BPTI = ROOT / "data" / "structures" / "5pti.cif.gz"


def by_trimesh(vertices, faces):
    """Area, volume, centroid, inertia about it at unit density; Å."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight and mesh.is_winding_consistent
    return {"area": mesh.area, "volume": mesh.volume, "centroid": mesh.center_mass, "inertia": mesh.moment_inertia}


def by_coxeter(vertices, faces):
    """The same; coxeter's inertia is about the origin, so the shape is put there."""
    shape = coxeter.shapes.Polyhedron(vertices, faces, faces_are_convex=True)
    measures = {"area": shape.surface_area, "volume": shape.volume, "centroid": shape.centroid}
    shape.centroid = [0, 0, 0]
    return measures | {"inertia": shape.inertia_tensor}


def require_equal(ours, theirs, tolerance=1e-9):
    """What `ours` has, in parts of it; positions in Å."""
    for key, value in ours.items():
        assert np.allclose(value, theirs[key], rtol=tolerance, atol=1e-7 if key == "centroid" else 0), key


SINGLE_PRECISION = {"stl": 1e-5}
"""Formats that hold 32-bit numbers, with the tolerance for them."""


def written_mesh(path):
    mesh = trimesh.load(path, process=False, force="mesh")
    if path.suffix == ".stl":
        mesh.merge_vertices()  # the format holds triangles without common vertices
    return np.array(mesh.vertices), np.array(mesh.faces)


@pytest.mark.parametrize("structure", STRUCTURES, ids=lambda path: path.name)
def test_area_and_volume_of_surfaces(tmp_path, protomer, structure):
    outcome = protomer("surface", structure, "--density", "0.7", "-o", tmp_path / "mesh.ply", "--json")
    ours = {"area": outcome["mesh_area_angstrom2"], "volume": outcome["mesh_volume_angstrom3"]}
    vertices, faces = written_mesh(tmp_path / "mesh.ply")
    assert (len(vertices), len(faces)) == (outcome["vertices"], outcome["triangles"])
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    components = mesh.split(only_watertight=True)
    assert len(components) == outcome["components"]
    assert sum(1 - part.euler_number / 2 for part in components) == outcome["genus"]
    assert sum(part.volume < 0 for part in components) == outcome["cavities"]
    theirs = by_trimesh(vertices, faces)
    print(f"{structure.name}: area {ours['area']} and {theirs['area']}, volume {ours['volume']} and {theirs['volume']}")
    require_equal(ours, theirs)
    # The comparison must notice nm for Å, triangles that face inward, and a vertex that is off.
    moved = vertices.copy()
    moved[0] *= 1.01
    for wrong in (by_trimesh(vertices / 10, faces), by_trimesh(vertices, faces[:, ::-1]), by_trimesh(moved, faces)):
        with pytest.raises(AssertionError):
            require_equal(ours, wrong)


def test_every_mesh_format(tmp_path, protomer):
    """The formats that the error about another one names."""
    with pytest.raises(AssertionError, match="name it ") as refusal:
        protomer("surface", STRUCTURES[0], "-o", tmp_path / "mesh.unknown")
    suffixes = re.findall(r"\.([a-z]+)\b", str(refusal.value).split("name it ")[1].splitlines()[0])
    assert len(suffixes) >= 4
    for suffix in suffixes:
        require_same_mesh(tmp_path, protomer, suffix, tolerance=SINGLE_PRECISION.get(suffix, 1e-9))


def require_same_mesh(tmp_path, protomer, suffix, tolerance):
    outcome = protomer("surface", STRUCTURES[0], "--density", "0.7", "-o", tmp_path / f"mesh.{suffix}", "--json")
    ours = {"area": outcome["mesh_area_angstrom2"], "volume": outcome["mesh_volume_angstrom3"]}
    vertices, faces = written_mesh(tmp_path / f"mesh.{suffix}")
    assert (len(vertices), len(faces)) == (outcome["vertices"], outcome["triangles"])
    require_equal(ours, by_trimesh(vertices, faces), tolerance)
    with pytest.raises(AssertionError):
        require_equal(ours, by_trimesh(vertices * [1, 1, 1.001], faces), tolerance)


def test_a_nonconvex_surface_in_coxeter(tmp_path, protomer):
    outcome = protomer("surface", STRUCTURES[0], "--density", "0.3", "-o", tmp_path / "mesh.ply", "--json")
    ours = {"area": outcome["mesh_area_angstrom2"], "volume": outcome["mesh_volume_angstrom3"]}
    vertices, faces = written_mesh(tmp_path / "mesh.ply")
    theirs = by_coxeter(vertices, faces)
    require_equal(ours, theirs)
    others = by_trimesh(vertices, faces)
    require_equal({"centroid": others["centroid"]}, theirs)
    print("inertia about x, Å^5: trimesh", others["inertia"][0, 0], "coxeter", theirs["inertia"][0, 0])
    with pytest.raises(AssertionError):
        require_equal(ours, by_coxeter(vertices / 10, faces))


def our_inertia(protomer, body, folder):
    """The diagonal of the tensor in Å⁵ at unit density, from moments in units of m l²."""
    moments = []
    for axis in "xyz":
        found = protomer("lattice", "square", body, "--axis", axis, "-o", folder / f"{axis}.toml", "--json")
        moments.append(found["inertia"] * found["half_diagonal_angstrom"] ** 2)
    return np.array(moments)


def test_inertia_of_a_protein_equals_trimesh(tmp_path, protomer):
    outcome = protomer("ingest", BPTI, "-o", tmp_path, "--name", "x", "--json", "--quiet")["files"][0]
    _, _, arrays = read_container(tmp_path / "x.body")
    theirs = by_trimesh(arrays["vertices_angstrom"], arrays["triangles"])
    ours = {"inertia": our_inertia(protomer, tmp_path / "x.body", tmp_path) * outcome["mesh_volume_angstrom3"]}
    reading = {"inertia": np.diag(theirs["inertia"])}
    print("inertia, Å^5:", ours["inertia"], reading["inertia"])
    require_equal(ours, reading)
    # The comparison must notice exchanged axes and nm for Å.
    for wrong in (reading["inertia"][[2, 0, 1]], reading["inertia"] * 1e-5):
        with pytest.raises(AssertionError):
            require_equal(ours, {"inertia": wrong})


def test_inertia_of_a_sphere_equals_coxeter(tmp_path, protomer):
    body = write_sphere_body(tmp_path, protomer, "sphere", 10.0, 1.0, bands=6)
    _, _, arrays = read_container(body)
    theirs = by_coxeter(arrays["vertices_angstrom"], arrays["triangles"])
    ours = {"inertia": our_inertia(protomer, body, tmp_path) * theirs["volume"]}
    require_equal(ours, {"inertia": np.diag(theirs["inertia"])})
    with pytest.raises(AssertionError):
        require_equal(ours, {"inertia": np.diag(theirs["inertia"])[[2, 0, 1]]})
