"""Draws the figures of the papers on the lattice of rigid squares from the tables of the example paper_figures and from
sweeps of 2 x 2 squares, of which it writes what is drawn.

    python rhua_lattice.py FOLDER [SWEEPS]
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

FOLDER = Path(sys.argv[1])
SWEEPS = Path(sys.argv[2]) if len(sys.argv) > 2 else None
# The same tables give the same bytes.
plt.rcParams.update({"svg.hashsalt": "rhua", "svg.fonttype": "none", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False})


def table(name):
    return np.genfromtxt(FOLDER / f"{name}.csv", delimiter=",", names=True)


def rows_of_sweep(name, columns, **constants):
    """The rows of a sweep, with these of its columns under new names."""
    with open(SWEEPS / name / "lattice.csv", newline="") as file:
        for row in csv.DictReader(file):
            yield constants | {new: float(row[old]) for new, old in columns.items()}


def write(name, rows):
    rows = list(rows)
    with open(FOLDER / f"{name}.csv", "w", newline="") as file:
        print(*rows[0], sep=",", file=file)
        for row in rows:
            print(*(f"{value:.6g}" for value in row.values()), sep=",", file=file)


def tables_of_sweeps():
    exponent = {"r0": "r0", "runs": "runs", "exponent": "lyapunov_exponent", "error": "lyapunov_exponent_error"}
    for name in ["lyapunov", "lyapunov_free", "lyapunov_growth"]:
        write(name, rows_of_sweep(name, exponent))
    share = {
        "r0": "r0",
        "trajectories": "runs",
        "of_total": "checkerboard_deviation_of_total",
        "of_total_error": "checkerboard_deviation_of_total_error",
        "of_rotational": "checkerboard_deviation",
        "of_rotational_error": "checkerboard_deviation_error",
        "mean_share": "checkerboard_fraction_of_total",
        "mean_share_error": "checkerboard_fraction_of_total_error",
    }
    rows = []
    for angles in [0, 0.01, 0.1]:
        for spins in [0, 0.001, 0.01, 0.1, 0.3, 1]:
            disorder = {"angle_spread": angles, "rate_spread": spins}
            rows += rows_of_sweep(f"checkerboard_{angles}_{spins}", share, **disorder)
    write("checkerboard_small", rows)


def save(figure, name):
    figure.tight_layout()
    figure.savefig(FOLDER / f"{name}.svg", metadata={"Date": None})
    plt.close(figure)


def label(length):
    return "3/22" if abs(length - 3 / 22) < 1e-3 else f"{length:g}"


def colours(lengths):
    return dict(zip(lengths, plt.cm.viridis(np.linspace(0, 0.92, len(lengths)))))


def by_length(rows):
    lengths = np.unique(rows["r0"])
    palette = colours(lengths)
    for length in lengths:
        yield length, rows[rows["r0"] == length], palette[length]


def phase_differences():
    figure, axes = plt.subplots(1, 2, figsize=(7.5, 3))
    for rows, axis, title in [
        (table("phase_differences"), axes[0], "1000 steps of 0.01"),
        (table("long_differences"), axes[1], "r0 = l, ten times longer"),
    ]:
        for length, part, colour in by_length(rows):
            axis.fill_between(
                part["time"],
                part["staggered"] - part["staggered_error"],
                part["staggered"] + part["staggered_error"],
                color=colour,
                alpha=0.3,
                lw=0,
            )
            axis.plot(part["time"], part["staggered"], color=colour, lw=1, label=label(length))
        axis.set(xlabel="time", ylabel="rms difference of $(-1)^{i+j}\\theta$", title=title, ylim=(0, None))
    axes[0].legend(title="$r_0/l$", fontsize=7, ncols=2)
    save(figure, "phase-differences")


def synchronisation():
    rows = table("synchronisation")
    figure, axes = plt.subplots(1, 2, figsize=(7.5, 3))
    for axis, columns in [(axes[0], ("R_eigenvalue", "P_eigenvalue")), (axes[1], ("P_near", "P_far"))]:
        for column, marker in zip(columns, "os"):
            axis.errorbar(rows["r0"], rows[column], rows[f"{column}_error"], marker=marker, ms=4, lw=1, capsize=2)
        axis.set(xscale="log", xlabel="$r_0/l$")
    axes[0].set(yscale="log", ylabel="largest eigenvalue")
    axes[0].legend(["|R|", "|P|"])
    axes[1].set(ylabel="mean |P|", ylim=(0, None))
    axes[1].legend(["joined by a rod", "all others"])
    save(figure, "synchronisation")
    names = ["0.02", "0.14", "0.50", "2.00"]
    figure, axes = plt.subplots(1, 4, figsize=(9, 2.7), sharey=True)
    for name, axis in zip(names, axes):
        matrix = np.loadtxt(FOLDER / f"synchronisation_{name}.csv", delimiter=",") / 1000
        shown = axis.imshow(np.sqrt(matrix), vmin=0, vmax=1, cmap="magma", interpolation="none")
        axis.set_title("$r_0/l$ = " + (label(3 / 22) if name == "0.14" else f"{float(name):g}"), fontsize=8)
        axis.set_xticks([])
        axis.set_yticks([])
    bar = figure.colorbar(shown, ax=axes, fraction=0.02, ticks=np.sqrt([0, 0.1, 0.3, 0.6, 1]))
    bar.ax.set_yticklabels(["0", "0.1", "0.3", "0.6", "1"])
    figure.savefig(FOLDER / "synchronisation-matrices.svg", metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)


def strains():
    rows, fits = table("strains"), table("poisson")
    lengths = np.unique(rows["r0"])
    figure, axes = plt.subplots(2, 4, figsize=(9, 4.6))
    panels = [(rows[rows["r0"] == length], length) for length in lengths] + [(table("long_strains"), None)]
    for (part, length), axis in zip(panels, axes.flat):
        axis.plot(1e3 * part["xx"], -1e3 * part["yy"], ".", ms=1.5, alpha=0.6, rasterized=True)
        bound = 1e3 * np.quantile(np.abs(np.concatenate([part["xx"], part["yy"]])), 0.995)
        fit = table("long") if length is None else fits[np.isclose(fits["r0"], length)]
        # -ε_yy = ν_xy ε_xx.
        slope = fit["nu_xy"].item()
        axis.plot([-bound, bound], [-bound * slope, bound * slope], lw=1)
        title = "1, ten times longer" if length is None else label(length)
        axis.set(xlim=(-bound, bound), ylim=(-bound, bound), title=f"$r_0/l$ = {title}")
    for axis in axes[1]:
        axis.set_xlabel("$10^3\\,\\varepsilon_{xx}$")
    for axis in axes[:, 0]:
        axis.set_ylabel("$-10^3\\,\\varepsilon_{yy}$")
    save(figure, "strains")
    figure, axis = plt.subplots(figsize=(4.6, 3))
    axis.errorbar(fits["r0"], fits["nu_xy"], fits["nu_xy_error"], marker="o", ms=4, lw=1, capsize=2, label="$\\nu_{xy}$")
    axis.errorbar(fits["r0"], fits["r_squared"], fits["r_squared_error"], marker="s", ms=4, lw=1, capsize=2, label="$r^2$")
    axis.axhline(-1, color="grey", lw=0.7)
    axis.set(xscale="log", xlabel="$r_0/l$", ylim=(-1.2, 1.05))
    axis.legend(fontsize=7)
    save(figure, "poisson")


def coherent_orbit():
    curves, runs = table("coherent_orbit"), table("coherent_run")
    figure, axes = plt.subplots(1, 2, figsize=(7.5, 3))
    for size in np.unique(curves["size"]):
        part = curves[(curves["size"] == size) & (curves["r0"] == 0)]
        for sign in (1, -1):
            axes[0].plot(
                part["angle"], sign * part["rate"], color=f"C{int(size) % 7}", label=f"{size:g} x {size:g}" if sign > 0 else None
            )
    axes[0].set_title("$r_0$ = 0", fontsize=9)
    palette = colours(np.unique(curves["r0"]))
    for length in np.unique(curves["r0"]):
        part = curves[(curves["size"] == 2) & (curves["r0"] == length)]
        run = runs[np.isclose(runs["r0"], length)]
        for sign in (1, -1):
            name = label(length) if sign > 0 else None
            axes[1].plot(part["angle"], sign * part["rate"], color=palette[length], lw=1, label=name)
        axes[1].plot(run["angle"], run["rate"], ".", ms=3, color=palette[length])
    axes[1].set_title("2 x 2: curves exact, dots simulated", fontsize=9)
    for axis in axes:
        axis.set(xlabel="$\\theta_c$", ylabel="$\\omega_c/\\omega_c(\\mathrm{open})$")
        axis.legend(fontsize=7)
    save(figure, "coherent-orbit")


def energies():
    rows = table("energies")
    figure, axes = plt.subplots(1, 2, figsize=(7.5, 3))
    for length, part, colour in by_length(rows):
        ours = part[part["step"] < 0.01]
        papers = part[part["step"] == 0.01]
        axes[0].plot(ours["time"], 1e3 * (ours["relative_energy"] - 1), color=colour, lw=1, label=label(length))
        if len(papers):
            axes[1].plot(papers["time"], papers["relative_energy"], color=colour, lw=1)
    axes[0].set(xlabel="time", ylabel="$10^3\\,(E/E_0 - 1)$", title="steps of min($r_0$/50, 0.005)")
    axes[1].set(xlabel="time", ylabel="$E/E_0$", title="steps of 0.01")
    axes[0].set_ylim(0, 7)
    axes[0].legend(title="$r_0/l$", fontsize=7, ncols=4, loc="upper center")
    save(figure, "energies")


def checkerboard():
    rows = table("checkerboard_small")
    figure, axes = plt.subplots(1, 3, figsize=(9, 3), sharey=True)
    for angle, axis in zip(np.unique(rows["angle_spread"]), axes):
        for length, part, colour in by_length(rows[rows["angle_spread"] == angle]):
            for column, style in [("of_rotational", "-o"), ("of_total", ":s")]:
                axis.errorbar(
                    part["rate_spread"],
                    part[column],
                    part[f"{column}_error"],
                    fmt=style,
                    ms=3,
                    lw=1,
                    capsize=2,
                    color=colour,
                    label=label(length) if style == "-o" else None,
                )
        axis.set_xscale("symlog", linthresh=1e-3)
        axis.set(xlabel="$\\sigma(\\omega)$ asked for", title=f"$\\sigma(\\theta)$ = {angle:g} asked for")
    axes[0].set(ylabel="σ of the checkerboard share")
    axes[0].legend(title="$r_0/l$", fontsize=7)
    save(figure, "checkerboard-small")
    rows = table("checkerboard_large")
    figure, axis = plt.subplots(figsize=(4.6, 3))
    for column, name in [("of_rotational", "of rotational energy"), ("of_total", "of all energy")]:
        axis.errorbar(rows["r0"], rows[column], rows[f"{column}_error"], marker="o", ms=4, lw=1, capsize=2, label=name)
    axis.set(xscale="log", xlabel="$r_0/l$", ylabel="σ of the checkerboard share", ylim=(0, None))
    axis.legend(fontsize=7)
    save(figure, "checkerboard-large")


def lyapunov():
    figure, axis = plt.subplots(figsize=(4.6, 3))
    for name, title in [
        ("lyapunov", "with collisions"),
        ("lyapunov_free", "without"),
        ("lyapunov_growth", "growth along the coherent orbit, t < 1.5"),
    ]:
        rows = table(name)
        axis.errorbar(rows["r0"], rows["exponent"], rows["error"], marker="o", ms=4, lw=1, capsize=2, label=title)
    axis.set(xscale="log", yscale="log", xlabel="$r_0/l$", ylabel="$\\lambda_\\mathrm{max}$")
    axis.legend(fontsize=7)
    save(figure, "lyapunov")


def opening():
    rows, bodies = table("opening"), table("opening_snapshots")
    figure, axes = plt.subplots(2, 3, figsize=(9, 6))
    for time, axis in zip(np.unique(bodies["time"]), axes.flat):
        part = bodies[bodies["time"] == time]
        for index, square in enumerate(part):
            turns = square["angle"] + np.pi / 4 + np.pi / 2 * np.arange(5)
            colour = ["tab:blue", "tab:orange"][(index // 10 + index) % 2]
            axis.fill(square["x"] + np.cos(turns), square["y"] + np.sin(turns), color=colour, lw=0)
        axis.set(aspect="equal", xticks=[], yticks=[], xlim=(-11.5, 11.5), ylim=(-11.5, 11.5), title=f"t = {time:g}")
    axis = axes[1, 2]
    for column in range(10):
        axis.plot(rows["time"], rows[f"a{column}"], color="grey", lw=0.4)
    axis.plot(rows["time"], rows["checkerboard"], lw=1, label="$\\theta_c$")
    axis.plot(rows["time"], rows["spread"], lw=1, label="σ(θ)")
    axis.set(xlabel="time", ylabel="$(-1)^{i+j}\\theta$")
    axis.legend(fontsize=7)
    save(figure, "opening")


def potential():
    rows = table("potential")
    figure, axes = plt.subplots(1, 3, figsize=(9, 3))
    for length, part, colour in by_length(rows):
        kappa = np.where(part["kappa"] == 0, 3, part["kappa"])
        axes[0].plot(kappa, part["spread"], "-o", ms=3, lw=1, color=colour, label=label(length))
        axes[1].plot(kappa, part["time"], "-o", ms=3, lw=1, color=colour)
        axes[2].plot(kappa, part["largest_spread"], "-o", ms=3, lw=1, color=colour)
    for axis, name in zip(axes, ["first maximum of σ(θ)", "its time", "largest σ(θ) up to t = 3"]):
        axis.set(xscale="log", xlabel="κ (leftmost: 0)", ylabel=name)
    axes[0].set_yscale("log")
    axes[2].set_yscale("log")
    axes[1].set_ylim(0, None)
    axes[0].legend(title="$r_0/l$", fontsize=7)
    save(figure, "potential")


if SWEEPS:
    tables_of_sweeps()
for draw in [
    phase_differences,
    synchronisation,
    strains,
    coherent_orbit,
    energies,
    checkerboard,
    lyapunov,
    opening,
    potential,
]:
    draw()
