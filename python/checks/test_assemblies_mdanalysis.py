"""Poses of the copies in an assembly, their RMSD and R_g, against the superpositions of MDAnalysis (quaternions, QCP).

One case is the dimer of the bundled protease, whose copies differ; the other is a file written here, whose biological
assembly is three exact copies about an axis.
"""

import gzip
import json

import MDAnalysis
import numpy as np
import pytest
from MDAnalysis.analysis import align

from conftest import ROOT, read_container, rotation_matrix
from test_structures_mdanalysis import PROTEIN, one_conformer, universe

PROTEASE = ROOT / "data" / "structures" / "4e43.pdb.gz"
FRAGMENT = ROOT / "data" / "structures" / "1bd2_short.pdb.gz"


def poses(folder):
    """Rotation matrices and positions (Å) of the assembly, which nothing moved."""
    assembly = json.loads((folder / "assembly.json").read_text())
    placements = assembly["placements"]
    assert not any(assembly["provenance"]["moved_angstrom"])
    positions = np.array([placement["position_angstrom"] for placement in placements])
    return [rotation_matrix(placement["orientation_wxyz"]) for placement in placements], positions


def common_atoms(reference, copy):
    """The atoms that both chains have, in the same order."""
    keys = [{(atom.resid, atom.name): atom for atom in chain} for chain in (reference, copy)]
    shared = [key for key in keys[0] if key in keys[1]]
    return [MDAnalysis.AtomGroup([of[key] for key in shared]).positions.astype(float) for of in keys]


def superposed(reference, copy, origin):
    """Rotation, place of the reference's origin in the copy (Å) and RMSD (Å), by MDAnalysis."""
    mobile, fixed = common_atoms(reference, copy)
    mobile_centre, fixed_centre = mobile.mean(axis=0), fixed.mean(axis=0)
    rotation, rmsd = align.rotation_matrix(mobile - mobile_centre, fixed - fixed_centre)
    return rotation, rotation @ (origin - mobile_centre) + fixed_centre, rmsd


def require_equal_pose(ours, theirs):
    """Rotation, position and RMSD, Å; MDAnalysis reads coordinates in single precision."""
    for mine, other, tolerance in zip(ours, theirs, (1e-6, 2e-5, 1e-6)):
        assert np.abs(np.asarray(mine) - other).max() < tolerance


def test_copies_of_a_dimer(tmp_path, protomer):
    outcome = protomer(
        "assemble", "structure", PROTEASE, "--chain", "A,B", "-o", tmp_path / "out", "--json", "--quiet"
    )
    (kind,) = outcome["bodies"]
    assert kind["chains"] == ["A", "B"]
    _, header, _ = read_container(tmp_path / "out" / "4e43_A.body")
    origin = np.array(header["provenance"]["origin_angstrom"])
    chains = {name: one_conformer(universe(PROTEASE).select_atoms(f"{PROTEIN} and chainID {name}")) for name in "AB"}
    reference = chains[kind["reference"]]
    assert np.abs(reference.center_of_geometry() - origin).max() < 4e-6
    for index, (rotation, position) in enumerate(zip(*poses(tmp_path / "out"))):
        ours = rotation, position, kind["rmsd_angstrom"][index]
        theirs = superposed(reference, chains[kind["chains"][index]], origin)
        print(f"chain {kind['chains'][index]}: RMSD {ours[2]} and {theirs[2]} Å, place {ours[1]} and {theirs[1]}")
        require_equal_pose(ours, theirs)
    # The comparison must notice the inverse rotation, nm for Å, and the other copy.
    wrong = [(rotation.T, *ours[1:]), (rotation, position / 10, ours[2]), (*ours[:2], ours[2] / 10)]
    for pose in wrong:
        with pytest.raises(AssertionError):
            require_equal_pose(pose, theirs)
    with pytest.raises(AssertionError):
        require_equal_pose(ours, superposed(reference, reference, origin))


# Turns by 120° about z, and no shift that an exchange of axes would leave alone.
OPERATORS = [
    (rotation_matrix([np.cos(np.pi * k / 3), 0, 0, np.sin(np.pi * k / 3)]), np.array([3.0 * k, 50.0 * k, -20.0 * k]))
    for k in range(3)
]


def write_biological_assembly(path):
    """The bundled fragment with REMARK 350, which makes three copies of its chain."""
    lines = ["REMARK 350 BIOMOLECULE: 1", "REMARK 350 APPLY THE FOLLOWING TO CHAINS: D"]
    for number, (rotation, shift) in enumerate(OPERATORS, 1):
        for row in range(3):
            values = "".join(f"{value:10.6f}" for value in rotation[row])
            lines.append(f"REMARK 350   BIOMT{row + 1}{number:4d}{values}{shift[row]:15.5f}")
    path.write_text("\n".join(line.ljust(80) for line in lines) + "\n" + gzip.open(FRAGMENT, "rt").read())


def test_copies_of_a_biological_assembly(tmp_path, protomer):
    write_biological_assembly(tmp_path / "three.pdb")
    outcome = protomer(
        "assemble", "structure", tmp_path / "three.pdb", "--assembly", 1, "-o", tmp_path / "out", "--json", "--quiet"
    )
    (kind,) = outcome["bodies"]
    assert len(kind["chains"]) == 3 and max(kind["rmsd_angstrom"]) < 1e-5
    atoms, fixed = (universe(tmp_path / "three.pdb").select_atoms(PROTEIN) for _ in range(2))
    _, header, _ = read_container(tmp_path / "out" / kind["file"].split("/")[-1])
    origin = np.array(header["provenance"]["origin_angstrom"])
    rotations, positions = poses(tmp_path / "out")
    start = fixed.positions.copy()
    for index, (rotation, shift) in enumerate(OPERATORS):
        fixed.positions = start
        fixed.rotate(rotation, point=(0, 0, 0)).translate(shift)
        theirs = superposed(atoms, fixed, origin)
        require_equal_pose((rotations[index], positions[index], kind["rmsd_angstrom"][index]), (*theirs[:2], 0.0))
        # The comparison must notice the inverse operator and nm for Å.
        if index > 0:
            for wrong in ((rotations[index].T, positions[index], 0.0), (rotations[index], positions[index] / 10, 0.0)):
                with pytest.raises(AssertionError):
                    require_equal_pose(wrong, (*theirs[:2], 0.0))


def require_equal_r_g(ours, theirs):
    assert ours == pytest.approx(theirs, abs=1e-5)


@pytest.mark.parametrize("chains", ["A,B", "A,B,C"])
def test_radius_of_gyration_of_an_assembly(tmp_path, protomer, chains):
    protomer("assemble", "structure", PROTEASE, "--chain", chains, "-o", tmp_path, "--json", "--quiet")
    seen = protomer("inspect", tmp_path / "assembly.json", "--salt", "100mM", "--energy", "none", "--json")
    ours = seen["r_g_angstrom"]
    placements = json.loads((tmp_path / "assembly.json").read_text())["placements"]
    bodies = MDAnalysis.Universe.empty(len(placements), trajectory=True)
    bodies.add_TopologyAttr("masses", np.ones(len(placements)))
    bodies.atoms.positions = np.array([placement["position_angstrom"] for placement in placements])
    theirs = bodies.atoms.radius_of_gyration()
    print(f"{chains}: R_g {ours} and {theirs} Å")
    require_equal_r_g(ours, theirs)
    # The comparison must notice nm for Å and a body that lies elsewhere.
    with pytest.raises(AssertionError):
        require_equal_r_g(ours, theirs / 10)
    bodies.atoms[0].position = -bodies.atoms[0].position
    with pytest.raises(AssertionError):
        require_equal_r_g(ours, bodies.atoms.radius_of_gyration())
