"""Odd structure files, made here, against gemmi's and Biopython's reading of them."""

import gemmi
import pytest
from Bio.PDB import PDBParser

# N, CA, C, O, CB of a residue of a straight chain, Å.
ATOMS = {"N": (0.0, 0.0), "CA": (1.2, 0.8), "C": (2.47, 0.0), "O": (2.5, -1.2), "CB": (1.2, 2.3)}


def line(serial, name, residue, chain, number, place, record="ATOM  ", element=None):
    x, y, z = place
    columns = f" {name:<3}" if len(name) < 4 else name
    serial = f"{serial:>5}"
    # Beyond 99999 the number grows to the left, into the name of the record.
    head = f"{record}{serial}" if len(serial) == 5 else f"{record[:5]}{serial}"
    return f"{head} {columns} {residue:>3} {chain}{number:>4}    {x:8.3f}{y:8.3f}{z:8.3f}  1.00 10.00          {element or name[0]:>2}\n"


def chain(letter, residues=4, beside=0.0, first_serial=1):
    lines, serial = [], first_serial
    for number in range(residues):
        for name, (x, y) in ATOMS.items():
            lines.append(line(serial, name, "ALA", letter, number + 1, (x + 3.8 * number, y + beside, 0.0)))
            serial += 1
    return "".join(lines)


def zincs(places):
    """Ions of one number, as several programs write them."""
    return "".join(line(900, "ZN", "ZN", "A", 1, (x, 60.0, 0.0), "HETATM", "ZN") for x in places)


def ingest(protomer, folder, text, *flags):
    path = folder / "odd.pdb"
    path.write_text(text)
    return path, protomer("ingest", path, "-o", folder / "out", "--json", *flags)["files"][0]


def gemmi_atoms(path):
    return [atom for chain in gemmi.read_structure(str(path))[0] for residue in chain for atom in residue]


CASES = {
    "serial numbers of six digits": (chain("A", first_serial=99_990), []),
    "ions of the number of a residue": (chain("A") + "TER\n" + zincs([0.0, 8.0, 16.0]), ["--keep-ligands"]),
    "a chain that begins again": (chain("A") + "TER\n" + chain("A", beside=30.0), []),
    "chains without a name": (chain(" ") + "TER\n" + chain(" ", beside=30.0), []),
}


@pytest.mark.parametrize("text, flags", CASES.values(), ids=CASES.keys())
def test_no_atom_is_lost_that_gemmi_reads(tmp_path, protomer, text, flags):
    path, outcome = ingest(protomer, tmp_path, text, *flags)
    atoms = len(gemmi_atoms(path))
    assert outcome["atoms"] == atoms
    # The comparison must notice a lost atom.
    _, fewer = ingest(protomer, tmp_path, "".join(text.splitlines(keepends=True)[1:]), "--force", *flags)
    with pytest.raises(AssertionError):
        assert fewer["atoms"] == atoms


def test_models_are_counted_as_biopython_counts_them(tmp_path, protomer):
    model = lambda number, beside: f"MODEL {number:>8}\n{chain('A', beside=beside)}TER\nENDMDL\n"
    path, outcome = ingest(protomer, tmp_path, model(1, 0.0) + model(2, 30.0) + "END\n")
    models = len(PDBParser(QUIET=True).get_structure("odd", str(path)))
    assert outcome["selection"]["models"] == models == 2
    assert any(f"1 of {models} models" in warning for warning in outcome["warnings"])


def test_residues_are_those_of_biopython(tmp_path, protomer):
    text = chain("A") + "TER\n" + zincs([0.0])
    path, outcome = ingest(protomer, tmp_path, text, "--keep-ligands")
    residues = sum(1 for _ in PDBParser(QUIET=True).get_structure("odd", str(path)).get_residues())
    assert outcome["residues"] == residues == 5
