"""Truncated tetrahedra that settle on a floor among depletants: layers by height, and how they stack.

    protomer hpmc run --shape truncated-tetrahedron:0.6666666666666666 --bodies 100 --packing-fraction 0.25 \\
      --box 1,0.8662,1.761 --gravity 12 --depletants 0.03909:FUGACITY --equilibration 2000 --sweeps SWEEPS \\
      --sample-every 1000 --trajectory-every 5000 --points 1 --seed 5 -o RUN
    python tests/validation/tetrahedra_sediment.py RUN...

Prints a row for each run, means over the last quarter of its frames: bodies in the lower half of the box, the peaks of their density, contacts
(pairs that are among each other's four nearest) in layers and between them, and which parts of these are staggered and eclipsed. A
contact is between layers if its line is within 30 degrees of the vertical. Needs `pip install protomer[dynamics]`.
"""

import sys
from pathlib import Path

import numpy as np

from protomer.structure import Structure

UPRIGHT = np.cos(np.radians(30.0))
CLEARLY = 0.5
BIN = 0.1
PEAK = 2.0
"""A bin with so many times the mean density is in a layer."""


def main() -> None:
    print(
        "| run | frames | in the lower half | layers | contacts in layers | staggered | eclipsed | between layers | staggered |"
        " eclipsed | cubic | hexagonal |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for name in sys.argv[1:]:
        structure = Structure.read(Path(name))
        count = len(structure.positions)
        frames = range(count - max(1, count // 4), count)
        sums = {"lower": 0.0, "cubic": 0.0, "hexagonal": 0.0}
        counts = np.zeros((2, 3))
        heights = []
        for frame in frames:
            edges = structure.boxes[frame][:3]
            places = structure.positions[frame]
            heights.append(places[:, 2] + 0.5 * edges[2])
            found = structure.diamond(frame)
            sums["lower"] += float(np.mean(places[:, 2] < 0))
            sums["cubic"] += float(np.mean(found.cubic))
            sums["hexagonal"] += float(np.mean(found.hexagonal))
            between = places[found.contacts[:, 1]] - places[found.contacts[:, 0]]
            between[:, :2] -= edges[:2] * np.round(between[:, :2] / edges[:2])
            upright = np.abs(between[:, 2]) > UPRIGHT * np.linalg.norm(between, axis=1)
            for row, chosen in enumerate((~upright, upright)):
                values = found.conformation[chosen]
                counts[row] += len(values), np.sum(values < -CLEARLY), np.sum(values > CLEARLY)
        number = len(frames)
        height = structure.boxes[-1][2]
        density = np.histogram(np.concatenate(heights), np.arange(0.0, height + BIN, BIN))[0]
        is_peak = density > PEAK * density.mean()
        layers = int(np.sum(is_peak[1:] & ~is_peak[:-1]) + is_peak[0])
        parts = counts[:, 1:] / np.maximum(counts[:, :1], 1)
        cells = [
            f"{number}",
            f"{sums['lower'] / number:.2f}",
            f"{layers}",
            f"{counts[0, 0] / number:.1f} | {parts[0, 0]:.2f} | {parts[0, 1]:.2f}",
            f"{counts[1, 0] / number:.1f} | {parts[1, 0]:.2f} | {parts[1, 1]:.2f}",
            f"{sums['cubic'] / number:.2f} | {sums['hexagonal'] / number:.2f}",
        ]
        print(f"| {Path(name).name} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
