"""Chapter 5 in small: how polygons and disks move over a ladder of densities.

    python tests/validation/polygon_dynamics.py OUTPUT [BODIES [TIME]]

Bodies are compressed over 3 time units and equilibrated as long as they are followed.

Runs `protomer md run` (global thermostat, smooth form, layer counted) for n = 3 to 9 and disks at each
density with three seeds, and analyses the trajectories with `protomer.dynamics`: the least local slope
of the mean squared displacement and where it is, the bond-orientational order, and the relaxation
times of velocities, of angular momenta and of orientations (⟨cos nΔθ⟩, n the symmetry); means and standard errors over the seeds.
The command is $PROTOMER, or target/release/protomer.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from protomer.dynamics import Seeds

HERE = Path(__file__).resolve().parent
PROTOMER = os.environ.get("PROTOMER", str(HERE / "../../target/release/protomer"))
SHAPES = {**{f"polygon:{n}": n for n in range(3, 10)}, "disk": 1}
DENSITIES = [float(x) for x in os.environ.get("DENSITIES", "0.5,0.6,0.65,0.68,0.7,0.72,0.75,0.78").split(",")]
SEEDS = (1, 2, 3)
TIME_STEP = 5e-4
# Bond order of each shape: k and the number of neighbours.
ORDER = {"polygon:3": (6, 3), "polygon:4": (4, 4)}


def simulate(output: Path, shape: str, density: float, seed: int, bodies: int, time: float) -> Path:
    folder = output / f"{shape.replace(':', '')}_{density}_{seed}"
    words = [
        PROTOMER, "md", "run", "--shape", shape, "--bodies", bodies, "--packing-fraction", density, "--seed", seed,
        "--ensemble", "nvt", "--relaxation-time", 1, "--time-step", TIME_STEP, "--steps", round(time / TIME_STEP),
        "--compress-steps", 6000, "--equilibrate-steps", round(time / TIME_STEP), "--trajectory-every", 40, "--log-every", 1000,
        "-o", folder, "--json", "-q", "-j", 1,
    ]
    subprocess.run([str(word) for word in words], capture_output=True, text=True, check=True)
    return folder


def row(shape: str, density: float, seeds: Seeds) -> dict:
    """What the table says of a shape at a density."""
    t, slope, error = seeds.curve("slope")
    # Before bodies met the slope falls from 2; it is least at a cage.
    least = int(np.argmin(slope))
    times = seeds.relaxation_times()
    order = seeds.bond_order(*ORDER.get(shape, (6, 6)))
    return {
        "shape": shape, "density": density, "least slope": (float(slope[least]), float(error[least])),
        "at": float(t[least]), "last slope": (float(slope[-1]), float(error[-1])), "order": order,
        "velocity": times["velocity"], "spinning": times["spinning"], "orientation": times["orientation"],
    }


def draw(rows: list[dict], path: Path) -> None:
    """Least slope, order and ratio of times against the density, with the errors over the seeds."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, 7))
    for number, shape in enumerate(SHAPES):
        of_shape = [row for row in rows if row["shape"] == shape]
        density = [row["density"] for row in of_shape]
        style = {"color": "black", "linestyle": "--"} if shape == "disk" else {"color": colours[number]}
        label = "disks" if shape == "disk" else f"n = {shape.split(':')[1]}"
        for ax, quantity in zip(axes, ("least slope", "order"), strict=False):
            value, error = np.array([row[quantity] for row in of_shape]).T
            ax.errorbar(density, value, error, marker="o", markersize=3, label=label, **style)
        if shape != "disk":
            ratio = [row["velocity"][0] / row["orientation"][0] for row in of_shape]
            axes[2].semilogy(density, ratio, marker="o", markersize=3, **style)
    axes[0].axhline(1.0, color="grey", linewidth=0.8)
    axes[0].set_ylabel("least slope of the mean squared displacement")
    axes[1].set_ylabel("⟨|ψ|⟩")
    axes[2].set_ylabel("τ of velocities / τ of orientations")
    for ax in axes:
        ax.set_xlabel("packing fraction, layer counted")
    axes[0].legend(fontsize="small")
    figure.savefig(path, dpi=100)


def main() -> None:
    output = Path(sys.argv[1])
    output.mkdir(parents=True, exist_ok=True)
    bodies = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    time = float(sys.argv[3]) if len(sys.argv) > 3 else 10.0
    rows = []
    print("| shape | packing | least slope | at t | last slope | order | τ velocity | τ spin | τ orientation | τ velocity / τ orientation |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for density in DENSITIES:
        for shape, symmetry in SHAPES.items():
            runs = [simulate(output, shape, density, seed, bodies, time) for seed in SEEDS]
            found = row(shape, density, Seeds(runs, symmetry=symmetry))
            rows.append(found)
            pair = lambda key: "{:.3f} ± {:.3f}".format(*found[key])  # noqa: E731
            ratio = found["velocity"][0] / found["orientation"][0]
            print(
                f"| {shape} | {density} | {pair('least slope')} | {found['at']:.2f} | {pair('last slope')} | "
                f"{pair('order')} | {pair('velocity')} | {pair('spinning')} | {pair('orientation')} | {ratio:.3f} |",
                flush=True,
            )
    (output / "rows.json").write_text(json.dumps(rows, indent=1))
    draw(rows, output / "polygon-dynamics.png")


if __name__ == "__main__":
    main()
