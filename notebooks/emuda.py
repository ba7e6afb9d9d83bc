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
# # The elastic constants of hinged frameworks
#
# Networks of rods joined by hinges can grow wider when pulled: their Poisson's ratio is negative. Elastic constants
# follow from second derivatives of the energy with the nodes relaxed, the method of Grima et al., Mol. Simul. 31, 925
# (2005). Here: rotating squares, honeycombs compared with closed formulas, and the tables of the paper.
#
# All of it takes a second or two.

# %%
import warnings
from collections import Counter

import matplotlib.pyplot as plt
import numpy as np

import protomer as pm

# The figures show how two mechanisms compete, so nobody needs to be warned of it.
warnings.filterwarnings("ignore", "two mechanisms compete")

# %% [markdown]
# ## Rotating squares
#
# Squares that touch at their corners, with rods of stiffness k_s and hinges of stiffness k_h. If the rods are stiff
# compared with the hinges, the squares turn as rigid bodies: what is pulled along one direction grows as much along the
# other, and Poisson's ratio goes to -1. The deviation falls as k_h / k_s.

# %%
stiffness_ratio = np.logspace(0, 6, 25)
squares = [pm.framework.rotating_squares(angle=25, side=2, kh=1, ks=float(ratio)) for ratio in stiffness_ratio]
ratio_of_squares = np.array([network.nu_yz for network in squares])

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
left.semilogx(stiffness_ratio, ratio_of_squares, "o-")
left.axhline(-1, color="0.5", linestyle="--", linewidth=1)
left.set(xlabel="k_s / k_h (rad²/Å²)", ylabel="Poisson's ratio")
right.loglog(stiffness_ratio, 1 + ratio_of_squares, "o-")
right.set(xlabel="k_s / k_h (rad²/Å²)", ylabel="1 + Poisson's ratio");

# %%
slope = np.polyfit(np.log(stiffness_ratio[-3:]), np.log(1 + ratio_of_squares[-3:]), 1)[0]
print(f"ν = {ratio_of_squares[-1]:.6f} at k_s / k_h = 10⁶; 1 + ν falls with the power {slope:.3f}")
assert np.all(np.diff(ratio_of_squares[stiffness_ratio >= 10]) < 0)
assert abs(1 + ratio_of_squares[-1]) < 1e-4
assert abs(slope + 1) < 0.01

# %% [markdown]
# ## Honeycombs
#
# A honeycomb with upright ribs of h = 2 Å and slanting ribs of l = 1 Å, at an angle θ between the two. Below 90° it is
# re-entrant, like a row of bow ties; above, each cell is an ordinary hexagon. Lines are the closed formulas for
# hinging and stretching at once, dots the second derivatives of the network's energy.

# %%
angles_deg = np.linspace(45, 135, 46)
stiffnesses = [(50, 10000), (50, 1000), (50, 100)]
honeycombs = {
    (kh, ks): [pm.framework.honeycomb(h=2, l=1, theta=float(angle), kh=kh, ks=ks) for angle in angles_deg]
    for kh, ks in stiffnesses
}

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
for (kh, ks), networks in honeycombs.items():
    for panel, quantity in [(left, "nu_yz"), (right, "e_y_gpa")]:
        formula = [network.analytic[quantity] for network in networks]
        (line,) = panel.plot(angles_deg, formula, label=f"k_s = {ks}, k_h = {kh}")
        dots = [network[quantity] for network in networks[::3]]
        panel.plot(angles_deg[::3], dots, "o", markersize=4, color=line.get_color())
left.axhline(0, color="0.5", linewidth=1)
left.set(xlabel="θ (degrees)", ylabel="Poisson's ratio ν_yz")
left.legend(frameon=False, fontsize="small")
right.set(xlabel="θ (degrees)", ylabel="Young's modulus E_y (GPa)", yscale="log");

# %%
QUANTITIES = ["e_y_gpa", "e_z_gpa", "g_yz_gpa", "nu_yz", "nu_zy"]
deviation = {
    quantity: max(
        abs(network[quantity] - network.analytic[quantity]) / max(abs(network.analytic[quantity]), 1e-3)
        for networks in honeycombs.values()
        for network in networks
    )
    for quantity in QUANTITIES
}
shown = ", ".join(f"{name} {value:.0e}" for name, value in deviation.items())
print("largest relative deviation from the formulas:", shown)
assert max(deviation.values()) < 1e-8
assert honeycombs[50, 10000][0].nu_yz < 0 < honeycombs[50, 10000][-1].nu_yz
assert max(abs(network.nu_yz) for network in honeycombs[50, 100]) < 1e-9

# %% [markdown]
# The softer the rods, the less the honeycomb hinges, and the smaller the ratio. At k_s = 100 the two mechanisms cancel
# for every angle.
#
# ## The tables of the paper
#
# Every number of tables 2 to 4, computed again. `same` means equal to the number as printed, `one_unit` that it differs
# by one in the last printed digit, `off` by more. What is off is listed by table; the [written
# comparison](../docs/validation/emuda.md) says why.

# %%
tables = pm.framework.tables().items
values = [(row, value) for row in tables for value in row["values"]]
counts = Counter(value.agreement for _, value in values)
print(", ".join(f"{name}: {count}" for name, count in counts.items()))
for row, value in values:
    if value.agreement == "off":
        network = f"table {row.table}, {row.mechanism:10} {row.theta_deg:3.0f}°"
        print(f"  {network}, {value.quantity:8} {value.computed:10.4f} (printed {value.printed:>8})")

figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
edges = np.arange(-8, -1.99, 0.25)
deviations = {
    name: [np.log10(max(abs(value.deviation), 1e-8)) for _, value in values if value.agreement == name]
    for name in ["same", "one_unit", "off"]
}
colours = ["#0072B2", "#E69F00", "#D55E00"]
axes.hist(list(deviations.values()), bins=edges, stacked=True, color=colours, label=list(deviations))
axes.set(xlabel="log₁₀ of the relative deviation from the printed number", ylabel="numbers")
axes.legend(frameon=False);

# %%
assert counts["same"] > 0.75 * len(values)
assert max(abs(value.deviation) for _, value in values) < 0.005
