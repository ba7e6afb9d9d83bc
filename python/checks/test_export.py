"""Exported assemblies, frames and bound poses, read by MDAnalysis and gemmi, against their own rotation of the source.

The poses come from the assembly, from the trajectory as the package gsd reads it, and from the JSON of `pair`.
"""

import json
import warnings

import gemmi
import gsd.hoomd
import MDAnalysis
import numpy as np
import pytest

from conftest import ROOT, read_container, rotation_matrix, write_assembly

BPTI = ROOT / "data" / "structures" / "5pti.cif.gz"
PROTEASE = ROOT / "data" / "structures" / "4e43.pdb.gz"
WRITTEN = 0.00052  # Å: three decimals, in single precision


def read_mdanalysis(path):
    """(chain, residue number, insertion code, residue, atom, element) and places, Å."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        atoms = MDAnalysis.Universe(str(path)).atoms
    keys = [
        (atom.chainID, int(atom.resid), atom.icode.strip(), atom.resname, atom.name, atom.element.upper()) for atom in atoms
    ]
    return keys, atoms.positions.astype(float)


def read_gemmi(path):
    keys, places = [], []
    for chain in gemmi.read_structure(str(path))[0]:
        for residue in chain:
            for atom in residue:
                number, code = residue.seqid.num, residue.seqid.icode.strip()
                keys.append((chain.name, number, code, residue.name, atom.name, atom.element.name.upper()))
                places.append(atom.pos.tolist())
    return keys, np.array(places)


def rotated_source(structure, body, rotation, position):
    """The atoms of a body at a pose, by rotating what gemmi reads from the source; all places of an atom that has several."""
    _, header, _ = read_container(body)
    kept = {
        (residue["chain"], residue["number"], residue["insertion_code"]): residue["name"] for residue in header["residues"]
    }
    origin = np.array(header["provenance"]["origin_angstrom"])
    source = gemmi.read_structure(str(structure))
    source.remove_hydrogens()
    atoms = {}
    for chain in source[0]:
        for residue in chain:
            key = (chain.name, residue.seqid.num, residue.seqid.icode.strip())
            if kept.get(key) != residue.name:
                continue
            for atom in residue:
                place = rotation @ (np.array(atom.pos.tolist()) - origin) + position
                named = (*key, residue.name, atom.name, atom.element.name.upper())
                atoms.setdefault(named, []).append(place)
    return atoms


def require_equal(read, chains, expected):
    """The same atoms at the same places; chains are those of the report: (copy, chain of the source)."""
    keys, places = read
    place_of = {(*chains[key[0]], *key[1:]): place for key, place in zip(keys, places)}
    assert len(place_of) == len(keys) == sum(map(len, expected))
    for copy, atoms in enumerate(expected):
        for key, places in atoms.items():
            assert np.abs(place_of[(copy, *key)] - np.array(places)).max(axis=1).min() < WRITTEN


def check_file(path, chains, expected):
    named = {chain["chain"]: (chain["copy"], chain["source_chain"]) for chain in chains}
    for reader in (read_mdanalysis, read_gemmi):
        keys, places = reader(path)
        require_equal((keys, places), named, expected)
    # The comparison must notice nm for Å, exchanged axes, exchanged copies, a lost atom, and another element.
    other = {name: (len(expected) - 1 - copy, source) for name, (copy, source) in named.items()}
    elements = [(*key[:5], "CA" if key[4] == "CA" else key[5]) for key in keys]
    broken = [
        (keys, places / 10, named),
        (keys, places[:, [1, 0, 2]], named),
        (keys, places, other),
        (keys[1:], places[1:], named),
        (elements, places, named),
    ]
    for keys, places, named in broken:
        with pytest.raises((AssertionError, KeyError)):
            require_equal((keys, places), named, expected)


TURNS = [([1, 0, 0, 0], [0, 0, 0]), ([0.5, 0.5, -0.5, 0.5], [60, 5, -7.25]), ([0.6, 0, 0.8, 0], [-50, 70.5, 11])]


@pytest.mark.parametrize("ending", ["pdb", "cif"])
@pytest.mark.parametrize("structure", [BPTI, PROTEASE], ids=["5pti", "4e43"])
def test_an_assembly(tmp_path, protomer, structure, ending):
    protomer("ingest", structure, "-o", tmp_path, "--name", "x", "--quiet", "--json")
    placements = [("x", at, turn) for turn, at in TURNS]
    assembly = write_assembly(tmp_path / "three.json", ["x"], placements)
    path = tmp_path / f"three.{ending}"
    report = protomer("export", assembly, "-o", path, "--json")
    expected = [
        rotated_source(structure, tmp_path / "x.body", rotation_matrix(turn), np.array(at, float)) for turn, at in TURNS
    ]
    assert report["atoms"] == sum(map(len, expected))
    check_file(path, report["chains"], expected)


@pytest.mark.parametrize("ending", ["pdb", "cif"])
def test_a_frame_of_a_simulation(tmp_path, protomer, ending):
    protomer("ingest", BPTI, "-o", tmp_path, "--name", "x", "--quiet", "--json")
    placements = [("x", at, turn) for turn, at in TURNS]
    assembly = write_assembly(tmp_path / "three.json", ["x"], placements, box=300)
    run = ["--equilibration", 5, "--sweeps", 30, "--trajectory-every", 10, "--quiet", "--json"]
    protomer("simulate", assembly, "--salt", "100mM", *run, "-o", tmp_path / "run")
    with gsd.hoomd.open(str(tmp_path / "run/salt_0.100000M/replica_0/trajectory.gsd")) as trajectory:
        frames = [(frame.particles.position, frame.particles.orientation) for frame in trajectory]
    assert len(frames) == 3
    for number, (positions, turns) in enumerate(frames):
        path = tmp_path / f"{number}.{ending}"
        report = protomer("export", tmp_path / "run", "--frame", number, "-o", path, "--json")
        assert (report["frame"], report["frames"], report["sweep"]) == (number, 3, 10 * number + 10)
        expected = []
        for position, turn in zip(positions.astype(float), turns.astype(float)):
            rotation = rotation_matrix(turn / np.linalg.norm(turn))
            expected.append(rotated_source(BPTI, tmp_path / "x.body", rotation, position))
        check_file(path, report["chains"], expected)


def test_a_trajectory_in_each_version_of_the_schema(tmp_path, protomer):
    run = ["--bodies", 27, "--packing-fraction", 0.3, "--equilibration", 0, "--sweeps", 30, "--trajectory-every", 10]
    protomer("hpmc", "run", "--shape", "cube", *run, "-o", tmp_path / "run", "--quiet", "--json")
    with gsd.hoomd.open(str(tmp_path / "run/trajectory.gsd")) as trajectory:
        frames = list(trajectory)
    for schema, numbers in [("1.4", (1, 4)), ("2.0", (2, 0))]:
        path = tmp_path / f"{schema}.gsd"
        report = protomer("export", tmp_path / "run", "-o", path, "--schema", schema, "--json")
        assert (report["schema"], report["frames"], report["bodies"]) == (schema, len(frames), 27)
        with gsd.hoomd.open(str(path)) as copy:
            assert copy.file.schema_version == numbers
            check_frames(copy, frames)
    # What another program writes in double precision comes back in either version.
    double = tmp_path / "double.gsd"
    with gsd.hoomd.open(str(double), "w", precision="double") as file:
        file.extend(frames)
    protomer("export", double, "-o", tmp_path / "single.gsd", "--schema", "1.4", "--json")
    with gsd.hoomd.open(str(tmp_path / "single.gsd")) as copy:
        check_frames(copy, frames)
        assert copy[0].particles.position.dtype == np.float32


def check_frames(copy, frames):
    assert len(copy) == len(frames) > 1
    for found, frame in zip(copy, frames):
        assert found.configuration.step == frame.configuration.step
        assert (found.particles.position == frame.particles.position).all()
        assert (found.particles.orientation == frame.particles.orientation).all()
        assert found.particles.type_shapes == frame.particles.type_shapes
        assert {name: value.tolist() for name, value in found.log.items()} == {
            name: value.tolist() for name, value in frame.log.items()
        }


def test_bound_poses(tmp_path, protomer):
    protomer("ingest", BPTI, "-o", tmp_path, "--name", "x", "--charges", "formal", "--quiet", "--json")
    pair = ["--salt", "300mM", "--relative-error", 0.1, "--most-directions", 4096]
    result = protomer("pair", tmp_path / "x.body", *pair, "-o", tmp_path / "pair", "--quiet", "--json")
    poses = result["conditions"][0]["poses"]
    folder = next((tmp_path / "pair").glob("salt_*")) / "poses"
    names = [f"pose_{number:02d}.{ending}" for number in range(1, len(poses) + 1) for ending in ("cif", "pdb")]
    assert poses and sorted(path.name for path in folder.iterdir()) == names
    chains = [{"chain": "A", "copy": 0, "source_chain": "A"}, {"chain": "B", "copy": 1, "source_chain": "A"}]
    for number, pose in enumerate(poses[:3], 1):
        rotation, position = rotation_matrix(pose["orientation_wxyz"]), np.array(pose["position_angstrom"])
        expected = [
            rotated_source(BPTI, tmp_path / "x.body", np.eye(3), np.zeros(3)),
            rotated_source(BPTI, tmp_path / "x.body", rotation, position),
        ]
        for ending in ("pdb", "cif"):
            check_file(folder / f"pose_{number:02d}.{ending}", chains, expected)


def test_the_matrices_lead_from_the_source_to_the_file(tmp_path, protomer):
    protomer("ingest", BPTI, "-o", tmp_path, "--name", "x", "--quiet", "--json")
    assembly = write_assembly(tmp_path / "three.json", ["x"], [("x", at, turn) for turn, at in TURNS])
    protomer("export", assembly, "-o", tmp_path / "three.cif", "--json")
    block = gemmi.cif.read(str(tmp_path / "three.cif")).sole_block()
    items = [f"matrix[{i}][{j}]" for i in (1, 2, 3) for j in (1, 2, 3)] + [f"vector[{i}]" for i in (1, 2, 3)]
    rows = [[float(value) for value in row] for row in block.find("_protomer_copy.", items)]
    _, header, _ = read_container(tmp_path / "x.body")
    origin = np.array(header["provenance"]["origin_angstrom"])
    assert len(rows) == 3
    for row, (turn, at) in zip(rows, TURNS):
        matrix, shift = np.array(row[:9]).reshape(3, 3), np.array(row[9:])
        assert np.abs(matrix - rotation_matrix(turn)).max() < 1e-9
        assert np.abs(matrix @ origin + shift - at).max() < 2e-5
    assert json.loads(assembly.read_text())["placements"][1]["position_angstrom"] == TURNS[1][1]
