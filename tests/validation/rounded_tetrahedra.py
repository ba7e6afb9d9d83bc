"""How rounding takes the wells at the hexagonal faces of truncated tetrahedra away, with the verbs of protomer.

    python tests/validation/rounded_tetrahedra.py PROTOMER OUTPUT SWEEPS

For each rounding: a fluid of 216 bodies at a packing fraction of 0.5, the potential of mean force in the frame of a body, and
its least values towards the four hexagons and the four triangles. Prints the table of
docs/validation/hard-shapes-campaign.md. Needs `pip install protomer[dynamics]`. Runs that have been done are not done again.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

from protomer.structure import MeanForce, Structure

SHAPE = "truncated-tetrahedron:0.6666666666666666"
# Of the solid that is cut from a tetrahedron with edges of 1.
CIRCUMRADIUS = 11**0.5 / (6 * 2**0.5)
ROUNDINGS = [0.0, 0.025, 0.05, 0.1]
REACH = 1.0
BINS = 61
# Sweeps before the measurement, and between frames of the trajectory.
EQUILIBRATION = 20000
EVERY = 60


def run(protomer: str, output: Path, rounding: float, sweeps: str) -> Path:
    directory = output / f"rounding_{rounding}"
    words = (
        *("hpmc", "run", "-q", "--shape", SHAPE, "--rounding", rounding * CIRCUMRADIUS),
        *("--bodies", 216, "--packing-fraction", 0.5, "--equilibration", EQUILIBRATION, "--sweeps", sweeps),
        *("--sample-every", 1000, "--trajectory-every", EVERY, "--threads", 1, "-o", directory),
    )
    subprocess.run([protomer, *map(str, words)], check=True)
    return directory


def directions_of_faces(structure: Structure) -> dict[str, np.ndarray]:
    """Directions of the hexagons and of the triangles. A corner and the two nearest to it are a triangle, opposite to a
    hexagon."""
    vertices = structure.vertices
    apart = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    triangles = [vertices[np.argsort(row)[:3]].mean(axis=0) for row in apart]
    triangles = np.unique(np.round([t / np.linalg.norm(t) for t in triangles], 3), axis=0)
    return {"hexagons": -triangles, "triangles": triangles}


def well(potential: MeanForce, directions: np.ndarray) -> str:
    found = np.array([potential.well(direction) for direction in directions])
    return f"{found[:, 1].mean():.2f} at {found[:, 0].mean():.2f}"


def main() -> None:
    protomer, output, sweeps = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
    print("| rounding / circumradius | frames | hexagons, kT at distance | triangles, kT at distance |\n|---|---|---|---|")
    for rounding in ROUNDINGS:
        structure = Structure.read(run(protomer, output, rounding, sweeps), skip=EQUILIBRATION // EVERY + 1)
        potential = structure.mean_force(REACH, BINS)
        faces = directions_of_faces(structure)
        wells = [well(potential, faces[name]) for name in ("hexagons", "triangles")]
        print(f"| {rounding} | {len(structure.positions)} | {wells[0]} | {wells[1]} |", flush=True)


if __name__ == "__main__":
    main()
