"""What a regression cannot see: B2 of charge patterns at a fixed net charge, after size, dipole and quadrupole.

    python tests/validation/residual_b22.py STRUCTURES OUTPUT [STAGE...]

STRUCTURES is a folder (searched through) with the entries of PARENTS as NAME.pdb.gz; OUTPUT gets everything else. A pattern gives half of
the charged side chains (Asp, Glu, Lys, Arg) of a parent +1 and the other half -1; atoms and surface stay. The stages, in order; all if
none is named, and each does only what is not there yet:

    patterns   the parents as PQR files, random patterns of charges, the voxels of all
    labels     B2 of all patterns from poses that they share (patterns_b22.py), twice: to learn from, and to judge by
    check      B2 of some patterns by `pair`
    networks   networks on everything but the test part, on shares of it, and without one parent each
    rounds     active learning: labels where two networks differ most, compared with as many random ones
    mutants    five patterns proposed by the gradient of the networks, checked by `pair` with full statistics
    report     tables and the figure

PROTOMER names another program. Needs numpy, scipy, zarr and matplotlib. One thread. The same command continues what was stopped.
"""

import argparse
import csv
import json
import os
import subprocess
import time
from pathlib import Path

import matplotlib
import numpy as np
import protomer as pm

from network_gradients import Network
from patterns_b22 import DEBYE_ANGSTROM, Surface, second_virials

PROTOMER = os.environ.get("PROTOMER", "protomer")
PARENTS = ["4pti", "1pga", "1poh", "1bi6"]
TEST, FIRST, POOL = 48, 48, 200
"""Patterns of each parent: held out, labelled first, and to choose from (or as many as there are)."""
SHARES = (48, 124, 248)
"""Patterns of each parent in a training, for the learning curve."""
ROUNDS, PER_ROUND = 3, 12
"""Rounds of active learning, and labels of each parent that a round adds in either arm."""
SEEDS, RAYS = (1, 2), 4096
"""Seeds of the labels, the first for training, the second to judge by; and rays of each."""
CHECKED = 3
"""Patterns of each parent that `pair` checks."""
WEAKEST = 0.005
"""Smallest attraction, in hard parts of B2, that labels tell apart."""
SALT = "100mM"
CHECK, FULL = ["--relative-error", "0.01"], ["--relative-error", "0.02"]
VOXELS = ["--size", "24", "--spacing", "2", "--channels", "shape,potential", "--potential", "debye-hueckel", "--salt", SALT]
NETWORK = ["--target", "number", "--loss", "normal", "--groups", "0", "--widths", "8,16,32", "--batch", "8", "--learning-rate", "0.002", "--permutations", "0"]
CHARGED = {"ASP", "GLU", "LYS", "ARG"}
SEED = 1
ENSEMBLE, VOTERS, EPOCHS = (1,), (1, 2), 60
"""Seeds of the networks, of those that vote in active learning, and passes over the training part."""
STEPS, TRIED = 8, 4
"""Most exchanges of a proposal, and candidates of the gradient that are tried before it stops."""


def protomer(*words):
    """Runs the program on one thread; its standard output and its processor time in seconds."""
    command = [PROTOMER, *map(str, words), "-j", "1", "--no-progress"]
    before = os.times()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} ended with {done.returncode}\n{done.stderr}")
    return done.stdout, after.children_user + after.children_system - before.children_user - before.children_system


def write(path, text):
    """Only complete files get their name, so that a stage can be stopped anywhere."""
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(path.name + ".unfinished")
    unfinished.write_text(text)
    unfinished.rename(path)


class Parent:
    """A protein whose charged side chains take either sign."""

    def __init__(self, path):
        self.name, self.lines = path.stem, path.read_text().splitlines()
        positions, charges, sites, residues = [], [], {}, set()
        for number, line in enumerate(self.lines):
            if not line.startswith("ATOM"):
                continue
            words = line.split()
            residues.add((words[4], words[5]))
            charge = float(words[9])
            if words[3] in CHARGED and abs(charge) > 0.3 and words[2] not in ("N", "O", "OXT"):
                sites.setdefault((words[4], words[5], words[3]), []).append((number, len(charges), abs(charge)))
            positions.append([float(word) for word in words[6:9]])
            charges.append(charge)
        self.positions, self.charges = np.array(positions), np.array(charges)
        self.radii = np.array([float(line.split()[-1]) for line in self.lines if line.startswith("ATOM")])
        self.sites, self.residues = list(sites), len(residues)
        self.atoms = [sites[site] for site in self.sites]
        self.fixed = self.charges.copy()
        for atoms in self.atoms:
            for _, atom, _ in atoms:
                self.fixed[atom] = 0.0

    def pattern(self, signs):
        """The charges of the atoms, e, with these signs at the sites."""
        charges = self.fixed.copy()
        for sign, atoms in zip(signs, self.atoms):
            for _, atom, magnitude in atoms:
                charges[atom] = sign * magnitude
        return charges

    def pqr(self, charges):
        lines, atom = list(self.lines), 0
        for number, line in enumerate(lines):
            if line.startswith("ATOM"):
                before, _, radius = line.rsplit(maxsplit=2)
                lines[number] = f"{before}  {charges[atom]:.8f}  {radius}"
                atom += 1
        return "\n".join(lines) + "\n"


def parents(output):
    return {name: Parent(output / "parents" / f"{name}.pqr") for name in PARENTS}


def patterns(output):
    return json.loads((output / "patterns.json").read_text())


def stage_patterns(structures, output):
    for name in PARENTS:
        if not (output / "parents" / f"{name}.pqr").exists():
            found = sorted(structures.rglob(f"{name}.pdb.gz"))
            if not found:
                raise SystemExit(f"{structures} has no {name}.pdb.gz")
            words = ["--name", name, "--ph", "7", "--charges", "formal", "--core", "surface", "--export", "pqr", "-q", "--force"]
            protomer("ingest", found[0], "-o", output / "parents", *words)
    if not (output / "patterns.json").exists():
        made = []
        for number, parent in enumerate(parents(output).values()):
            random, sites = np.random.default_rng([SEED, number]), len(parent.sites)
            signs = np.where(np.arange(sites) < sites // 2, 1, -1)
            drawn = list(dict.fromkeys(tuple(int(sign) for sign in random.permutation(signs)) for _ in range(4000)))
            for place, pattern in enumerate(drawn[: TEST + FIRST + POOL]):
                part = "test" if place < TEST else "first" if place < TEST + FIRST else "pool"
                made.append({"name": f"{parent.name}-{place:03d}", "parent": parent.name, "part": part, "signs": pattern})
        write(output / "patterns.json", json.dumps(made))
    if not (output / "set.zarr").exists():
        lines = ["file,label,cluster,name"]
        known = parents(output)
        for row in patterns(output):
            path = output / "pqr" / f"{row['name']}.pqr"
            write(path, known[row["parent"]].pqr(known[row["parent"]].pattern(row["signs"])))
            lines.append(f"{path.resolve()},0,{row['name']},{row['name']}")
        write(output / "manifest.csv", "\n".join(lines) + "\n")
        _, cpu = protomer("voxelize", "--manifest", output / "manifest.csv", "-o", output / "set.zarr", *VOXELS, "--seed", SEED, "-q")
        print(f"voxels: {cpu:.0f} CPU-s", flush=True)


def stage_labels(output):
    """B2 of all patterns of each parent from shared poses, with two seeds."""
    for seed in SEEDS:
        for parent in parents(output).values():
            kept = output / "labels" / f"{parent.name}-{seed}.json"
            if kept.exists():
                continue
            begun, own = time.process_time(), [row for row in patterns(output) if row["parent"] == parent.name]
            body = pm.Body.read(output / "parents" / f"{parent.name}.body")
            atoms = np.array(body.charge_positions_angstrom)
            surface = Surface(body.vertices_angstrom, body.triangles, atoms, parent.radii)
            sites, weights = np.zeros(len(atoms), int), parent.fixed.copy()
            for number, members in enumerate(parent.atoms, 1):
                for _, atom, magnitude in members:
                    sites[atom], weights[atom] = number, magnitude
            used = weights != 0
            signs = np.array([[1, *row["signs"]] for row in own], float)
            charges = atoms[used], weights[used], sites[used]
            soft, error, hard = second_virials(surface, charges, signs, [SEED, seed, *parent.name.encode()], RAYS)
            cpu = time.process_time() - begun
            found = {"names": [row["name"] for row in own], "charges_angstrom3": soft.tolist(), "error_angstrom3": error.tolist()}
            write(kept, json.dumps({**found, "hard_angstrom3": hard, "cpu_s": cpu}))
            print(f"{parent.name}, seed {seed}: {len(own)} labels, {cpu:.0f} CPU-s, spread {soft.std() / hard:.3f}, error {np.median(error) / hard:.4f}", flush=True)


def by_pair(output, name, seed, settings=FULL):
    """B2 of a pattern by `pair`, Å³: the whole, its error, its hard part; computed if it is not there yet."""
    kept = output / "pair" / f"{name}-{seed}.json"
    if not kept.exists():
        text, cpu = protomer("pair", output / "pqr" / f"{name}.pqr", "--salt", SALT, *settings, "--seed", seed, "--no-cache", "--json", "-q")
        found = json.loads(text)["conditions"][0]
        values = {key: found[key] for key in ("b2_angstrom3", "b2_error_angstrom3", "b2_hard_angstrom3", "directions", "kd_molar")}
        write(kept, json.dumps({"name": name, **values, "lowest_kt": min((p["energy_kt"] for p in found["poses"]), default=0.0), "cpu_s": cpu}))
    return json.loads(kept.read_text())


def stage_check(output):
    """The first patterns of the test part by `pair`, parents in turn."""
    for place in range(CHECKED):
        for name in PARENTS:
            found = by_pair(output, f"{name}-{place:03d}", 1, CHECK)
            print(f"{name}-{place:03d}: {found['b2_angstrom3'] / found['b2_hard_angstrom3']:.3f}, {found['cpu_s']:.0f} CPU-s", flush=True)


# What the regressions know


def moments(parent, signs):
    """Size, net charge, dipole and quadrupole about the centroid, and what more a regression could be given."""
    charges = parent.pattern(signs)
    r = parent.positions - parent.positions.mean(axis=0)
    radius = np.sqrt((r**2).sum(axis=1).mean())
    second = 3 * np.einsum("i,ij,ik->jk", charges, r, r) - np.eye(3) * (charges * (r**2).sum(axis=1)).sum()
    dipole, quadrupole = np.linalg.norm(charges @ r), np.linalg.norm(second) / 3
    charged = charges != 0
    x, q = r[charged], charges[charged]
    distances = np.linalg.norm(x[:, None] - x, axis=2)
    products = np.triu(q[:, None] * q, 1)
    screened = np.exp(-distances / DEBYE_ANGSTROM) / np.maximum(distances, 1.0)
    correlations = np.histogram(distances, bins=[2.5, 6, 10, 15, 20, 25, 60], weights=products)[0]
    return {
        "moments": [
            *(np.log(parent.residues), radius, charges.sum()),
            *(dipole, dipole**2 / radius**2, np.log(dipole), quadrupole, quadrupole**2 / radius**4, np.log(quadrupole)),
        ],
        "energy": [(products * screened).sum()],
        "correlations": correlations.tolist(),
    }


def ridge(x, y, new, penalty=1.0):
    """Numbers at `new`, by a linear regression on standardised features with a unit penalty."""
    middle, spread = x.mean(axis=0), x.std(axis=0) + 1e-12
    x, new = (x - middle) / spread, (new - middle) / spread
    slope = np.linalg.solve(x.T @ x + penalty * np.eye(x.shape[1]), x.T @ (y - y.mean()))
    return y.mean() + new @ slope


def attraction(ratio):
    """The label: the logarithm of -B2/B2(hard) of what the charges add to B2. B2 itself is up to its tail in a few patterns."""
    return np.log(np.maximum(-ratio, WEAKEST))


class Table:
    """All patterns with their features and labels."""

    def __init__(self, output):
        self.rows, known = patterns(output), parents(output)
        self.names = [row["name"] for row in self.rows]
        self.parent = np.array([row["parent"] for row in self.rows])
        self.part = np.array([row["part"] for row in self.rows])
        features = [moments(known[row["parent"]], row["signs"]) for row in self.rows]
        self.features = {kind: np.array([row[kind] for row in features]) for kind in features[0]}
        # The mean of each parent is known to every regression that is held out by pattern.
        self.features["parent"] = (self.parent[:, None] == np.array(PARENTS)).astype(float)
        # Labels: the part of B2 that is due to the charges, over the hard part; a column for each seed.
        self.seeds, self.error = np.full((len(self.names), len(SEEDS)), np.nan), np.zeros(len(self.names))
        self.hard = {}
        for name in PARENTS:
            paths = [output / "labels" / f"{name}-{seed}.json" for seed in SEEDS]
            found = [json.loads(path.read_text()) for path in paths if path.exists()]
            self.hard[name] = found[0]["hard_angstrom3"]
            own = self.parent == name
            charges = np.array([label["charges_angstrom3"] for label in found])
            self.seeds[own, : len(found)] = attraction(charges / self.hard[name]).T
            self.error[own] = np.array(found[0]["error_angstrom3"]) / np.abs(charges[0])
        # What is learnt, and what it is judged by: errors that all patterns of a parent share are not taken for physics.
        self.y, self.truth = self.seeds.T

    def regression(self, kinds, train, y=None):
        """Predictions for all patterns by a regression on these features, fitted to the patterns `train`."""
        x = np.hstack([self.features[kind] for kind in kinds])
        y = self.y if y is None else y
        return ridge(x[train], y[train], x)

    def at(self, kinds, train, row):
        """What such a regression says about one more pattern."""
        x = np.hstack([self.features[kind] for kind in kinds])
        return ridge(x[train], self.y[train], np.hstack([row[kind] for kind in kinds])[None])[0]


# Networks


def trained(output, table, folder, train, numbers, seed):
    """Predictions for all patterns by a network that is trained on `numbers` of the patterns `train`; made once."""
    run = output / "networks" / f"{folder}-{seed}"
    if not (run / "all.csv").exists():
        lines = [f"{name},{number:.8f}" if use else f"{name}," for name, number, use in zip(table.names, numbers, train)]
        labels = output / "tables" / f"{folder}.csv"
        write(labels, "\n".join(["name,number", *lines]) + "\n")
        words = ["--labels", labels, "--fractions", "0.84,0.15,0.01", "--epochs", EPOCHS, "--patience", 20, *NETWORK, "--seed", seed, "--split-seed", 1]
        _, cpu = protomer("train", output / "set.zarr", *words, "-o", run, "-q")
        protomer("predict", run, output / "set.zarr", "-o", run / "all.csv", "-q", "--force")
        print(f"{run.name}: {train.sum()} patterns, {cpu:.0f} CPU-s", flush=True)
    with open(run / "all.csv", newline="") as file:
        known = {row["name"]: float(row["predicted_number"]) for row in csv.DictReader(file)}
    return np.array([known[name] for name in table.names])


def validation(output, folder, table):
    """The patterns of a training that its networks have not been fitted to."""
    with open(output / "networks" / f"{folder}-{ENSEMBLE[0]}" / "all.csv", newline="") as file:
        parts = {row["name"]: row["part"] for row in csv.DictReader(file)}
    return np.array([parts[name] in ("validation", "test") for name in table.names])


def ensemble(output, table, folder, train, numbers, seeds=ENSEMBLE):
    return np.array([trained(output, table, folder, train, numbers, seed) for seed in seeds])


def residual(table, train, kinds=("moments", "parent")):
    """What the regression on these leaves of the labels."""
    return table.y - table.regression(kinds, train)


def training_parts(table):
    """The patterns of each training that needs no choice: test part never, shares of the others, all parents but one."""
    place = np.array([int(name.split("-")[1]) - TEST for name in table.names])
    parts = {f"{count} of each": (place >= 0) & (place < count) for count in SHARES}
    return dict(reversed(parts.items())) | {f"without {name}": table.parent != name for name in PARENTS}


def stage_networks(output):
    table = Table(output)
    for name, train in training_parts(table).items():
        left = residual(table, train, ("moments",) if name.startswith("without") else ("moments", "parent"))
        ensemble(output, table, name.replace(" ", "-"), train, left)


def chosen_by(output, table, arm):
    """The training part of an arm after each round: the first patterns, and what each round adds."""
    place = np.array([int(name.split("-")[1]) - TEST for name in table.names])
    train = (place >= 0) & (place < FIRST)
    parts = [train]
    for number in range(ROUNDS):
        if arm == "uncertain":
            spread = ensemble(output, table, f"{arm}-{number}" if number else f"{FIRST}-of-each", train, residual(table, train), VOTERS).std(axis=0)
        else:
            spread = np.random.default_rng([SEED, 100]).random(len(table.names))
        train = train.copy()
        for name in PARENTS:
            free = np.flatnonzero((table.parent == name) & (place >= 0) & ~train)
            train[free[np.argsort(-spread[free])][:PER_ROUND]] = True
        parts.append(train)
    return parts


def stage_rounds(output):
    """Two arms from the same start: the least certain patterns get labels, or random ones."""
    table = Table(output)
    for arm in ("uncertain", "random"):
        train = chosen_by(output, table, arm)[-1]
        ensemble(output, table, f"{arm}-{ROUNDS}", train, residual(table, train), VOTERS)


# Mutants


def grids_of_sites(output, parent, signs):
    """Voxels of a parent in its deposited orientation: the shape with the fixed charges, and the potential of each site alone.

    In a uniform solvent potentials add up, so these give the voxels of every pattern and its derivatives by the charges.
    """
    folder = output / "sites" / parent.name
    if not (folder / "set.zarr").exists():
        lines = ["file,label,cluster,name"]
        for number in range(-1, len(parent.sites) + 1):
            charges = parent.fixed.copy()
            if number == len(parent.sites):
                charges = parent.pattern(signs)
            elif number >= 0:
                charges[:] = 0.0
                for _, atom, magnitude in parent.atoms[number]:
                    charges[atom] = magnitude
            path = folder / f"{number + 1:03d}.pqr"
            write(path, parent.pqr(charges))
            lines.append(f"{path.resolve()},0,{number},{number + 1:03d}")
        write(folder / "manifest.csv", "\n".join(lines) + "\n")
        protomer("voxelize", "--manifest", folder / "manifest.csv", "-o", folder / "set.zarr", *VOXELS, "--orientation", "deposited", "-q")
    grids = np.array([pm.VoxelSet(folder / "set.zarr").grid(number) for number in range(len(parent.sites) + 2)])
    fixed, sites, whole = grids[0], grids[1:-1, 1], grids[-1]
    added = fixed[1] + np.tensordot(np.array(signs, float), sites, 1)
    if not np.allclose(added, whole[1], atol=2e-3 * np.abs(whole[1]).max()):
        raise SystemExit(f"{parent.name}: the potentials of the sites do not add up to that of the pattern")
    return fixed, sites


ROTATIONS = [(axes, flips) for axes in ((1, 2, 3), (2, 3, 1), (3, 1, 2)) for flips in ((), (1, 2))]
"""Six of the rotations of the cube."""


def residual_and_gradient(networks, fixed, sites, signs):
    """The predicted residual of a pattern, and its derivative by the charge of each site, means over networks and rotations."""
    grid = fixed.copy()
    grid[1] += np.tensordot(np.array(signs, float), sites, 1)
    number, gradient = 0.0, np.zeros(len(sites))
    for axes, flips in ROTATIONS:
        turned = np.ascontiguousarray(np.flip(grid.transpose(0, *axes), flips))
        basis = np.flip(sites.transpose(0, *axes), flips).reshape(len(sites), -1)
        for network in networks:
            value, slope = network.predict(turned, gradient=True)
            number, gradient = number + value, gradient + basis @ slope.ravel()
    count = len(ROTATIONS) * len(networks)
    return number / count, gradient / count


def ascend(networks, regress, fixed, sites, signs):
    """Exchanges of two charges of opposite sign, by the gradient, while they raise the predicted attraction."""
    signs = np.array(signs)
    value, gradient = residual_and_gradient(networks, fixed, sites, signs)
    total, path = value + regress(signs), []
    for _ in range(STEPS):
        pairs, guesses = [(i, j) for i in np.flatnonzero(signs > 0) for j in np.flatnonzero(signs < 0)], []
        for i, j in pairs:
            # To first order by the gradient of the network; the regression is cheap enough to be asked itself.
            guesses.append(value - 2 * gradient[i] + 2 * gradient[j] + regress(exchanged(signs, i, j)))
        for best in np.argsort(guesses)[::-1][:TRIED]:
            other = exchanged(signs, *pairs[best])
            new, slope = residual_and_gradient(networks, fixed, sites, other)
            if new + regress(other) > total + 1e-4:
                path.append([*map(int, pairs[best]), float(guesses[best]), float(new + regress(other))])
                signs, value, gradient, total = other, new, slope, new + regress(other)
                break
        else:
            break
    return signs, value, total, path


def exchanged(signs, i, j):
    other = signs.copy()
    other[i], other[j] = signs[j], signs[i]
    return other


def stage_mutants(output):
    """From a pattern of each parent, whose B2 is the median of its test part, to patterns of stronger predicted attraction; then `pair`."""
    table, known = Table(output), parents(output)
    name = f"{SHARES[-1]}-of-each"
    train = training_parts(table)[f"{SHARES[-1]} of each"]
    networks = [Network(output / "networks" / f"{name}-{seed}") for seed in ENSEMBLE]
    chosen = output / "mutants.json"
    if not chosen.exists():
        made = []
        for number, parent_name in enumerate([*PARENTS, PARENTS[0]]):
            parent = known[parent_name]
            own = np.flatnonzero((table.parent == parent_name) & (table.part == "test"))
            # The fifth starts from another pattern of the first parent.
            start = own[np.argsort(table.y[own])[len(own) // 2 + (5 if number == len(PARENTS) else 0)]]
            signs = table.rows[start]["signs"]
            fixed, sites = grids_of_sites(output, parent, table.rows[own[0]]["signs"])

            def regress(pattern, parent=parent):
                row = moments(parent, pattern)
                row["parent"] = (np.array(PARENTS) == parent.name).astype(float)
                return float(table.at(("moments", "parent"), train, row))

            before, _ = residual_and_gradient(networks, fixed, sites, signs)
            after, left, total, path = ascend(networks, regress, fixed, sites, signs)
            write(output / "pqr" / f"mutant-{number + 1}.pqr", parent.pqr(parent.pattern(after)))
            made.append({
                "name": f"mutant-{number + 1}", "parent": parent_name, "start": table.names[start], "signs": after.tolist(), "path": path,
                "predicted_start": before + regress(np.array(signs)), "predicted": total, "predicted_residual": left, "regression": regress(after),
                "exchanges": int((after != np.array(signs)).sum() // 2),
            })
            print(f"mutant {number + 1} of {parent_name}: {len(path)} steps, predicted {made[-1]['predicted_start']:.3f} -> {total:.3f}", flush=True)
        write(chosen, json.dumps(made))
    for seed in SEEDS:
        for row in json.loads(chosen.read_text()):
            found = by_pair(output, row["name"], seed)
            print(f"{row['name']}, seed {seed}: {found['b2_angstrom3']:.0f} ± {found['b2_error_angstrom3']:.0f} Å³, {found['cpu_s']:.0f} CPU-s", flush=True)


# Report


def explained(truth, said, draws=2000, random=None):
    """The share of the variance of `truth` that predictions explain, with an interval over draws of patterns."""
    random = random or np.random.default_rng(3)

    def share(places):
        t, s = truth[places], said[places]
        return 1 - ((t - s) ** 2).sum() / ((t - t.mean()) ** 2).sum()

    drawn = random.integers(0, len(truth), (draws, len(truth)))
    values = np.array([share(places) for places in drawn])
    return share(np.arange(len(truth))), *np.percentile(values, [2.5, 97.5])


def gained(truth, one, other, draws=2000):
    """How much more of the variance `one` explains than `other`, with an interval over draws of patterns."""
    drawn = np.random.default_rng(3).integers(0, len(truth), (draws, len(truth)))

    def difference(places):
        t = truth[places]
        return (((t - other[places]) ** 2).sum() - ((t - one[places]) ** 2).sum()) / ((t - t.mean()) ** 2).sum()

    values = np.array([difference(places) for places in drawn])
    return difference(np.arange(len(truth))), *np.percentile(values, [2.5, 97.5])


def cell(found, sign=""):
    return f"{found[0]:{sign}.2f} ({found[1]:{sign}.2f} to {found[2]:{sign}.2f})"


def stage_report(output):
    table, known = Table(output), {}
    test = table.part == "test"
    noise = (table.y - table.truth) ** 2 / 2
    print(f"{len(table.y)} labels, from {table.y.min():.2f} to {table.y.max():.2f}\n")
    print("| parent | sites | mean label | standard deviation | after moments | error of a label, from two seeds | CPU-s per label |\n|---|---|---|---|---|---|---|")
    everything = training_parts(table)[f"{SHARES[-1]} of each"]
    left = residual(table, everything)
    for name in PARENTS:
        own = table.parent == name
        cpu = sum(json.loads((output / "labels" / f"{name}-{seed}.json").read_text())["cpu_s"] for seed in SEEDS)
        sites = len(next(row for row in table.rows if row["parent"] == name)["signs"])
        values = [table.y[own].mean(), table.y[own].std(), left[own & test].std(), np.sqrt(noise[own].mean())]
        print(f"| {name} | {sites} | {' | '.join(f'{value:.3f}' for value in values)} | {cpu / own.sum():.2f} |")
    ceiling = 1 - noise[test].mean() / (table.truth - table.y + left)[test].var()
    print(f"\nlabel errors leave {ceiling:.3f} of the variance of the residual of the test part to be explained\n")
    print("| trained on | moments, of B2 itself | energy of the charges | correlations | network | network and correlations | gain over correlations |\n|---|---|---|---|---|---|---|")
    for name, train in training_parts(table).items():
        folder = name.replace(" ", "-")
        if not all((output / "networks" / f"{folder}-{seed}" / "all.csv").exists() for seed in ENSEMBLE):
            continue
        without = name.startswith("without")
        kinds = ("moments",) if without else ("moments", "parent")
        left = residual(table, train, kinds)
        judged = ~train if without else test
        network = ensemble(output, table, folder, train, left).mean(axis=0)
        of_y = explained(table.truth[judged], (table.y - left)[judged])
        # Judged by poses that the training has not seen.
        true_left = table.truth - table.y + left
        energy = table.regression((*kinds, "energy"), train, left)
        correlations = table.regression((*kinds, "correlations"), train, left)
        held = validation(output, folder, table)
        fitted = table.regression((*kinds, "correlations"), train & ~held, left)
        both = stacked(left, held, fitted, network)
        cells = [cell(explained(true_left[judged], said[judged])) for said in (energy, correlations, network, both)]
        print(f"| {name} ({train.sum()}) | {cell(of_y)} | {' | '.join(cells)} | {cell(gained(true_left[judged], both[judged], correlations[judged]), '+')} |")
        if not known:
            # The largest training comes first.
            judged_last = {"test": test, "left": true_left, "network": network}
        known[name] = {"network": explained(true_left[judged], network[judged]), "correlations": explained(true_left[judged], correlations[judged]), "count": int(train.sum())}
    for arm in ("uncertain", "random"):
        folder = f"{arm}-{ROUNDS}"
        if all((output / "networks" / f"{folder}-{seed}" / "all.csv").exists() for seed in VOTERS):
            train = chosen_by(output, table, arm)[-1]
            left = residual(table, train)
            said = ensemble(output, table, folder, train, left, VOTERS).mean(axis=0) + table.y - left
            known[arm] = said
            print(f"\n{arm}: {train.sum()} labels, of B2 itself {cell(explained(table.truth[test], said[test]))}, rms error {np.sqrt(((said - table.truth)[test] ** 2).mean()):.4f}")
    if "random" in known:
        print(f"uncertain less random, of B2 itself: {cell(gained(table.truth[test], known['uncertain'][test], known['random'][test]), '+')}")
    if any(isinstance(found, dict) for found in known.values()):
        draw(output / "residual-b22.svg", table, known, judged_last)
    report_check(output, table)
    report_mutants(output, table)


def stacked(left, held, *said):
    """Predictions together: least squares with an intercept on the validation part of the training, which neither has been fitted to."""
    x = np.column_stack([np.ones(len(left)), *said])
    return x @ np.linalg.lstsq(x[held], left[held], rcond=None)[0]


def draw(path, table, known, judged):
    """Predicted against true residuals of the test part, and what is explained against the number of labels."""
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "residual"
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4))
    left.axline((0, 0), slope=1, color="0.7", linewidth=1)
    for name in PARENTS:
        own = judged["test"] & (table.parent == name)
        left.plot(judged["left"][own], judged["network"][own], ".", markersize=5, label=name)
    left.set_xlabel("ln attraction left by the regression on moments")
    left.set_ylabel("predicted by the network")
    left.legend(frameon=False)
    shares = [(found["count"], found) for name, found in known.items() if isinstance(found, dict) and not name.startswith("without")]
    for kind, colour in (("network", "C0"), ("correlations", "C1")):
        counts = [count for count, _ in shares]
        values = np.array([found[kind] for _, found in shares])
        errors = np.abs(values[:, 1:].T - values[:, 0])
        right.errorbar(counts, values[:, 0], yerr=errors, fmt="o-", color=colour, capsize=3, label=kind)
    right.set_xscale("log")
    right.set_xticks(counts, map(str, counts))
    right.minorticks_off()
    right.set_xlabel("labels in training")
    right.set_ylabel("variance of the residual explained, test part")
    right.legend(frameon=False)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def report_check(output, table):
    lines = []
    for name in table.names:
        kept = output / "pair" / f"{name}-1.json"
        place = table.names.index(name)
        if kept.exists() and int(name.split("-")[1]) < CHECKED:
            found = json.loads(kept.read_text())
            ratio = (found["b2_angstrom3"] - found["b2_hard_angstrom3"]) / found["b2_hard_angstrom3"]
            error = found["b2_error_angstrom3"] / found["b2_hard_angstrom3"] / abs(ratio)
            lines.append((name, attraction(ratio), error, table.y[place], table.error[place]))
    if lines:
        print("\n| pattern | `pair` | ± | shared poses | ± | standard errors apart |\n|---|---|---|---|---|---|")
        for name, pair, error, own, own_error in lines:
            print(f"| {name} | {pair:.3f} | {error:.3f} | {own:.3f} | {own_error:.3f} | {(own - pair) / np.hypot(error, own_error):+.1f} |")


def report_mutants(output, table):
    if not (output / "mutants.json").exists():
        return
    print("\n| parent | start | exchanges | predicted: start | proposed | regression alone | label of the start | `pair`, seed 1 | seed 2 | 95th percentile of the labels | largest |")
    print("|" + "---|" * 11)
    for row in json.loads((output / "mutants.json").read_text()):
        hard = table.hard[row["parent"]]

        def measured(name, seed):
            kept = output / "pair" / f"{name}-{seed}.json"
            if not kept.exists():
                return "-"
            found = json.loads(kept.read_text())
            charges = found["b2_angstrom3"] - found["b2_hard_angstrom3"]
            return f"{attraction(charges / hard):.2f} ± {found['b2_error_angstrom3'] / abs(charges):.2f}"

        own = table.y[table.parent == row["parent"]]
        start = table.names.index(row["start"])
        cells = [row["parent"], row["start"], str(row["exchanges"]), f"{row['predicted_start']:.2f}", f"{row['predicted']:.2f}", f"{row['regression']:.2f}"]
        cells += [f"{table.y[start]:.2f}", measured(row["name"], SEEDS[0]), measured(row["name"], SEEDS[1]), f"{np.percentile(own, 95):.2f}", f"{own.max():.2f}"]
        print("| " + " | ".join(cells) + " |")


STAGES = {
    "patterns": lambda structures, output: stage_patterns(structures, output),
    "labels": lambda _, output: stage_labels(output),
    "check": lambda _, output: stage_check(output),
    "networks": lambda _, output: stage_networks(output),
    "rounds": lambda _, output: stage_rounds(output),
    "mutants": lambda _, output: stage_mutants(output),
    "report": lambda _, output: stage_report(output),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("structures", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("stages", nargs="*", metavar="STAGE", help="all if none is named: " + ", ".join(STAGES))
    arguments = parser.parse_args()
    unknown = set(arguments.stages) - set(STAGES)
    if unknown:
        parser.error(f"no such stage: {', '.join(sorted(unknown))}; there are {', '.join(STAGES)}")
    for name, stage in STAGES.items():
        if not arguments.stages or name in arguments.stages:
            stage(arguments.structures, arguments.output)


if __name__ == "__main__":
    main()
