"""Which crystals space-filling polyhedra form when they are compressed: cubes, rhombic dodecahedra, truncated octahedra.

    python tests/validation/contact_assembly.py PROTOMER OUTPUT [SHAPE ...]

A thousand bodies of one shape repel each other by the smooth sum. They are compressed slowly from a dilute lattice, which melts, and held with a
global thermostat at a packing fraction of 0.55, which counts each body with its layer. The script prints how the bodies stand
to their neighbours compared with the same numbers of perfect crystals, and draws the radial distribution and the diffraction
pattern. The runs continue where they were stopped. Needs `pip install './python[plot,dynamics]'`.
"""

import subprocess
import sys
from pathlib import Path

import freud
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import protomer as pm

PROTOMER, OUTPUT = sys.argv[1], Path(sys.argv[2])
SHAPES = ("cube", "rhombic-dodecahedron", "truncated-octahedron")
BODIES, PACKING = 1000, 0.55
COMPRESS, EQUILIBRATE, STEPS, TIME_STEP = 400_000, 200_000, 400_000, 5e-4

# Cells of the perfect crystals: edges, and sites in units of the edges.
CELLS = {
    "sc": ([1.0, 1.0, 1.0], [[0, 0, 0]]),
    "bcc": ([1.0, 1.0, 1.0], [[0, 0, 0], [0.5, 0.5, 0.5]]),
    "fcc": ([1.0, 1.0, 1.0], [[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]]),
    "hcp": (
        [1.0, np.sqrt(3.0), np.sqrt(8.0 / 3.0)],
        [[0, 0, 0], [0.5, 0.5, 0], [0.5, 5 / 6, 0.5], [0, 1 / 3, 0.5]],
    ),
}


def run(shape: str) -> Path:
    """The directory of the run of this shape."""
    directory = OUTPUT / shape
    words = [PROTOMER, "md", "run", "-q", "--shape", shape, "--bodies", BODIES, "--packing-fraction", PACKING]
    words += ["--potential", "smooth", "--ensemble", "nvt", "--seed", 1, "--threads", 1, "-o", directory]
    words += ["--preparation-time-step", TIME_STEP, "--compress-steps", COMPRESS, "--equilibrate-steps", EQUILIBRATE]
    words += ["--time-step", TIME_STEP, "--steps", STEPS, "--log-every", 1000, "--trajectory-every", STEPS // 20]
    subprocess.run([str(word) for word in words], check=True)
    return directory


def crystal(name: str, copies: int = 5) -> tuple[freud.box.Box, np.ndarray]:
    """Box and sites of a perfect crystal."""
    edges, sites = (np.array(part, dtype=float) for part in CELLS[name])
    cells = np.stack(np.meshgrid(*[np.arange(copies)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    box = freud.box.Box(*(copies * edges))
    return box, box.wrap(((cells + sites) * edges).reshape(-1, 3))


def fingerprint(system: tuple[freud.box.Box, np.ndarray]) -> np.ndarray:
    """q4, q6 and w6 of each body, averaged over its neighbours, weighted by the faces of its Voronoi cell, (N, 3)."""
    cells = freud.locality.Voronoi()
    neighbours = cells.compute(system).nlist
    columns = []
    for degree, third in ((4, False), (6, False), (6, True)):
        order = freud.order.Steinhardt(l=degree, average=True, wl=third, wl_normalize=third, weighted=True)
        columns.append(order.compute(system, neighbors=neighbours).particle_order)
    return np.array(columns).T


def matched(found: np.ndarray, perfect: dict[str, np.ndarray]) -> dict[str, float]:
    """The part of the bodies whose direction in (q4, q6, w6) is nearest to that of each perfect crystal."""
    names = list(perfect)
    unit = np.array([perfect[name] / np.linalg.norm(perfect[name]) for name in names])
    nearest = (found / np.linalg.norm(found, axis=1, keepdims=True) @ unit.T).argmax(axis=1)
    return {name: float((nearest == k).mean()) for k, name in enumerate(names)}


def draw(shape: str, structure: pm.structure.Structure, file: Path) -> None:
    """The radial distribution and the diffraction pattern along the axis on which most neighbours stand."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    distance, g = structure.radial_distribution()
    left.plot(distance, g)
    left.set_xlabel("distance, edges of a body of volume one")
    left.set_ylabel("g(r)")
    k, pattern = structure.diffraction(along=axis_of(structure), k_max=20.0)
    right.pcolormesh(k, k, np.log10(pattern + 0.1).T, shading="nearest", cmap="magma")
    right.set_aspect("equal")
    right.set_xlabel("wave number")
    figure.suptitle(f"{BODIES} bodies at a packing fraction of {PACKING}: {shape}")
    figure.savefig(file, dpi=110)
    plt.close(figure)


def axis_of(structure: pm.structure.Structure) -> np.ndarray:
    """The direction along which most bodies have their nearest neighbour."""
    box, places = freud.box.Box.cube(structure.boxes[-1][0]), structure.positions[-1].astype(np.float32)
    query = freud.locality.AABBQuery(box, places).query(places, {"num_neighbors": 1, "exclude_ii": True})
    bonds = query.toNeighborList().vectors
    units = bonds / np.linalg.norm(bonds, axis=1, keepdims=True)
    close = np.abs(units @ units.T) > np.cos(np.radians(8.0))
    best = int(close.sum(axis=0).argmax())
    signs = np.sign(units[close[best]] @ units[best])
    axis = (signs[:, None] * units[close[best]]).mean(axis=0)
    return axis / np.linalg.norm(axis)


def main() -> None:
    OUTPUT.mkdir(parents=True, exist_ok=True)
    perfect = {name: fingerprint(crystal(name)).mean(axis=0) for name in CELLS}
    print("| crystal or shape | q4 | q6 | w6 | sc | bcc | fcc | hcp |\n|---|---|---|---|---|---|---|---|")
    for name, numbers in perfect.items():
        print(f"| {name}, perfect | " + " | ".join(f"{number:+.3f}" for number in numbers) + " | | | | |")
    for shape in sys.argv[3:] or SHAPES:
        structure = pm.structure.Structure.read(run(shape))
        for frame, when in ((0, "equilibrated"), (-1, "at the end")):
            box = freud.box.Box.cube(structure.boxes[frame][0])
            found = fingerprint((box, structure.positions[frame].astype(np.float32)))
            parts = matched(found, perfect)
            print(
                f"| {shape}, {when} | " + " | ".join(f"{number:+.3f}" for number in found.mean(axis=0)) + " | "
                + " | ".join(f"{parts[name]:.2f}" for name in CELLS) + " |", flush=True,
            )
        draw(shape, structure, OUTPUT / f"{shape}.png")


if __name__ == "__main__":
    main()
