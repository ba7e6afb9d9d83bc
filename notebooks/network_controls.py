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
# # Does the network look where the answer is?
#
# Before a result on real data means anything, the same training must learn what is there and nothing else. In this
# control solids carry a positive or a negative net charge. Only the potential tells the sign; the shape knows nothing
# of it. The network is trained with every subset of the two channels, and compared with what can be said without it.
#
# `PROTOMER_FAST=1` trains fewer epochs, with one seed per subset.

# %%
import os
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import protomer as pm

FAST = os.environ.get("PROTOMER_FAST") == "1"

# Files go to a temporary folder. Name one of your own to keep them, and to continue a training that was stopped.
folder = tempfile.TemporaryDirectory()
work = Path(folder.name)

# %% [markdown]
# ## Training
#
# `short=True` takes the control's coarse grids and few samples. The test part shares no cluster with the training
# part.

# %%
settings = {"epochs": 3, "ablation_seeds": 1} if FAST else {"epochs": 12, "ablation_seeds": 3}
training = pm.train(
    control="charge", short=True, channels="shape,potential", ablate=True, **settings, seed=1, output=work / "charge"
)
print(f"{training.samples.training} samples to train on, {training.samples.test} to test on")
for experiment in training.control.experiments:
    bounds = f"{experiment.at_least:.2f} to {experiment.at_most:.2f}"
    print(f"{experiment.name}: balanced accuracy {experiment.balanced_accuracy:.3f}, expected {bounds}")
assert training.control.reached

# %% [markdown]
# ## With and without the potential
#
# Bars are means over seeds, with standard errors if there are several. Grey is what does not look at the voxels: the
# most frequent class, and regressions on the size and on the net charge itself. The dashed line is guessing.

# %%
rows = training.ablation.rows
names = [" + ".join(row.channels) for row in rows]
scores = [row.balanced_accuracy.mean for row in rows]
errors = [row.balanced_accuracy.standard_error or 0 for row in rows]
baselines = {"majority": "majority", "size": "size", "size_and_charge": "size and charge"}
known = [training.baselines[name].balanced_accuracy for name in baselines]

figure, axes = plt.subplots(figsize=(8, 3.2), layout="constrained")
colours = ["#0072B2"] * len(rows) + ["0.5"] * len(known)
bars = axes.barh([*names, *baselines.values()], scores + known, xerr=errors + [0] * len(known), color=colours)
for bar, score in zip(bars, scores + known):
    axes.text(0.01, bar.get_y() + bar.get_height() / 2, f"{score:.2f}", va="center", color="white")
axes.axvline(0.5, color="black", linestyle="--", linewidth=1)
axes.invert_yaxis()
axes.set(xlabel="balanced accuracy on the test part", xlim=(0, 1.05));

# %%
of_subset = dict(zip(names, scores))
assert of_subset["shape + potential"] > 0.95 and of_subset["potential"] > 0.95
assert of_subset["shape"] < 0.65
assert training.baselines.majority.balanced_accuracy == 0.5

# %% [markdown]
# With the potential the sign is always found, without it the network guesses. It has learnt the charge and found no
# other way to the label. Note the last bar: a regression on the net charge does as well. This control shows that the
# training works, not that a network was needed.
#
# ## The learning curve

# %%
figure, axes = plt.subplots(figsize=(5.4, 3.2), layout="constrained")
for place, label in [("charge", "with potential"), ("charge/shape-alone", "shape alone")]:
    history = np.genfromtxt(work / place / "history.csv", delimiter=",", names=True)
    axes.plot(history["epoch"], history["validation_loss_nats"], "o-", label=label)
axes.axhline(np.log(2), color="black", linestyle="--", linewidth=1, label="guessing, ln 2")
axes.set(xlabel="epoch", xticks=history["epoch"], ylabel="validation loss (nats)", ylim=(-0.05, None))
axes.legend(frameon=False);
