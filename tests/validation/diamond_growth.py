"""Truncated tetrahedra that crystallise from the fluid: how much is diamond, and what a frame looks like in between.

    protomer hpmc run --shape truncated-tetrahedron:0.6666666666666666 --bodies 216 --packing-fraction 0.5 --pressure 150 \\
      --equilibration 20000 --sweeps 5000000 --sample-every 1000 --trajectory-every 20000 --seed 5 -o RUN
    python tests/validation/diamond_growth.py RUN FRAME PICTURE.png

Prints the parts of the bodies in cubic and in hexagonal diamond, means over ten frames, and draws them next to the diffraction
pattern and the positional autocorrelation of one frame, seen along its layers. Needs `pip install protomer[dynamics]`.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

from protomer.structure import Structure

matplotlib.use("Agg")
import matplotlib.pyplot as plt

TOGETHER = 10
EQUILIBRATION = 20_000
EVERY = 20_000
# Of the grid of the autocorrelation, in edges of the tetrahedron, and of the Gaussians on it.
SPACING, WIDTH, REACH = 0.05, 0.1, 1.5
LARGEST_WAVE_NUMBER = 30.0


def growth(structure: Structure) -> np.ndarray:
    """Sweeps, the parts in cubic and in hexagonal diamond, the mean conformation: a row for ten frames."""
    rows = []
    for first in range(0, len(structure.positions), TOGETHER):
        last = min(first + TOGETHER, len(structure.positions))
        found = [structure.diamond(frame) for frame in range(first, last)]
        means = [(d.cubic.mean(), d.hexagonal.mean(), d.conformation.mean()) for d in found]
        rows.append([0.5 * (first + last - 1) * EVERY - EQUILIBRATION, *np.mean(means, axis=0)])
    return np.array(rows)


def main() -> None:
    run, frame, picture = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    structure = Structure.read(run)
    rows = growth(structure)
    print("| sweeps | cubic | hexagonal | conformation |\n|---|---|---|---|")
    for sweeps, cubic, hexagonal, conformation in rows:
        print(f"| {sweeps:.2e} | {cubic:.2f} | {hexagonal:.2f} | {conformation:.2f} |")
    figure, axes = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
    for column, name in [(1, "cubic diamond"), (2, "hexagonal diamond")]:
        axes[0].plot(rows[:, 0], rows[:, column], marker="o", label=name)
    axes[0].set(xlabel="sweeps", ylabel="part of the bodies", ylim=(0, 1))
    axes[0].legend()
    axis = structure.contact_axis(frame)
    k, pattern = structure.diffraction(along=axis, k_max=LARGEST_WAVE_NUMBER, frame=frame)
    axes[1].pcolormesh(k, k, np.log10(pattern + 1e-3).T, shading="nearest", vmin=-1)
    axes[1].set(title="diffraction along the layers", xlabel="k_x", ylabel="k_y", aspect="equal")
    correlation = structure.autocorrelation(up=axis, spacing=SPACING, width=WIDTH, reach=REACH, frame=frame)
    correlation.plot(axes[2])
    axes[2].set_title("autocorrelation, Δz = 0")
    figure.savefig(picture, dpi=80)


if __name__ == "__main__":
    main()
