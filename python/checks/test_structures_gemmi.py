"""Atoms that ingest selects against gemmi's reading of the same files."""

import gemmi
import numpy as np
import pytest

from conftest import STRUCTURES


def gemmi_atoms(path):
    """Heavy protein atoms of the first model, one conformer, and whether each had an alternative."""
    structure = gemmi.read_structure(str(path))
    structure.setup_entities()
    structure.remove_hydrogens()
    structure.remove_ligands_and_waters()
    alternative = {
        (chain.name, residue.seqid.num, residue.seqid.icode.strip())
        for chain in structure[0]
        for residue in chain
        if any(atom.has_altloc() for atom in residue)
    }
    structure.remove_alternative_conformations()
    return [
        ((chain.name, residue.seqid.num, residue.seqid.icode.strip(), atom.name), np.array(atom.pos.tolist()))
        for chain in structure[0]
        for residue in chain
        for atom in residue
    ], alternative


def our_atoms(pqr):
    """Atoms of the exported PQR: residue number, name and position in the body's frame."""
    atoms = []
    for line in pqr.read_text().splitlines():
        if line.startswith(("ATOM", "HETATM")):
            words = line.split()
            atoms.append((words[2], np.array([float(word) for word in words[-5:-2]])))
    return atoms


def require_equal_atoms(ours, theirs, alternative):
    """The same atoms in the same order; places (Å) up to the frame's origin, which other alternatives may shift."""
    assert len(ours) == len(theirs)
    assert [name for name, _ in ours] == [key[3] for key, _ in theirs]
    plain = [index for index, (key, _) in enumerate(theirs) if key[:3] not in alternative]
    assert len(plain) > 0.5 * len(theirs)
    shift = np.array([theirs[index][1] - ours[index][1] for index in plain])
    assert np.abs(shift - shift.mean(axis=0)).max() < 2e-5


@pytest.mark.parametrize("path", STRUCTURES, ids=lambda path: path.name)
def test_atoms_equal_gemmi(tmp_path, protomer, path):
    outcome = protomer("ingest", path, "-o", tmp_path, "--name", "x", "--export", "pqr", "--json")["files"][0]
    theirs, alternative = gemmi_atoms(path)
    ours = our_atoms(tmp_path / "x.pqr")
    assert outcome["atoms"] == len(ours)
    require_equal_atoms(ours, theirs, alternative)
    # The comparison must notice nm for Å, exchanged axes, a mirror image, a missing atom, and atoms in another order.
    placed = lambda change: [(name, change(place)) for name, place in ours]
    wrong = [placed(lambda r: r / 10), placed(lambda r: r[[1, 0, 2]]), placed(lambda r: r * [1, 1, -1])]
    for atoms in [*wrong, ours[1:], ours[::-1]]:
        with pytest.raises(AssertionError):
            require_equal_atoms(atoms, theirs, alternative)
