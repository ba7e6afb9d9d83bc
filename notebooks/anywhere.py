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

# %%
# Installs protomer where it is missing. Before it is on PyPI, put the path or the address of a release's wheel here.
import importlib.util
import subprocess
import sys

if importlib.util.find_spec("protomer") is None:
    subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "protomer[plot]"], check=True)

# %% [markdown]
# # A first result anywhere
#
# Which charges does a protein show to its neighbours, and at which salt does an assembly of two of its variants fall apart? This notebook needs
# nothing but Python on Linux: it installs protomer and fetches a structure of 454 atoms from the Protein Data Bank. It
# takes a minute.
#
# `PROTOMER_FAST=1` makes the runs short.

# %%
import os
import tempfile
from pathlib import Path

import numpy as np

import protomer as pm

FAST = os.environ.get("PROTOMER_FAST") == "1"

# Files go to a temporary folder. Name one of your own to keep them, and to continue a run that was stopped.
folder = tempfile.TemporaryDirectory()
work = Path(folder.name)

# %% [markdown]
# ## A structure
#
# BPTI, entry 5PTI. Within the project its own copy is taken, elsewhere that of the Protein Data Bank.

# %%
copies = [place / "data" / "structures" / "5pti.cif.gz" for place in [Path.cwd(), *Path.cwd().parents]]
bpti = next((copy for copy in copies if copy.exists()), None)
if bpti is None:
    pm.fetch("5pti", output=work)
    bpti = next(work.glob("5pti*"))
print(bpti)

# %% [markdown]
# ## Two bodies
#
# A body is the solvent-excluded surface of the protein with a charge at every atom. Acidic residues exchanged for lysine make one
# positive, basic ones exchanged for glutamate the other negative.

# %%
pm.ingest(bpti, output=work, name="plus", mutate=["A:D3K", "A:E7K", "A:E49K", "A:D50K"])
minus = ["A:R1E", "A:K15E", "A:R17E", "A:K26E", "A:R39E", "A:K41E", "A:R42E", "A:K46E", "A:R53E"]
pm.ingest(bpti, output=work, name="minus", mutate=minus)
bodies = {name: pm.Body.read(work / f"{name}.body") for name in ["plus", "minus"]}
for name, body in bodies.items():
    print(f"{name}: {body.net_charge_e:+.1f} e, {len(body.vertices_angstrom)} vertices")
assert bodies["plus"].net_charge_e > 10 and bodies["minus"].net_charge_e < -10

# %% [markdown]
# ## A ring of four, at several salt concentrations
#
# Unlike charges hold the ring together, and salt screens them.

# %%
pm.assemble.ring([work / "plus.body", work / "minus.body"], members=4, box=320, output=work / "ring.json")
if FAST:
    settings = {"salt": ["30mM", "300mM"], "replicas": 2, "sweeps": 20, "equilibration": 10}
else:
    settings = {"salt": "10mM..300mM/6", "replicas": 3, "sweeps": 400, "equilibration": 100}
sweep = pm.sweep(work / "ring.json", **settings, output=work / "sweep")
for salt, r_g, contacts in zip(sweep.salt_molar, sweep.r_g_angstrom, sweep.native_contacts):
    print(f"{1000 * salt:5.0f} mM: R_g {r_g:5.1f} Å, {100 * contacts:3.0f} % of the contacts left")
sweep.plot();

# %% [markdown]
# At low salt the ring holds. At high salt it is open, and the bodies are farther apart.

# %%
assert sweep.native_contacts[0] > 0.9 > sweep.native_contacts[-1]
assert np.all(np.isfinite(sweep.r_g_angstrom)) and sweep.r_g_angstrom[-1] > sweep.r_g_angstrom[0]

# %% [markdown]
# ## How to go on
#
# * Your own protein: another entry in `pm.fetch`, or the path of a PDB or mmCIF file.
# * `help(pm.sweep)` lists what can be set; the other notebooks show more.
