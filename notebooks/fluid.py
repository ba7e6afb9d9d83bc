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
# # Do charged proteins find each other?
#
# Positive and negative variants of BPTI start at random places in a box. How large do clusters become at low salt, and
# at high salt?
#
# `PROTOMER_FAST=1` makes the runs short.

# %%
import os
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import protomer as pm

FAST = os.environ.get("PROTOMER_FAST") == "1"
ROOT = next(folder for folder in [Path.cwd(), *Path.cwd().parents] if (folder / "data" / "structures").is_dir())
BPTI = ROOT / "data" / "structures" / "5pti.cif.gz"

# Files go to a temporary folder. Name one of your own to keep them, and to continue a run that was stopped.
folder = tempfile.TemporaryDirectory()
work = Path(folder.name)

# %% [markdown]
# ## A fluid of two kinds
#
# A box must be wider than the reach of the charges, which is longest at low salt. `protomer` says so if it is not.

# %%
pm.ingest(BPTI, output=work, name="plus", mutate=["A:D3K", "A:E7K", "A:E49K", "A:D50K"])
minus = ["A:R1E", "A:K15E", "A:R17E", "A:K26E", "A:R39E", "A:K41E", "A:R42E", "A:K46E", "A:R53E"]
pm.ingest(BPTI, output=work, name="minus", mutate=minus)
bodies = [work / "plus.body", work / "minus.body"]
fluid = pm.assemble.fluid(bodies, counts=[6, 6], box=230, seed=1, output=work / "fluid.json")
print(f"{fluid.bodies} bodies, {fluid.concentration_millimolar:.2f} mM")
assert fluid.bodies == 12

# %% [markdown]
# ## Runs at two salt concentrations
#
# The short equilibration only tunes the step sizes, so that nearly the whole of the assembly is in the log.

# %%
SALTS = {"50mM": "#0072B2", "500mM": "#D55E00"}
settings = {"replicas": 2, "sweeps": 160} if FAST else {"replicas": 4, "sweeps": 3000}
sweep = pm.sweep(
    work / "fluid.json", salt=list(SALTS), **settings, energy="calibrated", equilibration=20, seed=1, output=work / "runs"
)


def logs(salt_molar):
    """The logs of all replicas at a salt concentration, as arrays with the names of the columns."""
    places = sorted((work / "runs" / f"salt_{salt_molar:.6f}M").glob("replica_*/log.csv"))
    return [np.genfromtxt(place, delimiter=",", names=True) for place in places]


series = {salt: logs(molar) for salt, molar in zip(SALTS, sweep.salt_molar)}

# %% [markdown]
# ## Cluster size and energy against time
#
# Bodies are in one cluster if a chain of contacts (surfaces closer than 5 Å) joins them. Thin lines are the replicas,
# thick ones their mean.

# %%
figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
for salt, replicas in series.items():
    for panel, column in zip(panels, ["largest_cluster", "energy_kT"]):
        for log in replicas:
            panel.plot(log["sweep"], log[column], color=SALTS[salt], linewidth=0.7, alpha=0.5)
        mean = np.mean([log[column] for log in replicas], axis=0)
        panel.plot(replicas[0]["sweep"], mean, color=SALTS[salt], linewidth=2, label=salt.replace("mM", " mM"))
panels[0].set(xlabel="sweep", ylabel="bodies in the largest cluster", ylim=(0, 12.5))
panels[1].set(xlabel="sweep", ylabel="energy (kT)")
panels[0].legend(frameon=False);

# %% [markdown]
# ## What this shows, and what it does not
#
# * Charged bodies gather at low salt and stay apart at high salt. That much is certain after a few hundred sweeps.
# * No equilibrium, and no size to quote. In the short form the curves at low salt still move. In the long form, as run on
#   2026-11-22, the energy falls for some two thousand sweeps, while the largest cluster goes to and fro between three
#   and ten of the twelve bodies.
# * Sweeps are no physical time. Cluster moves are among them.
# * All replicas share one start here. Other starts (`seed=`) should be taken before drawing conclusions.
# * Whether bodies meet in the *right* places is another question. In the [study with sixteen
#   GFPs](../docs/validation/assembly-from-fluid.md) they did not: no contact like those of the designed stack was
#   found.


# %%
def late(salt, column):
    """Mean of the last quarter of the logs."""
    return np.mean([log[column][-len(log) // 4 :] for log in series[salt]])


for salt in SALTS:
    print(f"{salt}: largest cluster {late(salt, 'largest_cluster'):.1f}, energy {late(salt, 'energy_kT'):.0f} kT")
assert late("50mM", "largest_cluster") > late("500mM", "largest_cluster")
assert late("50mM", "energy_kT") < -20 < late("500mM", "energy_kT")
