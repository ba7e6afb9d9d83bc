"""Truncated tetrahedra that crystallise on the floor of a box: what is crystal, of which kind, and at which height.

    protomer hpmc run --shape truncated-tetrahedron:0.6666666666666666 --bodies 420 --packing-fraction 0.2992 \\
      --box 1,1.0105,1.57 --gravity 8.63 --equilibration 1000 --sweeps 10000000 --sample-every 1000 \\
      --trajectory-every 20000 --seed 5 -o RUN
    python tests/validation/diamond_under_gravity.py RUN PICTURE.png

Prints, for each double layer along (111), bodies, their parts in cubic and in hexagonal diamond, and the mean conformation of
contacts, over the last frames; and draws these by height next to the diffraction pattern of the crystal seen from above. Needs
`pip install protomer[dynamics]`.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

from protomer.structure import Structure

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Of the diamond at 0.69: the height of a double layer, in edges of the tetrahedron.
LAYER = 0.6073
FRAMES = 100
BIN = 0.05
LARGEST_WAVE_NUMBER = 30.0
# Contacts of a crystal are more staggered than this.
CRYSTAL = -0.25


class Profile:
    """Sums over frames, by height above the floor in bins of a width."""

    def __init__(self, structure: Structure, frames: range, width: float) -> None:
        height = structure.boxes[0][2]
        self.edges = np.arange(0, height + width, width)
        self.frames = len(frames)
        self.bodies, self.cubic, self.hexagonal, self.contacts, self.conformation = np.zeros((5, len(self.edges) - 1))
        for frame in frames:
            z = structure.positions[frame][:, 2] + 0.5 * height
            found = structure.diamond(frame)
            between = z[found.contacts].mean(axis=1)
            self.bodies += self.count(z)
            self.cubic += self.count(z, found.cubic.astype(float))
            self.hexagonal += self.count(z, found.hexagonal.astype(float))
            self.contacts += self.count(between)
            self.conformation += self.count(between, found.conformation)

    def count(self, heights: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
        return np.histogram(heights, self.edges, weights=weights)[0]

    def mean_of(self, sums: np.ndarray, counts: np.ndarray) -> np.ndarray:
        return np.divide(sums, counts, out=np.full(len(sums), np.nan), where=counts > self.frames / 2)


def main() -> None:
    structure = Structure.read(Path(sys.argv[1]))
    count = len(structure.positions)
    last = range(max(0, count - FRAMES), count)
    layers = Profile(structure, last, LAYER)
    print("| height | bodies | cubic | hexagonal | conformation |\n|---|---|---|---|---|")
    cubic, hexagonal = (layers.mean_of(part, layers.bodies) for part in (layers.cubic, layers.hexagonal))
    conformation = layers.mean_of(layers.conformation, layers.contacts)
    for number, low in enumerate(layers.edges[:-1]):
        print(
            f"| {low:.2f} to {low + LAYER:.2f} | {layers.bodies[number] / layers.frames:.1f} | {cubic[number]:.2f} |"
            f" {hexagonal[number]:.2f} | {conformation[number]:.2f} |"
        )
    crystalline = np.flatnonzero(conformation < CRYSTAL)
    top = layers.edges[crystalline.max() + 1] if len(crystalline) else 0.0
    print(f"contacts are staggered up to {top:.2f}")

    fine = Profile(structure, last, BIN)
    middles = 0.5 * (fine.edges[1:] + fine.edges[:-1])
    figure, axes = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
    axes[0].plot(middles, fine.bodies / fine.frames / BIN)
    axes[0].set(xlabel="height", ylabel="bodies per height")
    middles = 0.5 * (layers.edges[1:] + layers.edges[:-1])
    axes[1].plot(middles, cubic, marker="o", label="cubic diamond")
    axes[1].plot(middles, hexagonal, marker="o", label="hexagonal diamond")
    axes[1].plot(middles, conformation, marker="s", label="conformation of contacts")
    axes[1].set(xlabel="height", ylim=(-1, 1), ylabel="part of the bodies; mean of cos 3φ")
    axes[1].legend()
    below = structure.positions[-1][:, 2] + 0.5 * structure.boxes[0][2] < top
    crystal = Structure(
        structure.positions[-1:, below], structure.orientations[-1:, below], structure.boxes[-1:], structure.vertices
    )
    if below.any():
        k, pattern = crystal.diffraction(along=np.array([0.0, 0.0, 1.0]), k_max=LARGEST_WAVE_NUMBER, frame=0)
        axes[2].pcolormesh(k, k, np.log10(pattern + 1e-3).T, shading="nearest", vmin=-1)
    axes[2].set(title="diffraction of the crystal from above", xlabel="k_x", ylabel="k_y", aspect="equal")
    figure.savefig(sys.argv[2], dpi=80)


if __name__ == "__main__":
    main()
