"""B22 of lysozyme at pH 7 and 4.5, term by term: what lowers the repulsion that every model with its whole charge has.

    python tests/validation/lysozyme_charge.py STRUCTURE MEASURED OUTPUT [--protomer PATH] [--all]

STRUCTURE is 4LZT (https://files.rcsb.org/download/4LZT.pdb.gz). MEASURED is a table with the columns ionic_strength_molar, ph and
b22_mol_ml_per_g2, such as the values of Vinterbladh et al. (2025; data set in github.com/mlund/SI-pose-exploration, CC BY 4.0). Prints
B22 (1e-4 mol mL/g²) at four salts for each term; with --all the last model at every measured point and at pH 4.5, with its root
mean square deviation. Runs that are done are not repeated.
"""

import argparse
import csv
import json
import math
import subprocess
from pathlib import Path

from lysozyme_b22 import EXPERIMENTS

SALT_M = [0.01, 0.02, 0.05, 0.11]
STRUCTURE = ["--protonation", "structure"]
TERMS = {
    "charges of the atoms": ["--interaction", "bare"],
    "effective charges": ["--interaction", "effective"],
    "effective charges, Boltzmann ions": ["--interaction", "effective", "--ions", "boltzmann"],
    "solution-1": ["--model", "solution-1"],
    "and pKa values of the structure": ["--model", "solution-1", *STRUCTURE],
    "and regulation": ["--model", "solution-1", *STRUCTURE, "--regulation"],
    "and bound anions (12 L/mol)": ["--model", "solution-1", *STRUCTURE, "--anion-binding", "12"],
    "solution-2 (contacts × 0.6)": ["--model", "solution-2"],
}


def b22(arguments, flags, ph, kelvin, salts, name):
    """Salt (M), B22 and its error (1e-4 mol mL/g²) of each condition."""
    answer = arguments.output / (name.replace(" ", "_") + ".json")
    if not answer.exists():
        salt = ",".join(f"{salt:.6g}M" for salt in salts)
        command = [arguments.protomer, "pair", arguments.structure, "--ph", ph, "--salt", salt, "--temperature", f"{kelvin}K"]
        command += ["--b22-error", "2e-4", *flags, "--json", "-q"]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        arguments.output.mkdir(parents=True, exist_ok=True)
        answer.write_text(done.stdout)
    rows = []
    for condition in json.loads(answer.read_text())["conditions"]:
        value, error = condition["b22_mol_ml_per_g2"], condition["b22_error_mol_ml_per_g2"]
        rows.append((condition["salt_M"], 1e4 * value, 1e4 * error))
    return rows


def deviation(rows, measured):
    """Root mean square difference from measured pairs of salt and B22."""
    squares = []
    for salt, value in measured:
        computed = min(rows, key=lambda row: abs(math.log(row[0] / salt)))
        squares.append((computed[1] - value) ** 2)
    return math.sqrt(sum(squares) / len(squares))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("structure", type=Path)
    parser.add_argument("measured", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--protomer", type=Path, default=Path("target/release/protomer"))
    parser.add_argument("--all", action="store_true")
    arguments = parser.parse_args()
    with arguments.measured.open() as table:
        rows = [row for row in csv.DictReader(table) if float(row["ph"]) == 7.0]
    measured = [(float(row["ionic_strength_molar"]), 1e4 * float(row["b22_mol_ml_per_g2"])) for row in rows]
    nearest = [min(measured, key=lambda pair: abs(pair[0] - salt))[1] for salt in SALT_M]
    print(f"{'measured':40}", *(f"{value:8.2f}" for value in nearest))
    for name, flags in TERMS.items():
        found = b22(arguments, flags, 7, 298.15, SALT_M, f"7 {name}".replace("/", " per "))
        print(f"{name:40}", *(f"{value:8.2f}" for _, value, _ in found), flush=True)
    if arguments.all:
        for name in ["solution-2 (contacts × 0.6)", "solution-1"]:
            flags = TERMS[name]
            found = b22(arguments, flags, 7, 298.15, [salt for salt, _ in measured], f"all 7 {name}")
            print(f"{name}, pH 7: rms {deviation(found, measured):.2f} over {len(measured)} points")
            known = [pair for pairs in EXPERIMENTS.values() for pair in pairs]
            found = b22(arguments, flags, 4.5, 293.15, sorted({salt for salt, _ in known}), f"all 4.5 {name}")
            print(f"{name}, pH 4.5: rms {deviation(found, known):.2f} over {len(known)} values")
            for salt, value, error in found:
                print(f"    {salt:g} M: {value:.2f} ± {error:.2f}")


if __name__ == "__main__":
    main()
