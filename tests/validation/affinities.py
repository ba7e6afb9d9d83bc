"""Measured and estimated binding free energies of natural complexes: the calibration of `protomer binding`.

    python tests/validation/affinities.py FOLDER OUTPUT [--integrate] [--protomer PATH]

FOLDER holds affinities.csv (columns entry, delta_g_kcal_per_mol, class, buried_area_angstrom2 and
prodigy_prediction_kcal_per_mol) and ENTRY_receptor_bound.pdb.gz, ENTRY_ligand_bound.pdb.gz, such as the docking benchmark 5
(https://github.com/haddocking/BM5-clean) with the affinities of Vangone and Bonvin, eLife 4, e07454 (2015). With
--integrate the dissociation constant is also integrated over the poses around the crystal pose, which takes one to five CPU-minutes for a
complex. Writes OUTPUT/natural-complexes.csv and OUTPUT/natural-complexes.svg and prints the tables of the page. Work that is done
is not repeated. Needs numpy and matplotlib.
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
import numpy as np  # noqa: E402

SALTS_MOLAR = [0.15, 0.05, 1.0]
# RT ln 10 at 298.15 K.
KCAL_PER_MOL_PER_DECADE = 1.3643
CLASSES = {
    "A": "antibody, antigen",
    "AB": "antigen, bound antibody",
    "EI": "enzyme, inhibitor",
    "ER": "enzyme, regulator",
    "ES": "enzyme, substrate",
    "OG": "G protein",
    "OR": "receptor",
    "OX": "other",
    "NC": "not classified",
}


def answer(folder, path, protomer, entry, words):
    """The answer of `binding` about a complex, kept in a file."""
    if not path.exists():
        parts = [folder / f"{entry.lower()}_{part}_bound.pdb.gz" for part in ("receptor", "ligand")]
        command = [protomer, "binding", *parts, "--json", "-q", *words]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"{entry}: {done.stderr}")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(done.stdout)
    return json.loads(path.read_text())


def integrated(folder, output, protomer, entry):
    """Logarithm of the integrated dissociation constant in mol/L, and its standard error."""
    path = output / "runs" / f"{entry}-integrated.json"
    (condition,) = answer(folder, path, protomer, entry, ["--salt", f"{SALTS_MOLAR[0]:g}M", "--spacing", 0.9])["conditions"]
    return {
        "integrated_log10_kd_molar": round(condition["log10_kd_molar"], 2),
        "integrated_error": round(condition["log10_kd_error"], 2),
    }


def complexes(folder, output, protomer, integrate):
    """One row for each complex: measured, estimated, and what the estimate rests on."""
    rows = []
    for measured in csv.DictReader((folder / "affinities.csv").open()):
        entry = measured["entry"]
        salts = ",".join(f"{salt:g}M" for salt in SALTS_MOLAR)
        found = answer(folder, output / "runs" / f"{entry}.json", protomer, entry, ["--salt", salts, "--no-kd"])
        at_salt = {condition["salt_molar"]: condition for condition in found["conditions"]}
        estimated = {salt: at_salt[salt]["delta_g_kcal_per_mol"] for salt in SALTS_MOLAR}
        rows.append(
            {
                "entry": entry,
                "class": measured["class"],
                "measured_kcal_per_mol": float(measured["delta_g_kcal_per_mol"]),
                "estimated_kcal_per_mol": round(estimated[0.15], 3),
                "salt_effect_kcal_per_mol": round(estimated[1.0] - estimated[0.05], 3),
                "attraction_kcal_per_mol": round(found["affinity"]["attraction_kcal_per_mol"], 4),
                "polar_contacts": round(found["affinity"]["polar_contacts"], 4),
                "contacts": round(found["affinity"]["contacts"], 3),
                "poisson_boltzmann_kt": round(at_salt[0.15]["poisson_boltzmann_kt"], 2),
                "buried_area_angstrom2": float(measured["buried_area_angstrom2"]),
                "prodigy_kcal_per_mol": float(measured["prodigy_prediction_kcal_per_mol"]),
            }
            | (integrated(folder, output, protomer, entry) if integrate else {})
        )
    return rows


def left_out(measured, columns, fixed=0.0):
    """Predictions by least squares, each complex left out of its own fit, and the coefficients of all."""
    design = np.column_stack([np.ones(len(measured)), *columns])
    target = measured - fixed
    hat = design @ np.linalg.pinv(design)
    residual = (target - hat @ target) / (1 - np.diag(hat))
    return measured - residual, np.linalg.lstsq(design, target, rcond=None)[0]


def figures(predicted, measured):
    """Correlation and root mean square error."""
    return np.corrcoef(predicted, measured)[0, 1], np.sqrt(np.mean((predicted - measured) ** 2))


def interval(predicted, measured, samples=10_000):
    """Intervals of 95 % of both figures, by resampling complexes."""
    rng = np.random.default_rng(1)
    found = []
    for _ in range(samples):
        chosen = rng.integers(0, len(measured), len(measured))
        found.append(figures(predicted[chosen], measured[chosen]))
    return np.percentile(found, [2.5, 97.5], axis=0)


def row(name, predicted, measured):
    (r, error), bounds = figures(predicted, measured), interval(predicted, measured)
    print(
        f"| {name} | {r:.2f} ({bounds[0, 0]:.2f} to {bounds[1, 0]:.2f}) | {error:.2f} ({bounds[0, 1]:.2f} to {bounds[1, 1]:.2f}) |"
    )


def tables(rows):
    column = {key: np.array([r[key] for r in rows]) for key in rows[0]}
    measured, attraction, polar = column["measured_kcal_per_mol"], column["attraction_kcal_per_mol"], column["polar_contacts"]
    print("| prediction | r | RMSE (kcal/mol) |\n|---|---|---|")
    row("`binding`, in the fit", column["estimated_kcal_per_mol"], measured)
    found, numbers = left_out(measured, [polar], attraction)
    row("`binding`, each complex left out", found, measured)
    free, slopes = left_out(measured, [attraction, polar])
    row("the same with a fitted strength", free, measured)
    row("attraction alone, fitted", left_out(measured, [attraction])[0], measured)
    row("number of contacts, fitted", left_out(measured, [column["contacts"]])[0], measured)
    row("buried area, fitted", left_out(measured, [column["buried_area_angstrom2"]])[0], measured)
    row("Poisson-Boltzmann charge part, fitted", left_out(measured, [column["poisson_boltzmann_kt"]])[0], measured)
    row("PRODIGY, trained on these", column["prodigy_kcal_per_mol"], measured)
    if "integrated_log10_kd_molar" in column:
        constants = column["integrated_log10_kd_molar"] * KCAL_PER_MOL_PER_DECADE
        row("integrated K_D, nothing fitted", constants, measured)
        row("integrated K_D, scaled and shifted, left out", left_out(measured, [constants])[0], measured)
        row("integrated K_D with a cost of polar contacts, left out", left_out(measured, [constants, polar])[0], measured)
        print(f"\nintegrated: mean error {np.mean(constants - measured):+.2f}, spread {np.std(constants) / np.std(measured):.2f} of the measured")
    print(f"\nfitted: G {numbers[0]:.3f}, p {numbers[1]:.4f}; with a fitted strength {slopes[0]:.3f}, {slopes[1]:.3f}, {slopes[2]:.4f}")
    print(f"contacts {column['contacts'].min():.1f} to {column['contacts'].max():.1f}\n")
    print("| class | complexes | mean error | RMSE (kcal/mol), left out | PRODIGY |\n|---|---|---|---|---|")
    for name in sorted(set(column["class"])):
        chosen = column["class"] == name
        errors = found[chosen] - measured[chosen]
        peer = column["prodigy_kcal_per_mol"][chosen] - measured[chosen]
        rms, rms_peer = np.sqrt(np.mean(errors**2)), np.sqrt(np.mean(peer**2))
        print(f"| {CLASSES.get(name, name)} | {chosen.sum()} | {errors.mean():+.1f} | {rms:.1f} | {rms_peer:.1f} |")
    return found


def draw(path, rows, predicted):
    measured = np.array([r["measured_kcal_per_mol"] for r in rows])
    salt = np.array([r["salt_effect_kcal_per_mol"] for r in rows])
    figure, axes = plt.subplots(figsize=(6.2, 4.9), layout="constrained")
    ends = np.array([-16.5, -4.5])
    axes.fill_between(ends, ends - 1.63, ends + 1.63, color="0.92", linewidth=0)
    axes.plot(ends, ends, color="0.5", linewidth=1)
    largest = np.abs(salt).max()
    points = axes.scatter(
        measured, predicted, c=salt, cmap="coolwarm_r", vmin=-largest, vmax=largest, s=36, edgecolor="0.2", linewidth=0.5, zorder=3
    )
    figure.colorbar(points, label="change of ΔG° from 50 mM to 1 M salt (kcal/mol)")
    for r, x, y in zip(rows, measured, predicted):
        if abs(x - y) > 2.4:
            axes.annotate(r["entry"], (x, y), xytext=(5, 3), textcoords="offset points", fontsize=7)
    axes.set(xlim=ends, ylim=ends, aspect="equal")
    axes.set_xlabel("measured ΔG° (kcal/mol)")
    axes.set_ylabel("estimated ΔG°, left out of the fit (kcal/mol)")
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--integrate", action="store_true", help="integrate the dissociation constants as well")
    parser.add_argument("--protomer", type=Path, default=Path("target/release/protomer"))
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = complexes(arguments.folder, arguments.output, arguments.protomer, arguments.integrate)
    with (arguments.output / "natural-complexes.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    draw(arguments.output / "natural-complexes.svg", rows, tables(rows))


if __name__ == "__main__":
    main()
