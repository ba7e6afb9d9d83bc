"""The inputs and the table of parts.sh.

    python parts.py bodies    writes a cube with two patches, and a ring of four
    python parts.py table     prints the tables from stability.json and the trajectories of the sweep

In a box of volume V with n_1 single bodies and n_2 pairs, K = <n_2> V / <n_1 (n_1 - 1)>, exactly for clusters that do not interact.
`stability` gives the same number as a free energy F: K = exp(-F) / N, with N bodies per Å³ at 1 mol/L.
"""

import json
import math
import sys
from pathlib import Path

CHARGE_E, EDGE_ANGSTROM, SPACING_ANGSTROM, BOX_ANGSTROM, BODIES = 1.55, 10.0, 10.4, 220.0, 64
PER_ANGSTROM3_AT_1_MOLAR = 6.02214076e-4
SALTS_MOLAR = (0.5, 0.56, 0.64, 0.76, 1.0)
LADDERS = (0, 1)
FACES = ((0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (2, 3, 7), (2, 7, 6), (1, 2, 6), (1, 6, 5), (0, 4, 7), (0, 7, 3))


def ring():
    """A body in each corner of a square, each turned by a quarter turn against the one before."""
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    for number, (x, y) in enumerate(corners):
        half = math.pi / 4 * number
        yield {
            "body": "patchy",
            "position_angstrom": [SPACING_ANGSTROM * x, SPACING_ANGSTROM * y, 0.0],
            "orientation_wxyz": [math.cos(half), 0.0, 0.0, math.sin(half)],
        }


def write_bodies():
    corners = [(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    half = EDGE_ANGSTROM / 2
    lines = ["OFF", "8 12 0"] + [f"{half * x} {half * y} {half * z}" for x, y, z in corners]
    lines += [f"3 {a} {b} {c}" for a, b, c in FACES]
    Path("cube.off").write_text("\n".join(lines) + "\n")
    patches = [f"4.2 {a} {b} {CHARGE_E}\n{a} 4.2 {b} {-CHARGE_E}" for a in (-3, 3) for b in (-3, 3)]
    Path("patchy.xyzq").write_text("\n".join(patches) + "\n")
    bodies = [{"name": "patchy", "file": "patchy.body"}]
    Path("ring.json").write_text(json.dumps({"bodies": bodies, "placements": list(ring())}))


def clusters(frame, limit_angstrom, numpy, rotation_class):
    """Numbers of single bodies and of pairs in a frame; pairs are within the limit of their place, as `stability` has them."""
    positions = numpy.asarray(frame.particles.position, float)
    quaternions = numpy.roll(numpy.asarray(frame.particles.orientation, float), -1, axis=1)
    turns = rotation_class.from_quat(quaternions)
    native = list(ring())
    native_shift = numpy.array(native[1]["position_angstrom"])
    native_turn = rotation_class.from_quat(numpy.roll(native[1]["orientation_wxyz"], -1))
    gyration2 = 0.6 * (0.75 / math.pi * EDGE_ANGSTROM**3) ** (2 / 3)
    count = len(positions)
    bonds = []
    for first in range(count):
        displacement = positions - positions[first]
        displacement -= BOX_ANGSTROM * numpy.round(displacement / BOX_ANGSTROM)
        for second in numpy.flatnonzero((displacement**2).sum(axis=1) < 20.0**2):
            if second == first:
                continue
            back = turns[first].inv()
            shift = back.apply(displacement[second]) - native_shift
            angle = (back * turns[second] * native_turn.inv()).magnitude()
            square = (shift**2).sum() + 4 / 3 * (1 - math.cos(angle)) * gyration2
            if square < limit_angstrom**2:
                bonds.append((first, int(second)))
    parent = list(range(count))

    def root(body):
        while parent[body] != body:
            body = parent[body]
        return body

    for first, second in bonds:
        parent[root(first)] = root(second)
    sizes = {}
    for body in range(count):
        sizes[root(body)] = sizes.get(root(body), 0) + 1
    return [sum(size == wanted for size in sizes.values()) for wanted in (1, 2)]


def print_table():
    import gsd.hoomd
    import numpy
    from scipy.spatial.transform import Rotation

    found = json.loads(Path("stability.json").read_text())
    number = next(n for n, part in enumerate(found["parts"]) if len(part["bodies"]) == 2 and part["symmetry_number"] == 1)
    volume = BOX_ANGSTROM**3
    print("| salt (M) | ln K, box of 64 bodies | ln K, stability | standard errors apart |")
    print("|---|---|---|---|")
    for salt, condition in zip(SALTS_MOLAR, found["conditions"]):
        row = condition["parts"][number]
        limit_angstrom = row["limit_angstrom"]
        blocks = []
        for ladder in LADDERS:
            path = Path(f"fluid/salt_{salt:.6f}M/replica_{ladder}/trajectory.gsd")
            with gsd.hoomd.open(path, "r") as trajectory:
                frames = range(len(trajectory) // 5, len(trajectory))
                counts = numpy.array([clusters(trajectory[frame], limit_angstrom, numpy, Rotation) for frame in frames], float)
            blocks += numpy.array_split(counts, 8)

        def ln_constant(chosen):
            free, pairs = numpy.concatenate(chosen).T
            return math.log(volume * pairs.mean() / (free * (free - 1)).mean())

        box = ln_constant(blocks)
        # Jackknife over the blocks: each left out in turn.
        left_out = [ln_constant(blocks[:n] + blocks[n + 1 :]) for n in range(len(blocks))]
        error = math.sqrt((len(blocks) - 1) * numpy.var(left_out))
        exact, exact_error = -row["free_energy_kt"] - math.log(PER_ANGSTROM3_AT_1_MOLAR), row["free_energy_error_kt"]
        apart = (box - exact) / math.hypot(error, exact_error)
        print(f"| {salt} | {box:.2f} ± {error:.2f} | {exact:.2f} ± {exact_error:.2f} | {apart:+.1f} |")


if __name__ == "__main__":
    {"bodies": write_bodies, "table": print_table}[sys.argv[1]]()
