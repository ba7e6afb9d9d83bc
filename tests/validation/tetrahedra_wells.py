"""Wells at the faces of truncated tetrahedra: rounding and dents make them shallower, depletants deeper.

    python tests/validation/tetrahedra_wells.py PROTOMER OUTPUT SWEEPS [rounding|dense-rounding|depletants|dents]

Fluids: for each rounding at packing fractions of 0.5 and 0.55, for each depth of dents in the hexagons at 0.5, and for each reservoir of
depletants of size ratio 0.1 at 0.3, the potential of mean force in the frame of a body, and its least values towards the four
hexagons and the four triangles, with the standard error from four parts of the run. Prints the tables of
docs/validation/hard-shapes-campaign.md. Needs `pip install protomer[dynamics]`. Runs that have been done are not done again.
"""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from protomer.structure import MeanForce, Structure

SHAPE = "truncated-tetrahedron:0.6666666666666666"
# Of the solid that is cut from a tetrahedron with edges of 1.
CIRCUMRADIUS = 11**0.5 / (6 * 2**0.5)
ROUNDINGS = [0.0, 0.025, 0.05, 0.1]
DENSE_ROUNDINGS = [0.0, 0.05, 0.1]
SIZE_RATIO = 0.1
RESERVOIRS = [0.0, 0.05, 0.1, 0.2]
DENTS = [0.0, 0.025, 0.05, 0.1]
REACH = 1.0
BINS = 61
PARTS = 4
# Sweeps before the measurement, and between frames of the trajectory.
EQUILIBRATION = 20000
EVERY = 60


def rounded(rounding: float, _: Path) -> list[object]:
    return ["--shape", SHAPE, "--bodies", 216, "--packing-fraction", 0.5, "--rounding", rounding * CIRCUMRADIUS]


def dense_and_rounded(rounding: float, output: Path) -> list[object]:
    """The same at 0.55, where the well of sharp bodies at the hexagons is as deep as the published one."""
    words = rounded(rounding, output)
    words[words.index("--packing-fraction") + 1] = 0.55
    # A few more: the box must hold the reach in all directions.
    words[words.index("--bodies") + 1] = 250
    return words


def among_depletants(reservoir: float, _: Path) -> list[object]:
    radius = SIZE_RATIO * CIRCUMRADIUS
    density = reservoir / (4 / 3 * math.pi * radius**3)
    depletants = ["--depletants", f"{radius}:{density}"] if reservoir else []
    return ["--shape", SHAPE, "--bodies", 216, "--packing-fraction", 0.3, *depletants]


def dented(depth: float, output: Path) -> list[object]:
    """The middle of each hexagon is pressed in by a depth, in circumradii, so that the body is concave."""
    output.mkdir(parents=True, exist_ok=True)
    files = []
    for number, corners in enumerate(pieces_of_dented(depth * CIRCUMRADIUS)):
        file = output / f"dents_{depth}_piece_{number}.txt"
        np.savetxt(file, corners, fmt="%.16g")
        files.append(str(file))
    # A few more, since they are smaller: the box must hold the reach in all directions.
    return ["--shape", "+".join(files) if depth else SHAPE, "--bodies", 250, "--packing-fraction", 0.5]


def pieces_of_dented(depth: float) -> list[np.ndarray]:
    """Eleven convex pieces: the tetrahedron between the four dents, what lies between its faces and the triangles, and what
    lies between its edges and those of two hexagons."""
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 8**0.5
    # The middle of a hexagon is opposite to a corner of the tetrahedron.
    dents = np.array([-corner / np.linalg.norm(corner) * (1 / 24**0.5 - depth) for corner in corners])
    cut = {(i, j): (2 * corners[i] + corners[j]) / 3 for i in range(4) for j in range(4) if i != j}
    pieces = [dents]
    for i in range(4):
        others = [j for j in range(4) if j != i]
        pieces.append(np.array([cut[i, j] for j in others] + [dents[j] for j in others]))
        pieces += [np.array([cut[i, j], cut[j, i], *np.delete(dents, [i, j], axis=0)]) for j in range(i)]
    return pieces


LADDERS = {
    "rounding": ("rounding / circumradius", ROUNDINGS, rounded),
    "dense-rounding": ("rounding / circumradius", DENSE_ROUNDINGS, dense_and_rounded),
    "depletants": ("reservoir", RESERVOIRS, among_depletants),
    "dents": ("depth of the dents / circumradius", DENTS, dented),
}


def run(protomer: str, directory: Path, condition: list[object], sweeps: str) -> Path:
    words = (
        *("hpmc", "run", "-q", *condition),
        *("--equilibration", EQUILIBRATION, "--sweeps", sweeps, "--sample-every", 1000),
        *("--trajectory-every", EVERY, "--threads", 1, "-o", directory),
    )
    subprocess.run([protomer, *map(str, words)], check=True)
    return directory


def directions_of_faces(structure: Structure) -> dict[str, np.ndarray]:
    """Directions of the hexagons and of the triangles. A corner and the two nearest to it are a triangle, opposite to a
    hexagon."""
    vertices = structure.vertices[ConvexHull(structure.vertices).vertices]
    apart = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    triangles = [vertices[np.argsort(row)[:3]].mean(axis=0) for row in apart]
    triangles = np.unique(np.round([t / np.linalg.norm(t) for t in triangles], 3), axis=0)
    return {"hexagons": -triangles, "triangles": triangles}


def parts_of(structure: Structure) -> list[Structure]:
    frames = np.array_split(np.arange(len(structure.positions)), PARTS)
    return [
        Structure(structure.positions[part], structure.orientations[part], structure.boxes[part], structure.vertices)
        for part in frames
    ]


def well(whole: MeanForce, parts: list[MeanForce], directions: np.ndarray) -> str:
    """The least value of the whole run, where it is, and its standard error from there in the parts."""
    found = np.array([whole.well(direction) for direction in directions]).mean(axis=0)
    depths = [np.mean([part.well(direction)[1] for direction in directions]) for part in parts]
    return f"{found[1]:.2f} ± {np.std(depths, ddof=1) / PARTS**0.5:.2f} at {found[0]:.2f}"


def main() -> None:
    protomer, output, sweeps = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
    for name in sys.argv[4:] or LADDERS:
        heading, steps, condition = LADDERS[name]
        print(f"\n| {heading} | frames | hexagons, kT at distance | triangles, kT at distance |\n|---|---|---|---|")
        for step in steps:
            directory = run(protomer, output / f"{name}_{step}", condition(step, output), sweeps)
            structure = Structure.read(directory, skip=EQUILIBRATION // EVERY + 1)
            whole, *parts = (each.mean_force(REACH, BINS) for each in [structure, *parts_of(structure)])
            faces = directions_of_faces(structure)
            wells = [well(whole, parts, faces[kind]) for kind in ("hexagons", "triangles")]
            print(f"| {step} | {len(structure.positions)} | {wells[0]} | {wells[1]} |", flush=True)


if __name__ == "__main__":
    main()
