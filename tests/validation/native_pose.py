"""Does the model know the native pose? Rank and distance of the native pose among the wells that `protomer pair` finds.

    python tests/validation/native_pose.py PROTOMER COMPLEXES OUTPUT [--largest 240]

COMPLEXES holds ENTRY_receptor_bound.pdb.gz, ENTRY_ligand_bound.pdb.gz and the same with unbound, superposed in the frame of
the complex, such as the docking benchmark 5 (https://github.com/haddocking/BM5-clean). All complexes of at most `--largest` residues are
taken, the smallest first. `pair` gets the two bodies without the pose; `binding` gets the pose and finds the lowest energy about it. Writes
OUTPUT/native-poses.csv and prints the table of the page. Work that is done is not repeated.
"""

import argparse
import gzip
import json
import math
import subprocess
from pathlib import Path

from binding import seconds, write_rows

MODEL, SALT = "natural-1", "150mM"
# A quarter of the default: the wells come from the starts, not from the precision of B2.
MOST_DIRECTIONS = 16384
STATES = ["bound", "unbound"]
PARTS = ["receptor", "ligand"]
# A pose nearer than this to the native one is the native well, Å.
NATIVE_ANGSTROM = 5.0


def file_of(folder, entry, part, state):
    return (folder / f"{entry}_{part}_{state}.pdb.gz").resolve()


def alpha_carbons(path):
    """Places of the CA atoms, each residue once, Å."""
    places = {}
    with gzip.open(path, "rt") as file:
        for number, line in enumerate(file):
            if line.startswith("ATOM") and line[12:16] == " CA ":
                # A copy of a residue follows at once; the same number later on is another chain.
                copy = line[17:20] if line[16] != " " else number
                places.setdefault((line[21:27], copy), [float(line[start : start + 8]) for start in (30, 38, 46)])
    return list(places.values())


def size(folder, entry, state):
    return sum(len(alpha_carbons(file_of(folder, entry, part, state))) for part in PARTS)


def smallest(folder, largest):
    """Entries of at most this number of residues in the bound files, the smallest first."""
    entries = [path.name.split("_")[0] for path in folder.glob("*_receptor_bound.pdb.gz")]
    sizes = sorted((size(folder, entry, "bound"), entry) for entry in entries)
    return [entry for count, entry in sizes if count <= largest]


def run_once(path, words):
    """The answer of a command as JSON, and its CPU time, kept in a file."""
    if not path.exists():
        start = seconds()
        done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(map(str, words))}: {done.stderr}")
        path.write_text(json.dumps({"cpu_seconds": seconds() - start, "answer": json.loads(done.stdout)}))
    return json.loads(path.read_text())


def movement(pose_file, copy):
    """Matrix and shift that moved the atoms of a file into a pose, from its remarks."""
    rows, is_it = [], False
    for line in pose_file.read_text().splitlines():
        words = line.removeprefix("REMARK   6").split()
        if line.startswith("ATOM"):
            break
        if words[:1] == ["COPY"]:
            is_it = words[1] == f"{copy}:"
        elif is_it and words and words[0].startswith("MATRIX"):
            rows.append([float(word) for word in words[1:5]])
    if len(rows) != 3:
        raise SystemExit(f"{pose_file}: no movement of copy {copy}")
    return [row[:3] for row in rows], [row[3] for row in rows]


def moved(place, matrix, shift):
    return [sum(m * x for m, x in zip(row, place, strict=True)) + by for row, by in zip(matrix, shift, strict=True)]


def moved_back(place, matrix, shift):
    away = [x - by for x, by in zip(place, shift, strict=True)]
    return [sum(matrix[row][column] * away[row] for row in range(3)) for column in range(3)]


def ligand_rmsd(pose_file, native):
    """Distance of the ligand's CA atoms from the native ones after superposing the receptor, Å."""
    of_receptor, of_ligand = movement(pose_file, 0), movement(pose_file, 1)
    squares = 0.0
    for place in native:
        in_frame_of_receptor = moved_back(moved(place, *of_ligand), *of_receptor)
        squares += math.dist(in_frame_of_receptor, place) ** 2
    return math.sqrt(squares / len(native))


def wells(protomer, files, native, output, name):
    """Energy and distance from the native pose of each well that `pair` finds, and its CPU time."""
    directory = output / name
    words = [protomer, "pair", *files, "--model", MODEL, "--salt", SALT]
    words += ["--most-directions", MOST_DIRECTIONS, "-j", 1, "-q", "--json", "-o", directory]
    done = run_once(output / f"{name}.pair.json", words)
    found = []
    (condition,) = done["answer"]["conditions"]
    for number, pose in enumerate(condition["poses"], 1):
        (pose_file,) = directory.glob(f"salt_*/poses/pose_{number:02}.pdb")
        found.append((pose["energy_kt"], ligand_rmsd(pose_file, native)))
    return found, done["cpu_seconds"]


def row_of(arguments, entry, state):
    """What is known about one complex."""
    files = [file_of(arguments.complexes, entry, part, state) for part in PARTS]
    native = alpha_carbons(files[1])
    name = f"{entry}_{state}"
    found, cpu_seconds = wells(arguments.protomer, files, native, arguments.output, name)
    words = [arguments.protomer, "binding", *files, "--model", MODEL, "--salt", SALT, "--spacing", 0.9, "-j", 1, "-q", "--json"]
    binding = run_once(arguments.output / f"{name}.binding.json", words)["answer"]
    about_native = binding["bound_states"][0] if binding["bound_states"] else None
    row = {"entry": entry.upper(), "state": state, "residues": size(arguments.complexes, entry, state), "wells": len(found)}
    nearest = min(range(len(found)), key=lambda number: found[number][1], default=None)
    is_found = nearest is not None and found[nearest][1] < NATIVE_ANGSTROM
    row["rank_of_native"] = nearest + 1 if is_found else ""
    row["nearest_rank"] = nearest + 1 if nearest is not None else ""
    row["nearest_rmsd_angstrom"] = round(found[nearest][1], 1) if nearest is not None else ""
    row["lowest_rmsd_angstrom"] = round(found[0][1], 1) if found else ""
    # The lowest energy about the native pose, by whichever of the two commands found it.
    by_both = [energy_kt for energy_kt, rmsd in found if rmsd < NATIVE_ANGSTROM]
    if about_native:
        by_both.append(about_native["lowest_energy_kt"])
    others = [energy_kt for energy_kt, rmsd in found if rmsd >= NATIVE_ANGSTROM]
    row["native_kt"] = round(min(by_both), 1) if by_both else ""
    row["as_given_kt"] = round(binding["conditions"][0]["energy_kt"], 1)
    row["best_other_kt"] = round(others[0], 1) if others else ""
    row["others_below_native"] = sum(energy_kt < min(by_both) for energy_kt in others) if by_both else ""
    row["pair_cpu_seconds"] = round(cpu_seconds)
    return row


def table(rows):
    print("| complex | residues | files | wells | rank of the native pose | nearest well (Å) | lowest well (Å) | native (kT) | best other (kT) |")
    print("|---|---|---|---|---|---|---|---|---|")
    for row in rows:
        cells = [row["entry"], row["residues"], row["state"], row["wells"], row["rank_of_native"] or "-"]
        cells += [row["nearest_rmsd_angstrom"], row["lowest_rmsd_angstrom"], row["native_kt"], row["best_other_kt"]]
        print("| " + " | ".join(map(str, cells)) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("protomer", type=Path)
    parser.add_argument("complexes", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--largest", type=int, default=240)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for entry in smallest(arguments.complexes, arguments.largest):
        for state in STATES:
            rows.append(row_of(arguments, entry, state))
            write_rows(arguments.output / "native-poses.csv", rows)
    table(rows)


if __name__ == "__main__":
    main()
