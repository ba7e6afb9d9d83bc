"""Native or decoy: can a network tell near-native poses of two proteins from random contacts?

    python tests/validation/native_or_decoy.py poses COMPLEXES OUTPUT      poses, labels and features
    python tests/validation/native_or_decoy.py train OUTPUT                voxels, a network for each fold
    python tests/validation/native_or_decoy.py report OUTPUT               tables

COMPLEXES is a folder (searched through) with pairs NAME_receptor_bound.pdb.gz and NAME_ligand_bound.pdb.gz. All poses, the
native one too, are brought to contact by the same procedure. The same seed gives the same bytes.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import protomer as pm
from scipy.optimize import minimize
from scipy.spatial import cKDTree

PROTOMER = os.environ.get("PROTOMER", "protomer")
CONTACT_ANGSTROM = 2.7
"""Distance of the closest atoms of every pose."""
NATIVE_ANGSTROM = 5.0
"""A pose with a smaller ligand RMSD is called native, a pose above `DECOY_ANGSTROM` a decoy; those between are not used."""
DECOY_ANGSTROM = 10.0
PROBE_ANGSTROM = 1.4
FOLDS = 5
RIVALS = 20
"""Random contacts from which a decoy is chosen."""
FEATURES = ["buried_area_angstrom2", "residue_contacts", "charges_kt", "contacts_kt"]


def turned(angle_axis):
    """The rotation matrix of a vector of rotation."""
    angle = np.linalg.norm(angle_axis)
    if angle == 0.0:
        return np.eye(3)
    x, y, z = angle_axis / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def matrix_of(quaternion):
    w, x, y, z = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def quaternion_of(matrix):
    """The unit quaternion of a rotation, scalar first and not negative."""
    four = np.array([
        1 + matrix[0, 0] + matrix[1, 1] + matrix[2, 2],
        1 + matrix[0, 0] - matrix[1, 1] - matrix[2, 2],
        1 - matrix[0, 0] + matrix[1, 1] - matrix[2, 2],
        1 - matrix[0, 0] - matrix[1, 1] + matrix[2, 2],
    ])
    largest = int(np.argmax(four))
    root = np.sqrt(four[largest])
    a, b, c = matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]
    p, q, r = matrix[1, 0] + matrix[0, 1], matrix[0, 2] + matrix[2, 0], matrix[2, 1] + matrix[1, 2]
    rows = [[root, a / root, b / root, c / root], [a / root, root, p / root, q / root], [b / root, p / root, root, r / root], [c / root, q / root, r / root, root]]
    quaternion = 0.5 * np.array(rows[largest])
    return quaternion if quaternion[0] >= 0 else -quaternion


class Protein:
    """A body with its atoms in the coordinates of the file."""

    def __init__(self, path):
        self.path = path
        self.body = pm.Body.from_structure(path)
        self.atoms = self.body.charge_positions_angstrom + self.body.origin_angstrom
        self.radii = self.body.radii_angstrom
        self.residues = np.asarray(self.body.residue_indices)
        self.tree = cKDTree(self.atoms)
        self.centre = self.atoms.mean(axis=0)
        self.exposed, self.area_of_point = self._exposed()

    def _exposed(self, count=48):
        """Points of the accessible surface, and the area that each stands for, by the method of Shrake and Rupley."""
        number = np.arange(count) + 0.5
        polar, azimuth = np.arccos(1 - 2 * number / count), np.pi * (1 + 5**0.5) * number
        sphere = np.column_stack([np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)])
        reach = self.radii + PROBE_ANGSTROM
        points = (self.atoms[:, None] + reach[:, None, None] * sphere).reshape(-1, 3)
        areas = np.repeat(4 * np.pi * reach**2 / count, count)
        own = np.repeat(np.arange(len(self.atoms)), count)
        free = ~covered(points, self, own)
        return points[free], areas[free]


def covered(points, protein, own=None):
    """Whether points lie within an atom grown by the probe, other than their own."""
    k = min(12, len(protein.atoms))
    distances, atoms = protein.tree.query(points, k=k, distance_upper_bound=4.0)
    found = atoms < len(protein.atoms)
    reach = protein.radii[np.where(found, atoms, 0)] + PROBE_ANGSTROM - 1e-6
    inside = found & (distances < reach)
    if own is not None:
        inside &= atoms != own[:, None]
    return inside.any(axis=1)


class Pose:
    """The ligand moved by p -> R p + t."""

    def __init__(self, rotation, translation):
        self.rotation, self.translation = rotation, translation

    def of(self, points):
        return points @ self.rotation.T + self.translation

    def back(self, points):
        return (points - self.translation) @ self.rotation


def to_contact(receptor, ligand, rotation, centre, direction, from_far=True):
    """The ligand, turned, moved along `direction` to contact: from far to the first one, or from `centre` to the nearest one.

    Contact means that the closest atoms are `CONTACT_ANGSTROM` apart.
    """
    moved = (ligand.atoms - ligand.centre) @ rotation.T + centre
    # Seen along the direction: atoms touch that are within a contact of each other in the plane across it.
    across = np.linalg.svd(direction[None])[2][1:].T
    fixed, flying = cKDTree(receptor.atoms @ across), cKDTree(moved @ across)
    pairs = fixed.sparse_distance_matrix(flying, CONTACT_ANGSTROM, output_type="coo_matrix")
    if not len(pairs.data):
        return None
    along = (receptor.atoms @ direction)[pairs.row] - (moved @ direction)[pairs.col]
    half = np.sqrt(CONTACT_ANGSTROM**2 - pairs.data**2)
    low, high = along - half, along + half
    shift = high.max()
    if not from_far:
        shift = 0.0
        overlapping = (low < shift) & (shift < high)
        if overlapping.any():
            # Outwards, out of every overlap on the way.
            while overlapping.any():
                shift = high[overlapping].max()
                overlapping = (low < shift) & (shift < high)
        elif (high <= shift).any():
            shift = high[high <= shift].max()
    return Pose(rotation, centre + direction * shift - rotation @ ligand.centre)


def contacts(receptor, ligand, pose, reach=5.0):
    """Pairs of residues with atoms within reach."""
    moved = cKDTree(pose.of(ligand.atoms))
    pairs = receptor.tree.sparse_distance_matrix(moved, reach, output_type="coo_matrix")
    return set(zip(receptor.residues[pairs.row].tolist(), ligand.residues[pairs.col].tolist()))


def buried_area(receptor, ligand, pose):
    of_receptor = covered(pose.back(receptor.exposed), ligand)
    of_ligand = covered(pose.of(ligand.exposed), receptor)
    return receptor.area_of_point[of_receptor].sum() + ligand.area_of_point[of_ligand].sum()


def energies(receptor, ligand, poses):
    """Energies of charges and of contacts, as in the model `natural-1`, for each pose, kT: all in one assembly, pairs with the receptor.

    The response of the solvent, its third term, is left out: it takes several times as long as the others.
    """
    origins = [receptor.body.origin_angstrom] + [pose.of(ligand.body.origin_angstrom) for pose in poses]
    turns = [[1.0, 0.0, 0.0, 0.0]] + [quaternion_of(pose.rotation) for pose in poses]
    bodies = {"receptor": receptor.body, "ligand": ligand.body}
    assembly = pm.Assembly(bodies, ["receptor"] + ["ligand"] * len(poses), positions_angstrom=origins, orientations_wxyz=turns)
    found = []
    for contacts_of_model in ({}, {"contacts": "calvados3", "contact_strength": 1.9}):
        pairs = pm.inspect(assembly, salt="150mM", **contacts_of_model).pair_energies
        of_receptor = {int(pair[1]): float(pair[2]) for pair in pairs if pair[0] == 0}
        found.append([of_receptor[number + 1] for number in range(len(poses))])
    return np.array(found)


def random_contact(receptor, ligand, random):
    quaternion, direction = random.normal(size=4), random.normal(size=3)
    rotation = matrix_of(quaternion / np.linalg.norm(quaternion))
    return to_contact(receptor, ligand, rotation, receptor.centre, direction / np.linalg.norm(direction))


def poses_of(receptor, ligand, random, near, decoys):
    """Perturbed native poses and random contacts."""
    native = contacts(receptor, ligand, Pose(np.eye(3), np.zeros(3)))
    places = np.array(sorted({pair[0] for pair in native}))
    middle = receptor.atoms[np.isin(receptor.residues, places)].mean(axis=0)
    outward = ligand.centre - middle
    outward /= np.linalg.norm(outward)
    made = []
    for number in range(near):
        # The first is the native pose itself.
        scale = 0.0 if number == 0 else 1.0
        axis = random.normal(size=3)
        axis *= scale * np.radians(random.uniform(1, 8)) / np.linalg.norm(axis)
        shift = scale * random.normal(size=3) * 0.8
        tilt = turned(random.normal(size=3) * np.radians(scale * 3)) @ outward
        made.append(to_contact(receptor, ligand, turned(axis), ligand.centre + shift, tilt, from_far=False))
    for _ in range(decoys):
        # The one that buries most area of several: a random contact alone is a point, and no rival for a native pose.
        rivals = [random_contact(receptor, ligand, random) for _ in range(RIVALS)]
        rivals = [pose for pose in rivals if pose is not None]
        made.append(max(rivals, key=lambda pose: buried_area(receptor, ligand, pose)))
    return native, [pose for pose in made if pose is not None]


def rows_of(name, receptor, ligand, arguments, number):
    random = np.random.default_rng([arguments.seed, number])
    native, poses = poses_of(receptor, ligand, random, arguments.near, arguments.decoys)
    rows = []
    for place, pose in enumerate(poses):
        rmsd = float(np.sqrt(((pose.of(ligand.atoms) - ligand.atoms) ** 2).sum(axis=1).mean()))
        found = contacts(receptor, ligand, pose)
        label = "native" if rmsd < NATIVE_ANGSTROM else "decoy" if rmsd > DECOY_ANGSTROM else None
        if label is None:
            continue
        rows.append((pose, {
            "name": f"{name}-{place:03d}", "file": str(receptor.path.resolve()), "partner": str(ligand.path.resolve()),
            "label": label, "cluster": name,
            **dict(zip(["x_angstrom", "y_angstrom", "z_angstrom"], pose.translation)),
            **dict(zip(["qw", "qx", "qy", "qz"], quaternion_of(pose.rotation))),
            "ligand_rmsd_angstrom": rmsd,
            "native_contacts": len(found & native) / max(len(native), 1),
            "residue_contacts": len(found),
            "buried_area_angstrom2": buried_area(receptor, ligand, pose),
        }))
    charges, total = energies(receptor, ligand, [pose for pose, _ in rows])
    for (_, row), charge, energy in zip(rows, charges, total):
        row["charges_kt"], row["contacts_kt"] = charge, energy - charge
    return [row for _, row in rows]


COLUMNS = ["file", "partner", "label", "cluster", "name", "x_angstrom", "y_angstrom", "z_angstrom", "qw", "qx", "qy", "qz"]


def write(path, rows, columns):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def make_poses(arguments):
    output = Path(arguments.output)
    (output / "poses").mkdir(parents=True, exist_ok=True)
    receptors = sorted(Path(arguments.complexes).rglob("*_receptor_bound.pdb.gz"), key=lambda path: path.name)[: arguments.most]
    rows, begun = [], time.process_time()
    for number, receptor in enumerate(receptors):
        name = receptor.name.split("_")[0]
        kept = output / "poses" / f"{name}.json"
        if not kept.exists():
            try:
                pair = Protein(receptor), Protein(receptor.with_name(f"{name}_ligand_bound.pdb.gz"))
                found = rows_of(name, *pair, arguments, number)
            except pm.ProtomerError as error:
                print(f"{name}: left out: {error}", file=sys.stderr)
                found = []
            kept.write_text(json.dumps(found))
        rows += json.loads(kept.read_text())
        print(f"{name}: {len(rows)} poses so far, {time.process_time() - begun:.0f} CPU-s", file=sys.stderr)
    write(output / "manifest.csv", rows, COLUMNS)
    write(output / "features.csv", rows, ["name", "cluster", "label", "ligand_rmsd_angstrom", "native_contacts", *FEATURES])


def fold_of(clusters):
    """The fold of each complex: dealt out in a random order."""
    names = sorted(set(clusters))
    order = np.random.default_rng(7).permutation(len(names))
    return {names[place]: number % FOLDS for number, place in enumerate(order)}


def features(output):
    with open(output / "features.csv", newline="") as file:
        return list(csv.DictReader(file))


def run(*words):
    subprocess.run([PROTOMER, *map(str, words)], check=True)


def train(arguments):
    """A network for each fold, trained on all others: one set, and a table of labels for each fold."""
    output = Path(arguments.output)
    shape = ["--size", arguments.size, "--spacing", arguments.spacing, "--potential", "debye-hueckel", "--seed", 1]
    run("voxelize", "--manifest", output / "manifest.csv", "-o", output / "set.zarr", *shape, "-q")
    rows = features(output)
    folds = fold_of([row["cluster"] for row in rows])
    used = np.ones(len(rows), bool)
    if arguments.share < 1.0:
        names = sorted(folds)
        chosen = np.random.default_rng(11).permutation(len(names))[: round(arguments.share * len(names))]
        used = np.isin([row["cluster"] for row in rows], [names[place] for place in chosen])
    for fold in range(FOLDS):
        labels = output / f"labels-{fold}{arguments.suffix}.csv"
        kept = [
            {**row, "label": row["label"] if folds[row["cluster"]] != fold and use else ""} for row, use in zip(rows, used)
        ]
        write(labels, kept, ["name", "label"])
        directory = output / f"fold-{fold}{arguments.suffix}"
        run("train", output / "set.zarr", "--labels", labels, "--fractions", "0.8,0.15,0.05", "--epochs", arguments.epochs,
            "--patience", 3, "--widths", "8,16,32", "--groups", 0, "--batch", 32, "--logit-adjustment", 1, "--permutations", 100,
            "--seed", 1, "-o", directory, "-q")
        run("predict", directory, output / "set.zarr", "-o", directory / "all.csv", "-q", "--force")


def standardised(rows, values):
    """Values of each complex in units of their spread there, about their mean: what matters is the rank within a complex."""
    values, clusters = np.array(values, float), np.array([row["cluster"] for row in rows])
    result = np.zeros_like(values)
    for cluster in set(clusters):
        own = clusters == cluster
        result[own] = (values[own] - values[own].mean(axis=0)) / (values[own].std(axis=0) + 1e-9)
    return result


def logistic(features, labels, weights, ridge=1e-3):
    """Coefficients and intercept of a weighted logistic regression."""

    def cost(parameters):
        scores = features @ parameters[:-1] + parameters[-1]
        losses = np.logaddexp(0, np.where(labels, -scores, scores))
        slope = weights * (1 / (1 + np.exp(-scores)) - labels)
        gradient = np.append(features.T @ slope, slope.sum()) / weights.sum()
        gradient[:-1] += 2 * ridge * parameters[:-1]
        return (weights * losses).sum() / weights.sum() + ridge * (parameters[:-1] ** 2).sum(), gradient

    return minimize(cost, np.zeros(features.shape[1] + 1), jac=True, method="L-BFGS-B").x


def cross_fitted(rows, columns, labels, folds):
    scores = np.zeros(len(rows))
    of_row = np.array([folds[row["cluster"]] for row in rows])
    weights = np.where(labels, 0.5 / labels.mean(), 0.5 / (1 - labels.mean()))
    for fold in range(FOLDS):
        others = of_row != fold
        fit = logistic(columns[others], labels[others], weights[others])
        scores[~others] = columns[~others] @ fit[:-1] + fit[-1]
    return scores


def by_complex(rows, scores, labels):
    """For each complex: area under the curve, and whether a native pose is among the best 1, 5 and 10."""
    clusters = np.array([row["cluster"] for row in rows])
    found = {}
    for cluster in sorted(set(clusters)):
        own = clusters == cluster
        s, y = scores[own], labels[own]
        if not y.any() or y.all():
            continue
        ordered = y[np.argsort(-s, kind="stable")]
        above = (s[y][:, None] > s[~y]).mean() + 0.5 * (s[y][:, None] == s[~y]).mean()
        found[cluster] = [above, *(ordered[:most].any() for most in (1, 5, 10))]
    return found


def interval(values, draws=2000):
    random = np.random.default_rng(3)
    values = np.array(values, float)
    means = values[random.integers(0, len(values), (draws, len(values)))].mean(axis=1)
    return values.mean(), *np.percentile(means, [2.5, 97.5])


def sign_test(differences, draws=20000):
    """One-sided p of a mean difference, by exchange within complexes."""
    random = np.random.default_rng(5)
    differences = np.array(differences)
    signs = random.choice([-1, 1], (draws, len(differences)))
    return (1 + ((signs * differences).mean(axis=1) >= differences.mean() - 1e-12).sum()) / (1 + draws)


def network_logits(output, rows, folds, suffix=""):
    """For each pose the logit of the network that has not seen its complex."""
    of_fold = []
    for fold in range(FOLDS):
        with open(output / f"fold-{fold}{suffix}" / "all.csv", newline="") as file:
            of_fold.append({row["name"]: float(row["p_native"]) for row in csv.DictReader(file)})
    p = np.array([of_fold[folds[row["cluster"]]].get(row["name"], np.nan) for row in rows])
    p = np.clip(p, 1e-6, 1 - 1e-6)
    return np.log(p / (1 - p))


def report(arguments):
    output = Path(arguments.output)
    rows = features(output)
    folds = fold_of([row["cluster"] for row in rows])
    logits = network_logits(output, rows, folds, arguments.suffix)
    known = np.isfinite(logits)
    rows, logits = [row for row, is_known in zip(rows, known) if is_known], logits[known]
    labels = np.array([row["label"] == "native" for row in rows])
    values = np.array([[float(row[name]) for name in FEATURES] for row in rows])
    columns = standardised(rows, values)
    network = standardised(rows, logits[:, None])
    scores = {
        "buried area": values[:, 0],
        "residue contacts": values[:, 1],
        "energy: charges": -values[:, 2],
        "energy: contacts": -values[:, 3],
        "energy: charges and contacts": -values[:, 2] - values[:, 3],
        "regression on all of these": cross_fitted(rows, columns, labels, folds),
        "network": logits,
        "regression and network": cross_fitted(rows, np.hstack([columns, network]), labels, folds),
    }
    found = {name: by_complex(rows, score, labels) for name, score in scores.items()}
    complexes = sorted(found["network"])
    print(f"{len(complexes)} complexes, {labels.sum()} native poses and {(~labels).sum()} decoys\n")
    print("| | AUC | top 1 | top 5 | top 10 |\n|---|---|---|---|---|")
    for name, of_complex in found.items():
        cells = []
        for place in range(4):
            mean, low, high = interval([of_complex[cluster][place] for cluster in complexes])
            cells.append(f"{mean:.3f} ({low:.3f} to {high:.3f})")
        print(f"| {name} | {' | '.join(cells)} |")
    for one, other in [
        ("network", "regression on all of these"),
        ("regression and network", "regression on all of these"),
    ]:
        differences = [found[one][cluster][0] - found[other][cluster][0] for cluster in complexes]
        mean, low, high = interval(differences)
        print(f"\n{one} less {other}: AUC {mean:+.4f} ({low:+.4f} to {high:+.4f}), p = {sign_test(differences):.5f}")
        differences = [float(found[one][cluster][1]) - float(found[other][cluster][1]) for cluster in complexes]
        mean, low, high = interval(differences)
        print(f"{one} less {other}: top 1 {mean:+.4f} ({low:+.4f} to {high:+.4f}), p = {sign_test(differences):.5f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", choices=["poses", "train", "report"])
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--near", type=int, default=6)
    parser.add_argument("--decoys", type=int, default=24)
    parser.add_argument("--most", type=int, help="number of complexes, the first in alphabetical order")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", type=int, default=24)
    parser.add_argument("--spacing", type=float, default=1.25)
    parser.add_argument("--epochs", type=int, default=12)
    parser.add_argument("--share", type=float, default=1.0, help="share of the complexes to train on")
    parser.add_argument("--suffix", default="", help="part of the names of the trainings")
    arguments = parser.parse_args()
    arguments.output = arguments.folders[-1]
    arguments.complexes = arguments.folders[0]
    {"poses": make_poses, "train": train, "report": report}[arguments.step](arguments)


if __name__ == "__main__":
    main()
