"""The response of the solvent compared with the Poisson-Boltzmann equation, from contact to 8 Å.

    python tests/validation/solvent_response.py FOLDER OUTPUT [--protomer PATH] [--spacing 0.9] [--shifts 0,1,2,3,5,8]

FOLDER holds ENTRY_receptor_bound.pdb.gz and ENTRY_ligand_bound.pdb.gz in one frame, such as the docking benchmark 5
(https://github.com/haddocking/BM5-clean). The ligand of each complex is moved away along the line of centres, and `binding` gives the
charge part by the equation and by the fast interaction at four salts. Writes OUTPUT/solvent-response.csv and prints the
tables of the page. Work that is done is not repeated. Needs numpy.
"""

import argparse
import csv
import gzip
import json
import subprocess
from pathlib import Path

import numpy as np

SALTS_MOLAR = [1.0, 0.5, 0.15, 0.05]
FIELDS = [
    "entry",
    "shift_angstrom",
    "salt_molar",
    "solver_kt",
    "fast_kt",
    "solver_effect_kt",
    "solver_effect_error_kt",
    "fast_effect_kt",
    "bare_effect_kt",
]
# Effects above this must have the right sign, kT.
LARGE_EFFECT_KT = 1.0


def is_atom(line):
    return line.startswith(("ATOM", "HETATM"))


def centre(lines):
    """Mean of the positions of the heavy atoms, Å."""
    places = [
        [float(line[start : start + 8]) for start in (30, 38, 46)] for line in lines if is_atom(line) and line[76:78].strip() != "H"
    ]
    return np.mean(places, axis=0)


def shifted(line, shift):
    if not is_atom(line):
        return line
    place = np.array([float(line[start : start + 8]) for start in (30, 38, 46)]) + shift
    return line[:30] + "".join(f"{x:8.3f}" for x in place) + line[54:]


def files(arguments, entry, shift_angstrom):
    """The receptor, and the ligand moved away along the line of centres."""
    receptor, ligand = (arguments.folder / f"{entry}_{part}_bound.pdb.gz" for part in ("receptor", "ligand"))
    moved = arguments.output / "runs" / f"{entry}-{shift_angstrom:g}.pdb"
    if not moved.exists():
        moved.parent.mkdir(parents=True, exist_ok=True)
        fixed, moving = (gzip.open(file, "rt").readlines() for file in (receptor, ligand))
        line_of_centres = centre(moving) - centre(fixed)
        shift = shift_angstrom * line_of_centres / np.linalg.norm(line_of_centres)
        moved.write_text("".join(shifted(line, shift) for line in moving))
    return receptor, moved


def run(words):
    return subprocess.run(list(map(str, words)), capture_output=True, text=True)


def answer(arguments, entry, shift_angstrom):
    """The answer of `binding` about a pose, or the reason of a refusal."""
    path = arguments.output / "runs" / f"{entry}-{shift_angstrom:g}.json"
    if not path.exists():
        salts = ",".join(f"{salt:g}M" for salt in SALTS_MOLAR)
        words = [arguments.protomer, "binding", *files(arguments, entry, shift_angstrom), "--salt", salts]
        done = run([*words, "--no-kd", "--spacing", arguments.spacing, "--json", "-q", "-j", 1])
        path.write_text(done.stdout if done.returncode == 0 else json.dumps({"refused": done.stderr}))
    return json.loads(path.read_text())


def rows_of_pose(entry, shift_angstrom, found):
    reference = found["conditions"][0]
    for condition in found["conditions"]:
        bare, bare_reference = (each["terms_kt"]["charges"] for each in (condition, reference))
        fast, fast_reference = (
            each["terms_kt"]["charges"] + each["terms_kt"]["solvent_response"] for each in (condition, reference)
        )
        yield {
            "entry": entry.upper(),
            "shift_angstrom": shift_angstrom,
            "salt_molar": condition["salt_molar"],
            "solver_kt": round(condition["poisson_boltzmann_kt"], 3),
            "fast_kt": round(fast, 3),
            "solver_effect_kt": round(condition["salt_effect_kt"], 3),
            "solver_effect_error_kt": round(condition["salt_effect_error_kt"], 3),
            "fast_effect_kt": round(fast - fast_reference, 3),
            "bare_effect_kt": round(bare - bare_reference, 3),
        }


def root_mean_square(values):
    return np.sqrt(np.mean(np.square(list(values))))


def summarise(rows):
    print("| moved (Å) | complexes | 500 mM | 150 mM | 50 mM | median, 50 mM | bare, 50 mM | sign right | salt-independent part |")
    print("|---|---|---|---|---|---|---|---|---|")
    for shift in sorted({row["shift_angstrom"] for row in rows}):
        chosen = [row for row in rows if row["shift_angstrom"] == shift]
        errors, bare = {}, {}
        for salt in SALTS_MOLAR[1:]:
            at_salt = [row for row in chosen if row["salt_molar"] == salt]
            errors[salt] = [abs(row["fast_effect_kt"] - row["solver_effect_kt"]) for row in at_salt]
            bare[salt] = root_mean_square(row["bare_effect_kt"] - row["solver_effect_kt"] for row in at_salt)
        large = [row for row in chosen if abs(row["solver_effect_kt"]) > LARGE_EFFECT_KT]
        right = sum(row["fast_effect_kt"] * row["solver_effect_kt"] > 0 for row in large)
        at_reference = [row for row in chosen if row["salt_molar"] == SALTS_MOLAR[0]]
        offset = root_mean_square(row["fast_kt"] - row["solver_kt"] for row in at_reference)
        figures = " | ".join(f"{root_mean_square(errors[salt]):.2f}" for salt in SALTS_MOLAR[1:])
        lowest = SALTS_MOLAR[-1]
        print(
            f"| {shift:g} | {len(at_reference)} | {figures} | {np.median(errors[lowest]):.2f} | {bare[lowest]:.2f} | "
            f"{right} of {len(large)} | {offset:.0f} |"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--protomer", type=Path, default=Path("target/release/protomer"))
    parser.add_argument("--spacing", type=float, default=0.9)
    parser.add_argument("--shifts", type=lambda words: [float(word) for word in words.split(",")], default=[0, 1, 2, 3, 5, 8])
    arguments = parser.parse_args()
    entries = sorted(path.name.split("_")[0] for path in arguments.folder.glob("*_receptor_bound.pdb.gz"))
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for shift in arguments.shifts:
        for entry in entries:
            found = answer(arguments, entry, shift)
            if "refused" in found:
                print(f"{entry.upper()}, {shift:g} Å: {found['refused'].strip()}")
                continue
            rows.extend(rows_of_pose(entry, shift, found))
    with (arguments.output / "solvent-response.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    summarise(rows)


if __name__ == "__main__":
    main()
