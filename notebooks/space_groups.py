# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#       format_version: '1.3'
#       jupytext_version: 1.19.6
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Does a protein's surface tell its crystal?
#
# A network is asked for the crystal system from the surface of the molecule, its potential and its hydropathy. What it
# answers is shown next to what can be said without looking at a surface: the most frequent class, the frequencies alone,
# the size, the charge and the composition. Relatives by sequence never stand on both sides of the split.
#
# Name a folder of structures with a `MANIFEST.tsv` (columns file, sg_reference_name, cluster, cell) in
# `PROTOMER_SPACEGROUPS` to ask the question for real; results for 376 entries stand in
# [the validation page](../docs/validation/network.md). Without it, pieces of a bundled protein carry space groups that
# were drawn by lot. Then nothing can be learnt, and the evaluation must say so.
#
# `PROTOMER_FAST=1` trains fewer epochs, with one seed per subset of the channels.

# %%
import csv
import gzip
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import protomer as pm

FAST = os.environ.get("PROTOMER_FAST") == "1"
FOLDER = os.environ.get("PROTOMER_SPACEGROUPS")
PROJECT = next(path for path in Path.cwd().resolve().parents if (path / "data" / "structures").is_dir())

# Files go to a temporary folder. Name one of your own to keep them, and to continue a training that was stopped.
folder = tempfile.TemporaryDirectory()
work = Path(folder.name)

# %% [markdown]
# ## Structures and labels
#
# Pieces of twelve residues of HIV-1 protease (4E43), one every two residues of both chains. Those that begin within
# the same six residues are a cluster, whichever chain they are of.


# %%
def pieces(length=12, step=2):
    """Writes pieces of the bundled protease; yields file, label, cluster."""
    labels = random.Random(1)
    text = gzip.open(PROJECT / "data" / "structures" / "4e43.pdb.gz", "rt").read()
    atoms = [line for line in text.splitlines() if line.startswith("ATOM")]
    for chain in "AB":
        for first in range(1, 99 - length, step):
            inside = [line for line in atoms if line[21] == chain and first <= int(line[22:26]) < first + length]
            file = work / f"piece_{chain}{first:02}.pdb"
            file.write_text("\n".join([*inside, "END", ""]))
            yield file.name, labels.choice(["P 1", "C 1 2 1", "P 21 21 21"]), first // 6


manifest = work / "manifest.csv"
with open(manifest, "w", newline="") as file:
    if FOLDER:
        script = PROJECT / "tests" / "validation" / "spacegroups_manifest.py"
        subprocess.run([sys.executable, script, FOLDER], stdout=file, check=True)
    else:
        csv.writer(file).writerows([("file", "label", "cluster"), *pieces()])

# %%
made = pm.voxelize(
    manifest=manifest,
    size=48 if FOLDER else 20,
    spacing="fit",
    potential="poisson-boltzmann" if FOLDER else "debye-hueckel",
    seed=1,
    output=work / "set.zarr",
)
print(f"{made.samples} of {made.structures} structures fit the grid")
assert made.samples > 0.5 * made.structures

# %% [markdown]
# ## Training, with every subset of the channels

# %%
settings = {"epochs": 20, "ablation_seeds": 3} if FOLDER or not FAST else {"epochs": 3, "ablation_seeds": 1}
training = pm.train(
    work / "set.zarr", target="crystal-system", ablate=True, **settings, seed=1, output=work / "training"
)
samples = training.samples
print(f"{samples.training} to train on, {samples.validation} to stop by, {samples.test} to test on")
print("classes:", ", ".join(training.classes))

# %% [markdown]
# ## Compared with what does not see the surface
#
# Nats gained over the prior: how much better the probabilities are than the frequencies of the training part. Below 0
# they are worse. The interval is that of a bootstrap over clusters; p that of exchanging labels between clusters.

# %%
interval = training.bootstrap_95.nats_gained_over_prior
print(f"network: {interval.estimate:+.3f} nats ({interval.low:+.3f} to {interval.high:+.3f}), p = {training.permutation_p:.2g}")
print(f"accuracy {training.accuracy:.3f}, that of the most frequent class {training.majority_accuracy:.3f}")
assert interval.low <= interval.estimate <= interval.high
if not FOLDER:
    assert training.permutation_p > 0.01, "labels drawn by lot were learnt: something leaks"

prior = training.prior_log_loss_nats
baselines = {"size": "size", "size_and_charge": "size and charge", "composition": "composition"}
gains = {"network": interval.estimate}
gains |= {shown: prior - training.baselines[name].log_loss_nats for name, shown in baselines.items()}

rows = training.ablation.rows
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained", sharex=True)
left.barh(list(gains), list(gains.values()), color=["#0072B2", "0.6", "0.6", "0.6"])
left.errorbar(interval.estimate, 0, xerr=[[interval.estimate - interval.low], [interval.high - interval.estimate]], color="black")
left.axvline(0, color="black", linewidth=1)
left.invert_yaxis()
left.set(xlabel="nats gained over the prior", title="what is known about the test part")
names = [" + ".join(row.channels) for row in rows]
means = [row.nats_gained_over_prior.mean for row in rows]
errors = [row.nats_gained_over_prior.standard_error or 0 for row in rows]
right.barh(names, means, xerr=errors, color="#0072B2")
right.axvline(0, color="black", linewidth=1)
right.invert_yaxis()
right.set(xlabel="nats gained over the prior", title="each subset of the channels");

# %% [markdown]
# ## Which are taken for which

# %%
confusion = np.array(training.confusion_matrix)
figure, axes = plt.subplots(figsize=(4.6, 3.8), layout="constrained")
image = axes.imshow(confusion, cmap="Blues")
for row, column in np.ndindex(confusion.shape):
    dark = confusion[row, column] > 0.6 * confusion.max()
    axes.text(column, row, f"{confusion[row, column]:.0f}", ha="center", va="center", color="white" if dark else "black")
axes.set_xticks(range(len(training.classes)), training.classes, rotation=40, ha="right")
axes.set_yticks(range(len(training.classes)), training.classes)
axes.set(xlabel="predicted", ylabel="true")
assert np.isclose(confusion.sum(), samples.test);
