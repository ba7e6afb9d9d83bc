"""Atoms, centres, radii of gyration, radii, selections and net charges of the bundled structures against MDAnalysis.

The rules stand in docs/methods/surfaces.md and are written again here, on what MDAnalysis reads.
"""

import re
import warnings

import MDAnalysis
import numpy as np
import pytest
from MDAnalysis.guesser.tables import vdwradii
from MDAnalysis.lib.distances import distance_array

from conftest import ROOT, STRUCTURES, read_container

PROTEASE = ROOT / "data" / "structures" / "4e43.pdb.gz"
BPTI = ROOT / "data" / "structures" / "5pti.cif.gz"
HEAVY = "not (element H D or name H* D* [123]H*)"
PROTEIN = f"protein and {HEAVY}"
SINGLE_PRECISION = 4e-6  # of MDAnalysis's coordinates up to some 50 Å


def universe(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return MDAnalysis.Universe(str(path))


def one_conformer(atoms, letter=None):
    """Per residue the letter of highest mean occupancy or the requested one; an atom without it by its own occupancy."""
    chosen = []
    for residue in atoms.residues:
        here = residue.atoms & atoms
        letters = sorted({mark for mark in here.altLocs if mark.strip()})
        mean = {mark: here.occupancies[here.altLocs == mark].mean() for mark in letters}
        best = letter if letter in letters else max(letters, key=lambda mark: (mean[mark], -ord(mark)), default="")
        for name in dict.fromkeys(here.names):
            same = [atom for atom in here if atom.name == name]
            chosen.append(max(same, key=lambda atom: (atom.altLoc == best, not atom.altLoc.strip(), atom.occupancy)))
    return MDAnalysis.AtomGroup(chosen)


def ingest(folder, protomer, path, *options):
    outcome = protomer("ingest", path, "-o", folder, "--name", "x", "--force", "--quiet", "--json", *options)
    return outcome["files"][0], *read_container(folder / "x.body")[1:]


def in_space(header, arrays):
    """Positions in the coordinates of the file, Å."""
    return arrays["positions_angstrom"] + header["provenance"]["origin_angstrom"]


def require_equal_geometry(positions, origin, atoms):
    """Number and places of the atoms, their centre, and R_g about it (all atoms alike), Å."""
    assert len(positions) == atoms.n_atoms
    assert np.abs(positions - atoms.positions).max() < SINGLE_PRECISION
    assert np.abs(origin - atoms.center_of_geometry()).max() < SINGLE_PRECISION
    atoms.masses = 1.0
    r_g = np.sqrt(((positions - origin) ** 2).sum(axis=1).mean())
    assert abs(r_g - atoms.radius_of_gyration()) < SINGLE_PRECISION


@pytest.mark.parametrize("path", STRUCTURES, ids=lambda path: path.name)
def test_atoms_centre_and_radius_of_gyration(tmp_path, protomer, path):
    outcome, header, arrays = ingest(tmp_path, protomer, path)
    everything = universe(path)
    atoms = one_conformer(everything.select_atoms(PROTEIN))
    assert outcome["selection"]["records"] == everything.atoms.n_atoms
    assert outcome["atoms"] == atoms.n_atoms and outcome["residues"] == atoms.n_residues
    assert header["atom_names"] == list(atoms.names)
    names = [tuple(known[key] for key in ("chain", "number", "insertion_code", "name")) for known in header["residues"]]
    theirs = [(r.atoms[0].chainID, r.resid, r.icode.strip(), r.resname) for r in atoms.residues]
    assert names == theirs
    positions, origin = in_space(header, arrays), np.array(header["provenance"]["origin_angstrom"])
    require_equal_geometry(positions, origin, atoms)
    # Bondi's radii are in MDAnalysis, too.
    elements = [re.match("[A-Z]", name).group() for name in atoms.names]
    assert np.array_equal(arrays["radii_angstrom"], [vdwradii[element] for element in elements])
    # The comparison must notice nm for Å, exchanged axes, a mirror image, and a missing atom.
    for wrong in (positions / 10, positions[:, [1, 0, 2]], positions * [1, 1, -1], positions[1:]):
        with pytest.raises(AssertionError):
            require_equal_geometry(wrong, wrong.mean(axis=0), atoms)
    with pytest.raises(AssertionError):
        require_equal_geometry(positions, origin + 1e-3, atoms)


SELECTIONS = [
    (PROTEASE, ["--chain", "A"], f"{PROTEIN} and chainID A", None),
    (PROTEASE, ["--chain", "A,C"], f"{PROTEIN} and chainID A C", None),
    (PROTEASE, ["--altloc", "B"], PROTEIN, "B"),
    (PROTEASE, ["--chain", "B", "--keep-waters"], f"chainID B and (({PROTEIN}) or resname HOH)", None),
    (BPTI, ["--keep-waters"], f"({PROTEIN}) or (resname DOD and {HEAVY})", None),
    (BPTI, ["--altloc", "B"], PROTEIN, "B"),
    (BPTI, ["--keep-hydrogens"], "protein", None),
    (BPTI, ["--keep-ligands"], f"({PROTEIN}) or resname PO4 UNX", None),
    (PROTEASE, ["--keep-ligands"], f"({PROTEIN}) or resname ACT BME DMS GOL", None),
]


@pytest.mark.parametrize("path, options, selection, letter", SELECTIONS)
def test_selections(tmp_path, protomer, path, options, selection, letter):
    _, header, arrays = ingest(tmp_path, protomer, path, *options)
    everything = universe(path)
    atoms = one_conformer(everything.select_atoms(selection), letter)
    positions, origin = in_space(header, arrays), np.array(header["provenance"]["origin_angstrom"])
    require_equal_geometry(positions, origin, atoms)
    with pytest.raises(AssertionError):
        require_equal_geometry(positions, origin, one_conformer(everything.atoms, letter))


ACIDS = {"ASP": 3.8, "GLU": 4.5, "CYS": 9.0, "TYR": 10.0}
BASES = {"HIS": 6.5, "LYS": 10.5, "ARG": 12.5}
N_TERMINUS, C_TERMINUS = 8.0, 3.2


def net_charge(atoms, ph, sign=1.0):
    """Σ over titratable groups of q_protonated - 1 + 1 / (1 + 10^(pH - pKa)), disulfides left out; e."""
    acid = lambda pka: 1 / (1 + 10 ** (ph - pka)) - 1
    base = lambda pka: 1 / (1 + 10 ** (ph - pka))
    sulfurs = atoms.select_atoms("resname CYS and name SG")
    bonded = (distance_array(sulfurs.positions, sulfurs.positions) < 2.5).sum(axis=1) > 1 if len(sulfurs) else []
    total = -sum(acid(ACIDS["CYS"]) for is_bonded in bonded if is_bonded)
    for residue in atoms.residues:
        if residue.resname in ACIDS:
            total += sign * acid(ACIDS[residue.resname])
        elif residue.resname in BASES:
            total += base(BASES[residue.resname])
    for chain in set(atoms.chainIDs):
        # None of the files lists unobserved residues beyond its first or last.
        residues = atoms.select_atoms(f"chainID {chain}").residues
        total += base(N_TERMINUS) if "N" in residues[0].atoms.names else 0.0
        total += acid(C_TERMINUS) if "C" in residues[-1].atoms.names else 0.0
    return total


def require_equal_charge(ours, theirs):
    assert ours == pytest.approx(theirs, abs=1e-9)


@pytest.mark.parametrize("ph", [4.0, 7.4, 10.0])
@pytest.mark.parametrize("path", STRUCTURES, ids=lambda path: path.name)
def test_net_charges(tmp_path, protomer, path, ph):
    atoms = one_conformer(universe(path).select_atoms(PROTEIN))
    theirs = net_charge(atoms, ph)
    for model in ("force-field", "formal"):
        outcome, _, arrays = ingest(tmp_path, protomer, path, "--ph", ph, "--charges", model)
        print(f"{path.name} pH {ph} {model}: {outcome['net_charge_e']} and {theirs}")
        require_equal_charge(outcome["net_charge_e"], theirs)
        require_equal_charge(arrays["charges_e"].sum(), theirs)
    # The comparison must notice a sign and a pH.
    for wrong in (net_charge(atoms, ph, sign=-1.0), net_charge(atoms, ph + 0.1), -theirs):
        with pytest.raises(AssertionError):
            require_equal_charge(outcome["net_charge_e"], wrong)
