"""Structure files that users of other programs reported, against the right answers.

    python tests/validation/troublesome.py PROTOMER FOLDER

FOLDER holds the files that the table below names. All peptides are residues 1-20 (162 heavy atoms, +1.748 e at pH 7.4 with
free ends) or 52-58 (46 heavy atoms, +0.775 e) of 5PTI, or the whole protein. Charges are Henderson-Hasselbalch sums with the model
pKa values of docs/methods/interactions.md. Prints a row per file, and exits 1 if one differs.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

ONE, TWO, TAIL = 1.748, 3.497, 0.775
LIGANDS = ["--keep-ligands"]

# File, flags, atoms, net charge (e), words of a warning that must be there.
BODIES = [
    ("serial6.pdb", [], 162, ONE, ""),
    ("nme3.pdb", [], 46, TAIL, "heavy atoms of MET"),
    ("lysh.pdb", ["--chain", "A"], 162, ONE, ""),
    ("lysh.pdb", ["--mutate", "A:K15E"], 162, ONE - 1.998, ""),
    ("ter_blank.pdb", [], 324, TWO, "2 chains without a name"),
    ("segid.pdb", [], 324, TWO, "PROA, PROB"),
    ("ter_join.pdb", [], 324, TWO, "2 chains without a name"),
    ("two_models.pdb1", [], 162, ONE, "model 1 of 2 models"),
    ("cr.pqr", [], 162, None, ""),
    ("zn_same_id.pdb", LIGANDS, 163, ONE + 2, ""),
    ("zn3_het.pdb", LIGANDS, 165, ONE + 6, ""),
    ("zn3.cif", LIGANDS, 165, ONE + 6, ""),
    ("glup_disu.pdb", [], 162, ONE, "under the name GLUP"),
    ("all_number1.pdb", [], 162, ONE, "numbered from 1"),
    ("hd.pdb", ["--keep-hydrogens"], 178, ONE, ""),
    ("unk9999.pdb", [], 159, ONE, "3 unbuilt atoms"),
    ("twice.pdb", [], 162, ONE, "162 repeated atoms"),
    ("md_ions.pdb", LIGANDS, 166, ONE + 3, "SOD (1 kept): ligand, +1 e by its name"),
    ("cyana_q.pdb", [], 162, ONE, "25 pseudoatoms"),
    ("el_from_name.pdb", [], 454, 5.789, "state another element"),
    ("mse_after_ter.pdb", [], 454, 5.789, "selenomethionine"),
    ("pdb_named.pqr", [], 162, ONE, "this is PDB"),
    ("pqr_named.pdb", [], 162, None, "this is PQR"),
    ("bio_null.pdb", ["--assembly", "1"], 134, None, "names no chains"),
]

# File, words of the error.
ERRORS = [
    ("atam.pqr", [], "ATAM"),
    ("z.pdb.xz", [], "xz"),
    *[
        ("mutate_me.pqr", flags, flags[0])
        for flags in (["--mutate", "A:K15E"], ["--ph", "4"], ["--chain", "B"], ["--model", "3"], ["--assembly", "1"])
    ],
]

# File, volume (Å³), with the tolerance of the mesh.
VOLUMES = [("cyana_q.pdb", 2059.6), ("el_from_name.pdb", 6524.0), ("twice.pdb", 2059.6)]

# File, copies of each kind of chain.
COPIES = [("ter_blank.pdb", [2]), ("segid.pdb", [2]), ("lysh.pdb", [1])]


class Answers:
    """Runs the binary and counts what differs."""

    def __init__(self, binary, folder):
        self.binary, self.folder = Path(binary).resolve(), Path(folder).resolve()
        self.wrong = set()
        self.files = set()

    def run(self, *arguments):
        with tempfile.TemporaryDirectory() as output:
            command = [self.binary, *arguments, "-o", output, "--json"]
            process = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=120)
        return json.loads(process.stdout or "{}"), process.stderr

    def ingest(self, file, flags):
        answer, errors = self.run("ingest", file, *flags)
        outcome = answer["files"][0] if answer else {"error": errors}
        return outcome, "\n".join(outcome.get("warnings") or [])

    def report(self, file, what, is_right):
        self.files.add(file)
        if not is_right:
            self.wrong.add(file)
        print(f"{'ok   ' if is_right else 'WRONG'} {file:18} {what}")


def check_bodies(answers):
    for file, flags, atoms, charge, words in BODIES:
        outcome, warnings = answers.ingest(file, flags)
        found_atoms, found_charge = outcome.get("atoms"), outcome.get("net_charge_e")
        is_right = found_atoms == atoms and words in warnings
        is_right &= charge is None or (found_charge is not None and abs(found_charge - charge) < 1e-3)
        shown = "no body" if found_charge is None else f"{found_atoms} atoms, {found_charge:+.3f} e"
        answers.report(file, f"{' '.join(flags)} {shown}: {warnings or outcome.get('error')}", is_right)


def check_errors(answers):
    for file, flags, words in ERRORS:
        outcome, _ = answers.ingest(file, flags)
        error = outcome.get("error") or ""
        answers.report(file, f"{' '.join(flags)} {error or 'no error'}", words in error)


def check_volumes(answers):
    for file, volume in VOLUMES:
        found = answers.ingest(file, [])[0].get("mesh_volume_angstrom3", 0.0)
        answers.report(file, f"{found:.1f} Å³", abs(found / volume - 1) < 1e-3)


def check_copies(answers):
    for file, copies in COPIES:
        answer, errors = answers.run("assemble", "structure", file)
        found = [len(body["chains"]) for body in answer.get("bodies", [])]
        answers.report(file, f"copies {found} {errors}".strip(), found == copies)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    answers = Answers(*sys.argv[1:])
    for check in (check_bodies, check_errors, check_volumes, check_copies):
        check(answers)
    print(f"{len(answers.files - answers.wrong)} of {len(answers.files)} files are right")
    sys.exit(1 if answers.wrong else 0)


if __name__ == "__main__":
    main()
