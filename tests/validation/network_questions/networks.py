"""Voxels of each fold, a network trained on the others, and what it says about the fold."""

import csv
import itertools
import json
import random

from plan import FOLDS, SETTINGS, TARGETS, TASKS, TRAINING, TRIED, VOXELS, VOXELS_OF, protomer, write
from samples import blocks, exchanged, folds_of, samples_of


def tried():
    return [(task, setting) for task, settings in TRIED.items() for setting in settings]


def folder_of(output, task, setting, permutation=0):
    """Where the sets of a task are: the first two settings share theirs."""
    name = f"{task}-debye-hueckel" if setting == "third" else task
    return output / (f"{name}-permuted-{permutation}" if permutation else name)


def reversed_charges(pqr, written):
    """Writes a copy of a PQR file with all charges reversed."""
    lines = []
    for line in pqr.read_text().splitlines():
        if line.startswith("ATOM"):
            before, charge, radius = line.rsplit(maxsplit=2)
            lines.append(f"{before}  {-float(charge):.8f}  {radius}")
    write(written, "\n".join(lines) + "\n")


def stage_sets(output, task, setting, permutation=0):
    """A set of voxels for each fold; beyond the first setting also one of the conjugates, in other orientations."""
    samples = samples_of(output, task)
    folder = folder_of(output, task, setting, permutation)
    source = range(len(samples))
    if permutation:
        source = exchanged(blocks(samples), random.Random(f"labels {permutation}"))
    fold = folds_of(samples)
    model = ["--potential", "debye-hueckel"] if setting == "third" else []
    kinds = ["fold", "conjugates"] if TASKS[task] == "b22" and setting != "first" else ["fold"]
    for kind, held in itertools.product(kinds, range(FOLDS)):
        done = folder / ("voxelize" if kind == "fold" else kind)
        done = done.with_name(f"{done.name}-{held}.json")
        if done.exists():
            continue
        lines = ["file,label,cluster,name"]
        for i, sample in enumerate(samples):
            if fold[i] != held:
                continue
            path, name, label = sample["pqr"], sample["name"], samples[source[i]]["label"]
            if kind == "conjugates":
                path, name = output / "conjugates" / path.name, f"{name}-conjugate"
                reversed_charges(sample["pqr"], path)
            lines.append(f"{path.resolve()},{label},{sample['cluster']},{name}")
        manifest, voxels = folder / f"{kind}-{held}.csv", folder / f"{kind}-{held}.zarr"
        write(manifest, "\n".join(lines) + "\n")
        words = ["voxelize", "--manifest", manifest, "-o", voxels, *VOXELS, *VOXELS_OF[TASKS[task]], *model]
        _, cpu = protomer(*words, "-q", "--force")
        write(done, json.dumps({"cpu_s": cpu, "structures": len(lines) - 1}))
        print(f"{folder.name}, {kind} {held}: {cpu / (len(lines) - 1):.2f} s per structure", flush=True)
    return folder


def runs_of(setting):
    return "runs-" + setting.replace(", ", "-").replace(" ", "-")


def stage_networks(folder, task, setting):
    """For each fold a network trained on the others, and what it says about the fold."""
    runs = folder / runs_of(setting)
    kinds = ["fold", "conjugates"] if setting != "first" and (folder / "conjugates-0.zarr").exists() else ["fold"]
    for held in range(FOLDS):
        if (runs / f"{held}.json").exists():
            continue
        others, run = folder / f"{'-'.join(kinds)}-without-{held}.zarr", runs / f"run-{held}"
        if not others.exists():
            parts = [folder / f"{kind}-{f}.zarr" for kind in kinds for f in range(FOLDS) if f != held]
            protomer("merge", *parts, "-o", others, "-q")
        _, train = protomer("train", others, *TRAINING, *SETTINGS[setting], *TARGETS.get(task, []), "-o", run, "-q")
        predictions = runs / f"predictions-{held}.csv"
        _, predict = protomer("predict", run, folder / f"fold-{held}.zarr", "-o", predictions, "-q", "--force")
        write(runs / f"{held}.json", json.dumps({"train_cpu_s": train, "predict_cpu_s": predict}))
        print(f"{runs.relative_to(folder.parent)}, fold {held}: {train:.0f} s", flush=True)
    return runs


def finished(runs):
    return all((runs / f"{held}.json").exists() for held in range(FOLDS))


def predictions(runs, classes):
    """The probabilities of the classes by the name of the sample; without classes the predicted number."""
    known = {}
    for held in range(FOLDS):
        with open(runs / f"predictions-{held}.csv", newline="") as file:
            for row in csv.DictReader(file):
                columns = [f"p_{name}" for name in classes] if classes else ["predicted_number"]
                known[row["name"]] = [float(row.get(column, 0.0)) for column in columns]
    return known
