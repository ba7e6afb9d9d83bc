"""Which contacts of crystals are those of the author's assembly: areas under the curve, and a regression held out by entry.

python3 tests/validation/interfaces.py CRYSTALS/score.csv
"""

import csv
import sys
from collections import defaultdict

import numpy as np

FEATURES = {
    "buried area": ("buried_area_angstrom2", 1.0),
    "affinity by contacts": ("contact_delta_g_kcal_per_mol", -1.0),
    "shape complementarity": ("shape_complementarity", 1.0),
    "contacts of residues": ("residue_contacts", 1.0),
    "hydrogen bonds": ("hydrogen_bonds", 1.0),
    "salt bridges": ("salt_bridges", 1.0),
}
CHOSEN = "affinity and ring"
RNG = np.random.default_rng(1)


def area_under_curve(scores, labels):
    """Share of pairs of a real and a crystal contact in which the real one scores higher."""
    order = np.argsort(scores, kind="stable")
    ranks = np.empty(len(scores))
    values = scores[order]
    start = 0
    for end in range(1, len(values) + 1):
        if end == len(values) or values[end] != values[start]:
            ranks[order[start:end]] = 0.5 * (start + end - 1)
            start = end
    real = labels.sum()
    return (ranks[labels].sum() - real * (real - 1) / 2) / (real * (len(labels) - real))


def interval(scores, labels, entries):
    """95 % of the values when entries are drawn again."""
    names = np.unique(entries)
    rows = {name: np.flatnonzero(entries == name) for name in names}
    drawn = []
    for _ in range(400):
        chosen = np.concatenate([rows[name] for name in RNG.choice(names, len(names))])
        if 0 < labels[chosen].sum() < len(chosen):
            drawn.append(area_under_curve(scores[chosen], labels[chosen]))
    return np.percentile(drawn, [2.5, 97.5])


def fitted(columns, labels, ridge=1e-3):
    """Logistic regression by Newton's method: constant first."""
    design = np.column_stack([np.ones(len(labels)), columns])
    weights = np.zeros(design.shape[1])
    for _ in range(50):
        chance = 1.0 / (1.0 + np.exp(-design @ weights))
        curvature = design.T @ (design * (chance * (1 - chance))[:, None]) + ridge * np.eye(len(weights))
        weights += np.linalg.solve(curvature, design.T @ (labels - chance) - ridge * weights)
    return weights


def held_out(columns, labels, entries, folds=10):
    """Probability of each contact by a fit to other entries."""
    names = RNG.permutation(np.unique(entries))
    fold = {name: number % folds for number, name in enumerate(names)}
    numbers = np.array([fold[entry] for entry in entries])
    chances = np.empty(len(labels))
    for number in range(folds):
        own = numbers == number
        weights = fitted(columns[~own], labels[~own].astype(float))
        chances[own] = 1.0 / (1.0 + np.exp(-(weights[0] + columns[own] @ weights[1:])))
    return chances


def main(path):
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["status"] == "ok" and row["in_assembly"]]
    for row in rows:
        row["shape_complementarity"] = row["shape_complementarity"] or "0"
    labels = np.array([row["in_assembly"] == "yes" for row in rows])
    entries = np.array([row["entry"] for row in rows])
    print(f"{len(rows)} contacts of {len(set(entries))} entries, {labels.sum()} in an assembly")
    values = {name: sign * np.array([float(row[column]) for row in rows]) for name, (column, sign) in FEATURES.items()}
    for name, scores in values.items():
        low, high = interval(scores, labels, entries)
        print(f"{name:24} {area_under_curve(scores, labels):.3f}  {low:.3f} to {high:.3f}")
    # A ring counts for a contact, an endless row against it, chains that differ for neither.
    closed = np.array([{"yes": 1.0, "no": -1.0}.get(row["closed"], 0.0) for row in rows])
    low, high = interval(closed, labels, entries)
    print(f"{'ring or row':24} {area_under_curve(closed, labels):.3f}  {low:.3f} to {high:.3f}")
    area, affinity, fit = np.log(np.maximum(values["buried area"], 50)), values["affinity by contacts"], values["shape complementarity"]
    sets = {
        "area": [area],
        "area and affinity": [area, affinity],
        "area, affinity, fit": [area, affinity, fit],
        "area and ring": [area, closed],
        CHOSEN: [affinity, closed],
        "area, affinity and ring": [area, affinity, closed],
        "all": [area, closed, *[values[name] for name in list(FEATURES)[1:]]],
    }
    for name, columns in sets.items():
        columns = np.column_stack(columns)
        chances = held_out(columns, labels, entries)
        low, high = interval(chances, labels, entries)
        weights = fitted(columns, labels.astype(float))
        right = ((chances > 0.5) == labels).mean()
        print(f"{name:24} {area_under_curve(chances, labels):.3f}  {low:.3f} to {high:.3f}  right {right:.3f}  {np.round(weights, 3)}")
    chances = held_out(np.column_stack(sets[CHOSEN]), labels, entries)
    kinds = defaultdict(list)
    for row, chance, label in zip(rows, chances, labels, strict=True):
        first, second = row["chains"].split(":")
        kind = "chain and its copy" if first == second else "within the asymmetric unit" if row["symmetry"] == "x,y,z" else "other"
        kinds[kind].append((chance, label))
    for kind, found in kinds.items():
        chance, label = np.array([each[0] for each in found]), np.array([each[1] for each in found])
        if 0 < label.sum() < len(label):
            print(f"{kind:28} {len(found)} contacts, {label.sum()} real, {area_under_curve(chance, label):.3f}")
    print("worst:")
    worst = sorted(zip(rows, chances, labels, strict=True), key=lambda each: -abs(each[1] - each[2]))
    for row, chance, label in worst[:12]:
        area, fit = float(row["buried_area_angstrom2"]), float(row["shape_complementarity"])
        print(f"{row['name']:14} {row['symmetry']:24} real {label!s:5} chance {chance:.2f} area {area:.0f} fit {fit:.2f}")


if __name__ == "__main__":
    main(sys.argv[1])
