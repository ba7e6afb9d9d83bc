"""Measured and computed pKa values of groups in proteins.

    python tests/validation/measured_pka.py FOLDER [STRUCTURES] [--protomer PATH] [--propka] [--entry ENTRY]

FOLDER holds measured.csv, such as the values of PKAD (Pahari, Sun and Alexov, Database 2019, baz024), with the columns
entry, chain, residue_number, residue, pka, uncertainty, exposed_percent, salt and others. STRUCTURES, or FOLDER itself,
holds ENTRY.pdb.gz. Residues are three-letter names, N-term or C-term. Runs `protomer titrate` once for each entry, with
--propka also PROPKA 3 (PyPI: propka), and prints the table of the page. Every program has the same groups in it; what is
left out is named. With --entry it prints the values of one entry.
"""

import argparse
import csv
import gzip
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

PH, SALT = 7, "100mM"
# Net charges are compared at this pH, where carboxylates titrate, for entries with so many values.
CHARGE_PH, MANY_VALUES = 4.5, 10
# Groups less exposed than this are buried.
BURIED_BELOW_PERCENT = 20.0
# A pKa that titrate cannot find lies beyond these.
LOWEST_PKA, HIGHEST_PKA = -2.0, 16.0
# PROPKA's value for a cysteine in a disulfide.
BONDED_PKA = 99.0
ACIDS = {"ASP", "GLU", "CYS", "TYR", "C-term"}
ENDS = {"N+": "N-term", "NTR": "N-term", "N-TERM": "N-term", "C-": "C-term", "CTR": "C-term", "C-TERM": "C-term"}
ORDER = ["ASP", "GLU", "HIS", "CYS", "TYR", "LYS", "ARG", "N-term", "C-term"]


class Group(NamedTuple):
    """A titratable group in a file."""

    chain: str
    number: int
    insertion_code: str
    residue: str


class Value(NamedTuple):
    """A measured pKa and what the programs say, by name."""

    group: Group
    measured: float
    exposed_percent: float | None
    computed: dict[str, float]


def residue_name(text):
    name = text.strip().upper()
    return ENDS.get(name, name)


def number(text):
    """A number, or None for an empty cell, a limit such as <2, or words."""
    try:
        value = float((text or "").strip().rstrip("%"))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def pka_or_limit(group):
    """The pKa of a group in the answer of titrate, or the limit beyond which it lies."""
    if group["pka"] is not None:
        return group["pka"]
    is_protonated = group["charge_e"] > (-0.5 if residue_name(group["residue"]) in ACIDS else 0.5)
    return HIGHEST_PKA if is_protonated else LOWEST_PKA


def titrated(answer):
    """pKa and model pKa by group, from the answer of titrate."""
    found = {}
    for group in answer["groups"]:
        code = (group["insertion_code"] or "").strip()
        key = Group(group["chain"], group["residue_number"], code, residue_name(group["residue"]))
        found[key] = {"model values": group["model_pka"], "protomer": pka_or_limit(group)}
    return found


def propka_values(path):
    """pKa by group, from PROPKA's mean over the conformations of a PDB file."""
    import propka.run

    molecule = propka.run.single(str(path), optargs=("--quiet",), write_pka=False)
    found = {}
    for group in molecule.conformations["AVR"].groups:
        name = residue_name(group.residue_type)
        if group.atom.type == "atom" and name in ORDER and group.pka_value < BONDED_PKA:
            key = Group(group.atom.chain_id.strip(), group.atom.res_num, group.atom.icode.strip(), name)
            found[key] = group.pka_value
    return found


def run_protomer(protomer, path):
    words = [protomer, "titrate", path, "--ph", PH, "--salt", SALT, "--json", "-q"]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip())
    return titrated(json.loads(done.stdout))


def run_propka(path):
    # PROPKA reads no compressed files and writes into the current folder if it writes.
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.name.removesuffix(".gz")
        plain.write_bytes(gzip.decompress(path.read_bytes()))
        return propka_values(plain)


def computed(arguments, path):
    """Values of all programs by group; groups that one of them lacks are left out."""
    found = run_protomer(arguments.protomer, path)
    if arguments.propka:
        theirs = run_propka(path)
        found = {key: {**values, "PROPKA": theirs[key]} for key, values in found.items() if key in theirs}
    return found


def measured_by_entry(path):
    """Rows of the table by entry."""
    entries = {}
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            entries.setdefault(row["entry"].strip().lower(), []).append(row)
    return entries


def group_in(row):
    """The group that a row measures, or None without a residue number; a number such as 52A has an insertion code."""
    match = re.fullmatch(r"\s*(-?\d+)\s*([A-Za-z]?)\s*", row["residue_number"])
    if match is None:
        return None
    return Group(row["chain"].strip(), int(match[1]), match[2], residue_name(row["residue"]))


def values_of_entry(arguments, entry, rows, structures):
    """Values of one entry; says on stderr which are left out."""
    path = structures.get(entry)
    if path is None:
        return left_out(entry, rows, "no structure")
    try:
        found = computed(arguments, path)
    except Exception as error:  # PROPKA has many of its own; one structure must not end the others
        return left_out(entry, rows, f"{type(error).__name__}: {error}")
    values = []
    for row in rows:
        group, measured = group_in(row), number(row["pka"])
        if measured is None:
            left_out(entry, [row], f"'{row['pka']}' is not a value")
        elif group not in found:
            left_out(entry, [row], "no such group in the structure, or not for every program")
        else:
            values.append(Value(group, measured, number(row["exposed_percent"]), found[group]))
    return values


def left_out(entry, rows, reason):
    for row in rows:
        place = f"{row['chain']} {row['residue']} {row['residue_number']}"
        print(f"{entry} {place}: left out, {reason}", file=sys.stderr)
    return []


def statistics(values, program):
    """Root mean square deviation, share off by more than one unit, mean of the computed less the measured value."""
    errors = [value.computed[program] - value.measured for value in values]
    rms = math.sqrt(sum(error**2 for error in errors) / len(errors))
    share = sum(abs(error) > 1.0 for error in errors) / len(errors)
    return rms, share, sum(errors) / len(errors)


def row_of(name, values, programs):
    cells = [name, str(len(values))]
    for program in programs:
        rms, share, mean = statistics(values, program)
        cells.append(f"{rms:.2f} ({100 * share:.0f} %, {mean:+.2f})")
    return "| " + " | ".join(cells) + " |"


def table(values, programs):
    chosen = [("all", values)]
    for name in ORDER:
        title = name if name.endswith("term") else name.capitalize()
        chosen.append((title, [value for value in values if value.group.residue == name]))
    known = [value for value in values if value.exposed_percent is not None]
    buried = [value for value in known if value.exposed_percent < BURIED_BELOW_PERCENT]
    exposed = [value for value in known if value.exposed_percent >= BURIED_BELOW_PERCENT]
    chosen.append((f"buried, below {BURIED_BELOW_PERCENT:g} % exposed", buried))
    chosen.append((f"exposed, {BURIED_BELOW_PERCENT:g} % and more", exposed))
    print("Each cell: RMSD (share off by more than one unit, mean of computed less measured)\n")
    print(f"| groups | number | {' | '.join(programs)} |")
    print("|---" * (2 + len(programs)) + "|")
    for name, part in chosen:
        if part:
            print(row_of(name, part, programs))


def charge_e(residue, pka, ph):
    """Charge of a group by the equation of Henderson and Hasselbalch, e."""
    protonated = 1.0 / (1.0 + 10.0 ** (ph - pka))
    return protonated - 1.0 if residue in ACIDS else protonated


def charge_errors(by_entry, program, ph):
    """Computed less measured charge of the measured groups of each entry, e."""
    errors = {}
    for entry, values in by_entry.items():
        error = 0.0
        for value in values:
            residue = value.group.residue
            error += charge_e(residue, value.computed[program], ph) - charge_e(residue, value.measured, ph)
        errors[entry] = error
    return errors


def charge_table(by_entry, programs):
    """Errors of the charge of all measured groups together, where there are many."""
    many = {entry: values for entry, values in by_entry.items() if len(values) >= MANY_VALUES}
    print(f"\nCharge of the measured groups at pH {CHARGE_PH:g}, {len(many)} entries with {MANY_VALUES} values and more (e)\n")
    print("| | mean of the size of the error | root mean square | largest |\n|---|---|---|---|")
    for program in programs:
        errors = charge_errors(many, program, CHARGE_PH)
        sizes = [abs(error) for error in errors.values()]
        worst = max(errors, key=lambda entry: abs(errors[entry]))
        rms = math.sqrt(sum(size**2 for size in sizes) / len(sizes))
        print(f"| {program} | {sum(sizes) / len(sizes):.2f} | {rms:.2f} | {errors[worst]:+.1f} ({worst.upper()}) |")


def list_values(values, programs):
    print(f"| group | measured | {' | '.join(programs)} |")
    print("|---" * (2 + len(programs)) + "|")
    for value in values:
        group = value.group
        place = f"{group.chain} {group.residue} {group.number}{group.insertion_code}"
        cells = [place, f"{value.measured:.2f}", *(f"{value.computed[program]:.2f}" for program in programs)]
        print("| " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("structures", type=Path, nargs="?")
    parser.add_argument("--protomer", type=Path, default=Path("target/release/protomer"))
    parser.add_argument("--propka", action="store_true")
    parser.add_argument("--entry")
    arguments = parser.parse_args()
    if arguments.propka:
        # Ends here, and not once for each structure, without it.
        import propka.run  # noqa: F401
    folder = arguments.structures or arguments.folder
    structures = {path.name.removesuffix(".pdb.gz").lower(): path for path in sorted(folder.glob("*.pdb.gz"))}
    entries = measured_by_entry(arguments.folder / "measured.csv")
    if arguments.entry:
        entry = arguments.entry.lower()
        if entry not in entries:
            raise SystemExit(f"{arguments.folder / 'measured.csv'} has no entry {arguments.entry}")
        entries = {entry: entries[entry]}
    by_entry = {entry: values_of_entry(arguments, entry, rows, structures) for entry, rows in sorted(entries.items())}
    values = [value for of_entry in by_entry.values() for value in of_entry]
    if not values:
        raise SystemExit("no measured value has a computed one")
    programs = ["model values", "protomer"] + (["PROPKA"] if arguments.propka else [])
    (list_values if arguments.entry else table)(values, programs)
    if not arguments.entry:
        charge_table(by_entry, programs)
    total = sum(map(len, entries.values()))
    print(f"\n{len(values)} of {total} measured values, {len(entries)} entries")


if __name__ == "__main__":
    main()
