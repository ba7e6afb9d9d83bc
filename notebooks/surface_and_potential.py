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
# # A protein's surface, coloured by potential and by hydropathy
#
# The solvent-excluded surface of BPTI as a mesh, the electrostatic potential on it from the linearised
# Poisson-Boltzmann equation, the potential in a plane through the protein, and the hydropathy of the residues at the
# surface.
#
# `PROTOMER_FAST=1` takes a coarser grid and mesh.

# %%
import os
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize, SymLogNorm
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import protomer as pm

FAST = os.environ.get("PROTOMER_FAST") == "1"
ROOT = next(folder for folder in [Path.cwd(), *Path.cwd().parents] if (folder / "data" / "structures").is_dir())
BPTI = ROOT / "data" / "structures" / "5pti.cif.gz"

# Files go to a temporary folder. Name one of your own to keep them.
folder = tempfile.TemporaryDirectory()
work = Path(folder.name)

# %% [markdown]
# ## The body
#
# A body has its own frame. `origin_angstrom` says where its origin is in the coordinates of the file.

# %%
body = pm.Body.from_structure(BPTI, density=1 if FAST else 3)
print(body)

# %% [markdown]
# ## The potential
#
# `points=` asks for the potential at places of our own: here 1.4 Å outside each vertex, where the centre of a water
# molecule would be that touches the surface. `output=` keeps the grid.


# %%
def outward(vertices, triangles):
    """Unit normals of the vertices: the mean of those of the triangles around, weighted by area."""
    first, second, third = (vertices[triangles[:, corner]] for corner in range(3))
    twice_area = np.cross(second - first, third - first)
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], twice_area)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


places = body.vertices_angstrom + 1.4 * outward(body.vertices_angstrom, body.triangles)
in_file = places + body.origin_angstrom
np.savetxt(work / "points.txt", in_file)
solved = pm.potential(
    BPTI, salt="100mM", spacing=0.7 if FAST else 0.4, points=work / "points.txt", output=work / "potential.npz"
)
potential = solved.potentials_kt_per_e
print(f"solvation energy {solved.solvation_energy_kj_mol:.0f} ± {solved.error_estimate_kj_mol:.0f} kJ/mol")
print(f"potential there: {potential.min():.1f} to {potential.max():.1f} kT/e, mean {potential.mean():+.2f}")

with np.load(work / "potential.npz") as volume:
    grid, origin, spacing = volume["potential_kt_per_e"], volume["origin_angstrom"], float(volume["spacing_angstrom"])

# %% [markdown]
# The grid has the axes z, y, x. Read off by linear interpolation between its points, it must say what `points=` said.
# Close to charges `points=` is the better one: there it adds the Coulomb potential itself.


# %%
def interpolated(points_angstrom):
    """The potential at points by trilinear interpolation, kT/e."""
    place = (points_angstrom - origin) / spacing
    corner = np.floor(place).astype(int)
    part = place - corner
    total = np.zeros(len(points_angstrom))
    for step in np.ndindex(2, 2, 2):
        x, y, z = (corner + step).T
        weight = np.prod(np.where(step, part, 1 - part), axis=1)
        total += weight * grid[z, y, x]
    return total


assert np.isfinite(potential).all()
difference = np.abs(interpolated(in_file) - potential)
print(f"difference of the two: median {np.median(difference):.3f}, at most {difference.max():.2f} kT/e")
assert np.median(difference) < 0.02
assert np.corrcoef(interpolated(in_file), potential)[0, 1] > 0.99

# %% [markdown]
# Screened Coulomb potentials of the same charges, in water everywhere, are a rough guess at it. They miss what the
# protein's low permittivity does, but must agree in sign and pattern.

# %%
BJERRUM_ANGSTROM = 7.16
distance = np.linalg.norm(places[:, None] - body.charge_positions_angstrom[None], axis=2)
screened = np.exp(-distance / solved.debye_length_angstrom) / distance
guess = BJERRUM_ANGSTROM * screened @ body.charges_e
correlation = np.corrcoef(guess, potential)[0, 1]
print(f"correlation with the screened Coulomb sum: {correlation:.2f}")
assert correlation > 0.7
assert body.net_charge_e > 0 and potential.mean() > 0

# %% [markdown]
# ## Hydropathy
#
# Every vertex takes the hydropathy of the residue whose atom is nearest.

# %%
hydropathy = body.hydropathy[distance.argmin(axis=1)]
assert np.nanmin(hydropathy) >= -4.5 and np.nanmax(hydropathy) <= 4.5


# %%
def draw(axes, values, colours, limit, azimuth):
    """The surface seen from one side, a value per vertex as colour, shaded by the direction of its triangles."""
    corners = body.vertices_angstrom[body.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    angle, height = np.radians(azimuth - 20), np.radians(40)
    light = np.array([np.cos(height) * np.cos(angle), np.cos(height) * np.sin(angle), np.sin(height)])
    shade = 0.55 + 0.45 * np.clip(normals @ light, 0, 1)
    of_triangle = np.median(np.nan_to_num(values)[body.triangles], axis=1)
    face = colours(Normalize(-limit, limit)(of_triangle))
    face[:, :3] *= shade[:, None]
    axes.add_collection3d(Poly3DCollection(corners, facecolors=face, edgecolors=face, linewidths=0.2))
    reach = 0.8 * np.abs(body.vertices_angstrom).max()
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))
    axes.set_box_aspect((1, 1, 1), zoom=1.2)
    axes.view_init(elev=15, azim=azimuth)
    axes.set_axis_off()


figure = plt.figure(figsize=(9, 7.6), layout="constrained")
rows = [(potential, plt.cm.RdBu, 5, "potential (kT/e)"), (hydropathy, plt.cm.BrBG_r, 4.5, "hydropathy")]
for row, (values, colours, limit, label) in enumerate(rows):
    views = [figure.add_subplot(2, 2, 2 * row + 1 + side, projection="3d") for side in range(2)]
    for view, azimuth in zip(views, [30, 210]):
        draw(view, values, colours, limit, azimuth)
    scale = plt.cm.ScalarMappable(Normalize(-limit, limit), colours)
    figure.colorbar(scale, ax=views, label=label, shrink=0.7)

# %% [markdown]
# The same body from both sides. Above: blue is positive, red negative. Below: brown is hydrophobic, green hydrophilic.
#
# ## A plane through the protein
#
# The potential in the plane z = 0 of the body's frame, with the outline of the surface. The colours are linear up to
# 0.5 kT/e and logarithmic above, because the potential inside, close to single charges, is so much larger.

# %%
x, y, z = (
    start + spacing * np.arange(size) for start, size in zip(origin - body.origin_angstrom, reversed(grid.shape))
)
plane = np.abs(z).argmin()


def outline(height_angstrom):
    """Where the surface crosses the plane z = height: segments of two points (x, y), Å."""
    corners = body.vertices_angstrom[body.triangles]
    above = corners[:, :, 2] > height_angstrom
    segments = []
    for triangle in corners[above.any(axis=1) & ~above.all(axis=1)]:
        ends = []
        for first, second in zip(triangle, np.roll(triangle, 1, axis=0)):
            if (first[2] > height_angstrom) != (second[2] > height_angstrom):
                part = (height_angstrom - first[2]) / (second[2] - first[2])
                ends.append((first + part * (second - first))[:2])
        segments.append(ends)
    return segments


figure, axes = plt.subplots(figsize=(5.4, 4.6), layout="constrained")
mesh = axes.pcolormesh(x, y, grid[plane], cmap="RdBu", norm=SymLogNorm(0.5, vmin=-100, vmax=100), shading="gouraud")
axes.add_collection(LineCollection(outline(z[plane]), colors="black", linewidths=1))
axes.set(aspect="equal", xlabel="x (Å)", ylabel="y (Å)", xlim=(-23, 23), ylim=(-23, 23))
axes.set_title(f"z = {z[plane]:.1f} Å, 100 mM salt")
figure.colorbar(mesh, label="potential (kT/e)", ticks=[-100, -10, -1, 0, 1, 10, 100], format="%g");

# %%
faces = np.stack([grid[0], grid[-1]])
print(f"largest potential on two faces of the grid: {np.abs(faces).max():.2f} kT/e")
assert np.abs(faces).max() < 0.5 * np.abs(potential).max()
