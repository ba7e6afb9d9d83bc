"""B22 of lysozyme against salt, compared with experiments: plain charges, effective charges, the response of the solvent, and contacts.

    python tests/validation/lysozyme_b22.py FOLDER_OF_STRUCTURES OUTPUT [--protomer PATH] [--core native] [--salts 0.1,0.3]

FOLDER_OF_STRUCTURES holds 4lzt, 6lyz, 1hel, 1aki and 5pti as .pdb.gz (https://files.rcsb.org/download/4LZT.pdb.gz). Writes
OUTPUT/lysozyme-b22.csv, and with the core of the page, the surface, OUTPUT/lysozyme-b22.svg. Needs matplotlib. Runs that are
done are not repeated.
"""

import argparse
import csv
import json
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "protomer"
import matplotlib.pyplot as plt  # noqa: E402

SALT_M = [0.1, 0.2, 0.3, 0.5, 0.7, 1.0]
STRENGTH, UNCERTAINTY = 1.65, 0.1
PH = "4.5"
MEDIUM = ["--temperature", "293.15K", "--b22-error", "5e-5"]
# Ionic strength (M) and B22 (1e-4 mol mL/g²) as read from figure 6 of Takahashi et al., Biophys. J. 94 (2008),
# doi 10.1529/biophysj.107.111872, to half a unit.
EXPERIMENTS = {
    "Guo 1999": [(0.1, 2.5), (0.3, -0.5), (0.5, -2.0), (0.7, -3.5), (1.0, -5.0)],
    "Velev 1998": [(0.2, 2.0), (0.5, -1.0)],
    "Takahashi 2008": [(0.1, -0.5), (0.5, -2.5), (0.95, -4.0), (1.0, -5.5)],
}


def contacts(strength):
    return ["--interaction", "effective", "--contacts", "calvados3", "--contact-strength", f"{strength:g}"]


MODELS = {
    "surface alone": ["--interaction", "hard"],
    "charges of the atoms": ["--interaction", "bare"],
    "effective charges": ["--interaction", "effective"],
    f"effective charges, contacts × {STRENGTH - UNCERTAINTY:g}": contacts(STRENGTH - UNCERTAINTY),
    f"effective charges, contacts × {STRENGTH:g}": contacts(STRENGTH),
    f"effective charges, contacts × {STRENGTH + UNCERTAINTY:g}": contacts(STRENGTH + UNCERTAINTY),
}
RESPONSE = ["--interaction", "response"]
# What the other core is compared with: the three without an uncertain strength, and the response of the solvent.
COMPARED = {
    **{name: MODELS[name] for name in ["surface alone", "charges of the atoms", "effective charges"]},
    f"effective charges, contacts × {STRENGTH:g}": contacts(STRENGTH),
    "response": RESPONSE,
    f"response, contacts × {STRENGTH:g}": [*RESPONSE, *contacts(STRENGTH)[2:]],
}
PREDICTED = ["6lyz", "1hel", "1aki", "5pti"]


def body_with_core(protomer, structure, core, folder):
    """The body of a structure; what is hard of it is its surface, as in the figure of the page, or its native core."""
    subprocess.run([protomer, "ingest", structure, "--ph", PH, "--core", core, "-o", folder, "-q", "--force"], check=True)
    return folder / f"{structure.name.split('.')[0]}.body"


def b22(protomer, body, flags, salts, directory):
    """Salt (M), B22 and its error (1e-4 mol mL/g²) of each condition."""
    salt = ",".join(f"{salt}M" for salt in salts)
    command = [protomer, "pair", body, "--salt", salt, *MEDIUM, *flags, "-o", directory, "--json", "-q"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stderr}")
    rows = []
    for condition in json.loads(done.stdout)["conditions"]:
        value, error = condition["b22_mol_ml_per_g2"], condition["b22_error_mol_ml_per_g2"]
        rows.append((condition["salt_M"], 1e4 * value, 1e4 * error))
    return rows


def draw(table, path):
    figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    for (name, points), marker in zip(EXPERIMENTS.items(), "osD"):
        axes.plot(*zip(*points), marker, color="black", mfc="none", ms=6, label=f"measured, {name}")
    lines = {name: rows for (body, name), rows in table.items() if body == "4lzt"}
    low, middle, high = list(lines)[-3:]
    salts = [row[0] for row in lines[middle]]
    shade = [row[1] for row in lines[low]], [row[1] for row in lines[high]]
    axes.fill_between(salts, *shade, color="#c2410c", alpha=0.2, lw=0)
    styles = {"surface alone": ("#888888", ":"), "charges of the atoms": ("#2563eb", "--")}
    for name in [*list(lines)[:3], middle]:
        colour, style = styles.get(name, ("#0f766e", "-."))
        if name == middle:
            colour, style = "#c2410c", "-"
            name = f"{name} ± {UNCERTAINTY:g}"
        rows = lines[middle if name.startswith(middle) else name]
        axes.errorbar(*zip(*[row[:2] for row in rows]), yerr=[row[2] for row in rows], color=colour, ls=style, label=name)
    axes.axhline(0.0, color="black", lw=0.6)
    axes.set(xlabel="NaCl (M)", ylabel="B22 (10⁻⁴ mol mL/g²)", ylim=(-10, 12))
    axes.legend(fontsize=8, frameon=False)
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("structures", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--protomer", default="target/release/protomer")
    parser.add_argument("--core", choices=["surface", "native"], default="surface")
    parser.add_argument("--salts", type=lambda text: [float(salt) for salt in text.split(",")], default=SALT_M)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    table = {}
    has_hard_surface = arguments.core == "surface"
    models = MODELS if has_hard_surface else COMPARED
    runs = [("4lzt", name, flags, arguments.salts) for name, flags in models.items()]
    middle = f"effective charges, contacts × {STRENGTH:g}"
    if has_hard_surface:
        runs += [(body, middle, MODELS[middle], [0.1, 0.3, 1.0]) for body in PREDICTED]
    for body, name, flags, salts in runs:
        directory = arguments.output / f"{body} {name}".replace(" ", "-").replace(",", "").replace("×", "x")
        structure = arguments.structures / f"{body}.pdb.gz"
        made = body_with_core(arguments.protomer, structure, arguments.core, arguments.output)
        table[body, name] = b22(arguments.protomer, made, flags, salts, directory)
        for salt, value, error in table[body, name]:
            print(f"{body}  {name:40}  {salt:5.2f} M  {value:7.2f} ± {error:.2f}", flush=True)
    with open(arguments.output / "lysozyme-b22.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["structure", "model", "salt_M", "b22_1e-4_mol_ml_per_g2", "b22_error_1e-4_mol_ml_per_g2"])
        for (body, name), rows in table.items():
            writer.writerows([body, name, salt, f"{value:.3f}", f"{error:.3f}"] for salt, value, error in rows)
    if has_hard_surface:
        draw(table, arguments.output / "lysozyme-b22.svg")


if __name__ == "__main__":
    main()
