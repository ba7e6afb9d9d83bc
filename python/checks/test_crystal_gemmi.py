"""Contacts of crystals against copies made by the operations and cells of gemmi, tried one by one."""

from itertools import product
from pathlib import Path

import gemmi
import numpy as np
import pytest
from scipy.spatial import cKDTree

import protomer as pm

ROOT = Path(__file__).parents[2]
CONTACT_ANGSTROM, FEWEST_CONTACTS = 4.5, 4


def chains(model):
    """Places and residues of the heavy atoms of each protein chain, the alternate location of highest occupancy."""
    found = {}
    for chain in model:
        places, residues = [], []
        for number, residue in enumerate(chain.get_polymer()):
            names = {}
            for atom in residue:
                if atom.element.name not in ("H", "D") and (atom.name not in names or atom.occ > names[atom.name].occ):
                    names[atom.name] = atom
            for atom in names.values():
                places.append(atom.pos.tolist())
                residues.append(number)
        if places and len(set(residues)) >= 10:
            found[chain.name] = np.array(places), np.array(residues)
    return found


def touching(structure):
    """Pairs of residues of each contact with enough of them, sorted; contacts of a chain with itself count once."""
    cell, units = structure.cell, chains(structure[0])
    group = gemmi.find_spacegroup_by_name(structure.spacegroup_hm).operations()
    orthogonal = np.array(cell.orth.mat.tolist())
    counts = []
    names = list(units)
    for i, first in enumerate(names):
        places, residues = units[first]
        tree = cKDTree(places)
        for second in names[i:]:
            fractional = np.linalg.solve(orthogonal, units[second][0].T).T
            own = []
            for operation in group:
                moved = np.array([operation.apply_to_xyz(place.tolist()) for place in fractional])
                for shift in product(range(-3, 4), repeat=3):
                    copy = (moved + shift) @ orthogonal.T
                    if first == second and np.abs(copy - places).max() < 0.5:
                        continue
                    low, high = copy.min(axis=0), copy.max(axis=0)
                    if (low > places.max(axis=0) + 5).any() or (high < places.min(axis=0) - 5).any():
                        continue
                    near = tree.query_ball_point(copy, CONTACT_ANGSTROM)
                    pairs = {(residues[j], units[second][1][k]) for k, found in enumerate(near) for j in found}
                    if len(pairs) >= FEWEST_CONTACTS:
                        own.append(len(pairs))
            # A copy and its inverse are one contact of a chain with itself.
            counts += sorted(own)[::2] if first == second else own
    return sorted(counts)


@pytest.mark.parametrize("entry", ["5pti.cif.gz", "4e43.pdb.gz"])
def test_contacts_of_a_crystal_are_those_of_gemmi(entry, tmp_path):
    file = ROOT / "data" / "structures" / entry
    scores = pm.score(file, crystal=True, columns=["contacts"], output=tmp_path / "scores")
    found = scores.columns_of_numbers()["residue_contacts"].astype(int)
    assert sorted(found.tolist()) == touching(gemmi.read_structure(str(file)))
