"""The samples of a task, and how clusters are dealt out: folds, blocks, exchanged labels."""

import collections
import json
import random

from entries import chains
from pairs import moments
from plan import CLASSES, FOLDS, MOST_OF_A_CLUSTER, ONE_LETTER, SIZE_CUTS, TASKS


def samples_of(output, task):
    """The samples of a task: name, PQR file, cluster, label, and what baselines may know."""
    samples = []
    if TASKS[task] == "oligomer":
        taken = collections.Counter()
        for row in chains(output):
            if row["label"] in CLASSES[task] and taken[row["cluster"]] < MOST_OF_A_CLUSTER:
                taken[row["cluster"]] += 1
                pqr = output / "chains" / f"{row['name']}.pqr"
                known = {"composition": [row["sequence"].count(x) / len(row["sequence"]) for x in ONE_LETTER.values()]}
                known |= {"residues": len(row["sequence"]), **moments(pqr)}
                samples.append({**row, **known, "pqr": pqr})
        return samples
    for path in sorted((output / "pairs").glob("*.json")):
        row = json.loads(path.read_text())
        row["ratio"] = row["b2_angstrom3"] / row["b2_hard_angstrom3"]
        if task == "number":
            label = str(row["ratio"])
        else:
            label = CLASSES[task][sum(row["ratio"] >= cut for cut in ((1.0,) if task == "sign" else SIZE_CUTS))]
        samples.append({**row, "label": label, "pqr": path.with_suffix(".pqr")})
    return samples


def blocks(samples):
    """The samples of each cluster, as lists of their numbers."""
    known = collections.defaultdict(list)
    for i, sample in enumerate(samples):
        known[sample["cluster"]].append(i)
    return list(known.values())


def folds_of(samples):
    """The fold of each sample: whole clusters, the largest first, each to the fold with the fewest samples so far."""
    groups = blocks(samples)
    random.Random(1).shuffle(groups)
    fold, held = [0] * len(samples), [0] * FOLDS
    for group in sorted(groups, key=len, reverse=True):
        least = held.index(min(held))
        held[least] += len(group)
        for i in group:
            fold[i] = least
    return fold


def exchanged(groups, draw):
    """Which sample each sample gets its label from: clusters of one size exchange their labels as blocks."""
    source = list(range(sum(map(len, groups))))
    by_size = collections.defaultdict(list)
    for group in groups:
        by_size[len(group)].append(group)
    for equal in by_size.values():
        for group, other in zip(equal, draw.sample(equal, len(equal))):
            for i, j in zip(group, draw.sample(other, len(other))):
                source[i] = j
    return source
