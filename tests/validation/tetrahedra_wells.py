"""Wells at the faces of truncated tetrahedra: rounding and dents make them shallower, depletants deeper.

    python tests/validation/tetrahedra_wells.py PROTOMER OUTPUT SWEEPS [rounding|dense-rounding|depletants|dents|published]

Fluids: for each rounding at packing fractions of 0.5 and 0.55, for each depth of dents in the hexagons at 0.5, for the published truncations and curvatures and for flat bodies with these truncations at 0.5, and for each reservoir of
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
# Truncation, and curvature of the hexagons per nm, positive where they are pressed in; and without the curvature.
PUBLISHED = ["0.68 concave", "0.68 flat", "0.52 convex", "0.52 flat"]
CURVATURES = {"concave": 3.2e-4, "flat": 0.0, "convex": -8.1e-4}
# Edge of the tetrahedron before its corners are cut off, nm: of the volume of droplets of 1000 nm, half of the satellites of 2000 nm.
EDGE = 1700.0
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
    pieces = pieces_of_dented(depth * CIRCUMRADIUS) if depth else []
    shape = saved(pieces, output / f"dents_{depth}") if depth else SHAPE
    # A few more, since they are smaller: the box must hold the reach in all directions.
    return ["--shape", shape, "--bodies", 250, "--packing-fraction", 0.5]


def published(kind: str, output: Path) -> list[object]:
    """The published truncations and curvatures: the middle of a hexagon is where a sphere through its corners has it."""
    truncation, curvature = float(kind.split()[0]), CURVATURES[kind.split()[1]] * EDGE
    corner = np.linalg.norm(cut_corners(truncation)[0, 1] - middles()[3])
    depth = corner**2 * curvature / 2
    if depth > 0:
        pieces = pieces_of_dented(depth, truncation)
    else:
        pulled = middles() * (1 - depth / np.linalg.norm(middles()[0]))
        pieces = [np.array([*cut_corners(truncation).values(), *pulled])]
    output.mkdir(parents=True, exist_ok=True)
    return ["--shape", saved(pieces, output / kind.replace(" ", "_")), "--bodies", 250, "--packing-fraction", 0.5]


def saved(pieces: list[np.ndarray], name: Path) -> str:
    """Convex pieces as files, and their names as one shape."""
    files = []
    for number, corners in enumerate(pieces):
        file = name.with_name(f"{name.name}_piece_{number}.txt")
        np.savetxt(file, corners, fmt="%.16g")
        files.append(str(file))
    return "+".join(files)


def tetrahedron() -> np.ndarray:
    return np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 8**0.5


def middles() -> np.ndarray:
    """The middle of each hexagon, opposite to a corner of the tetrahedron."""
    return np.array([-corner / np.linalg.norm(corner) / 24**0.5 for corner in tetrahedron()])


def cut_corners(truncation: float) -> dict[tuple[int, int], np.ndarray]:
    """Corners of the triangles, whose edges are half of the truncation."""
    corners, part = tetrahedron(), truncation / 2
    return {(i, j): (1 - part) * corners[i] + part * corners[j] for i in range(4) for j in range(4) if i != j}


def pieces_of_dented(depth: float, truncation: float = 2 / 3) -> list[np.ndarray]:
    """Eleven convex pieces: the tetrahedron between the four dents, what lies between its faces and the triangles, and what
    lies between its edges and those of two hexagons."""
    dents = middles() * (1 - depth / np.linalg.norm(middles()[0]))
    cut = cut_corners(truncation)
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
    "published": ("truncation and hexagons", PUBLISHED, published),
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


def directions_of_pieces() -> dict[str, np.ndarray]:
    """Directions of the hexagons and of the triangles of the bodies made of pieces."""
    return {"hexagons": middles() * 24**0.5, "triangles": tetrahedron() / np.linalg.norm(tetrahedron()[0])}


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
            directory = run(protomer, output / f"{name}_{step}".replace(" ", "_"), condition(step, output), sweeps)
            structure = Structure.read(directory, skip=EQUILIBRATION // EVERY + 1)
            whole, *parts = (each.mean_force(REACH, BINS) for each in [structure, *parts_of(structure)])
            # Middles that are pulled out are corners, too, so the faces of these are not found by their corners.
            faces = directions_of_pieces() if name == "published" else directions_of_faces(structure)
            wells = [well(whole, parts, faces[kind]) for kind in ("hexagons", "triangles")]
            print(f"| {step} | {len(structure.positions)} | {wells[0]} | {wells[1]} |", flush=True)


if __name__ == "__main__":
    main()
