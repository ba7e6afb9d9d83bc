"""The densest packing of truncated tetrahedra by pairs, as a cell for `hpmc` and `free-energy`.

    python tests/validation/densest_tetrahedra.py CELL [STARTS]

Two bodies in a cell that is free to change, the second the inverse of the first, as in the structure of alpha-arsenic. Two
convex bodies do not overlap when a facet of their Minkowski difference lies between the origin and the place of the second
seen from the first; for chosen facets that is linear in the cell and in the place, so the volume of the cell falls by a
sequence of linear programs from random starts (after S. Torquato and Y. Jiao, Phys. Rev. E 82, 061302 (2010)). Writes the
densest cell found to CELL and prints its packing fraction next to the one known, 207/208 (P. F. Damasceno, M. Engel and
S. C. Glotzer, ACS Nano 6, 609 (2012); Y. Jiao and S. Torquato, J. Chem. Phys. 135, 151101 (2011)). Needs NumPy and SciPy.
"""

import itertools
import math
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

KNOWN = 207 / 208
SEED = 1
# Cells around a body that are looked at, and the largest change of a coordinate at first and at the end, in edges of the
# tetrahedron.
CELLS = np.array(list(itertools.product(range(-2, 3), repeat=3)))
FIRST_STEP, LAST_STEP = 0.1, 1e-10


def truncated_tetrahedron() -> np.ndarray:
    """Its vertices: a third of the way along each edge of a tetrahedron with edges of 1."""
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 8**0.5
    return np.array([(2 * a + b) / 3 for a, b in itertools.permutations(corners, 2)])


def facets(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outward normals and heights of the facets of the hull."""
    planes = np.unique(np.round(ConvexHull(points).equations, 12), axis=0)
    return planes[:, :3], -planes[:, 3]


class Packing:
    """A cell with bodies at its origin and, inverted, at `place`: rows of `cell` are its edges."""

    def __init__(self, body: np.ndarray) -> None:
        self.like = facets((body[:, None] - body[None]).reshape(-1, 3))
        self.unlike = facets((body[:, None] + body[None]).reshape(-1, 3))

    def gaps(self, cell: np.ndarray, place: np.ndarray) -> list[tuple[np.ndarray, float, np.ndarray, float]]:
        """For each pair: cells between the two and whether the place counts; the facet that is farthest outside, and how
        far outside of it the second body is."""
        found = []
        for shift, of_place, (normals, heights) in [
            *((n, 0.0, self.like) for n in CELLS if tuple(n) > (0, 0, 0)),
            *((n, 1.0, self.unlike) for n in CELLS),
        ]:
            outside = normals @ (shift @ cell + of_place * place) - heights
            best = int(np.argmax(outside))
            found.append((shift, of_place, normals[best], float(outside[best])))
        return found

    def compress(self, cell: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """To a local minimum of the volume."""
        step = FIRST_STEP
        while step > LAST_STEP:
            cell = reduced(cell)
            place = place - np.round(np.linalg.solve(cell.T, place)) @ cell
            rows, room = [], []
            for shift, of_place, normal, outside in self.gaps(cell, place):
                # -normal·(shift·δcell + δplace) ≤ outside
                rows.append(-np.concatenate([np.outer(shift, normal).ravel(), of_place * normal]))
                room.append(outside / step)
            cofactors = np.linalg.det(cell) * np.linalg.inv(cell).T
            downhill = np.concatenate([cofactors.ravel(), np.zeros(3)])
            # In units of the step, since the tolerances of the solver are absolute.
            solved = linprog(downhill, A_ub=np.array(rows), b_ub=np.array(room), bounds=(-1, 1))
            if solved.status != 0:
                step *= 0.5
                continue
            changed = cell + step * solved.x[:9].reshape(3, 3), place + step * solved.x[9:]
            gain = np.linalg.det(cell) - np.linalg.det(changed[0])
            if gain > 0:
                cell, place = changed
            if gain < 0.01 * step * abs(downhill).sum():
                step *= 0.5
        return cell, place


def reduced(cell: np.ndarray) -> np.ndarray:
    """Edges as short as sums of two of them can be, so that near bodies are in near cells."""
    cell = cell.copy()
    improved = True
    while improved:
        improved = False
        for i, j in itertools.permutations(range(3), 2):
            turns = round(cell[i] @ cell[j] / (cell[j] @ cell[j]))
            if turns and np.linalg.norm(cell[i] - turns * cell[j]) < np.linalg.norm(cell[i]) - 1e-9:
                cell[i] -= turns * cell[j]
                improved = True
    return cell if np.linalg.det(cell) > 0 else -cell


def densest(body: np.ndarray, starts: int) -> tuple[np.ndarray, np.ndarray, list[float]]:
    """The cell and the place of the densest packing, and the packing fractions from all starts."""
    packing, volume, random = Packing(body), ConvexHull(body).volume, np.random.default_rng(SEED)
    best, fractions = None, []
    for _ in range(starts):
        cell, place = reduced(np.eye(3) + random.uniform(-0.3, 0.3, (3, 3))), random.uniform(0, 1, 3)
        place = place @ cell
        # Apart at first: facets must separate every pair.
        while min(outside for *_, outside in packing.gaps(cell, place)) < 0:
            cell, place = 1.1 * cell, 1.1 * place
        cell, place = packing.compress(cell, place)
        fractions.append(2 * volume / np.linalg.det(cell))
        if fractions[-1] >= max(fractions):
            best = cell, place
    assert best is not None
    return *best, fractions


def write_cell(path: Path, cell: np.ndarray, place: np.ndarray) -> None:
    """As `hpmc run --start` reads it: the first edge along x, the second in the plane of x and y, so the bodies turn with
    the cell. Where they can be, all angles are acute."""
    cosines = [cell[1] @ cell[2], cell[0] @ cell[2], cell[0] @ cell[1]]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        if cosines[i] > 0 > max(cosines[j], cosines[k]):
            cell = cell * np.where(np.arange(3) == i, 1.0, -1.0)[:, None]
    lengths = np.linalg.norm(cell, axis=1)
    angles = [math.degrees(math.acos(cell[i] @ cell[j] / (lengths[i] * lengths[j]))) for i, j in [(1, 2), (0, 2), (0, 1)]]
    x = cell[0] / lengths[0]
    z = np.cross(cell[0], cell[1])
    z /= np.linalg.norm(z)
    turn = Rotation.from_matrix([x, np.cross(z, x), z])
    # A quarter of a turn about the axis between two edges of the tetrahedron inverts it.
    inverted = turn * Rotation.from_euler("z", 90, degrees=True)
    lines = [("cell", *lengths, *angles)]
    for at, rotation in [(np.zeros(3), turn), (np.linalg.solve(cell.T, place) % 1, inverted)]:
        qx, qy, qz, qw = rotation.as_quat()
        lines.append(("site", *at, qw, qx, qy, qz))
    path.write_text("".join(" ".join([line[0], *(f"{value:.12f}" for value in line[1:])]) + "\n" for line in lines))


def main() -> None:
    path, starts = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 12
    cell, place, fractions = densest(truncated_tetrahedron(), starts)
    fractions = sorted(fractions, reverse=True)
    print("packing fractions:", *(f"{fraction:.6f}" for fraction in fractions))
    print(f"densest {fractions[0]:.9f}, known {KNOWN:.9f}")
    write_cell(path, cell, place)


if __name__ == "__main__":
    main()
