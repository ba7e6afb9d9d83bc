"""The inputs and the table of mass_action.sh.

    python mass_action.py bodies    writes two charged cubes and three boxes into the current folder
    python mass_action.py table     prints the table from pair.json and the sweeps

Two bodies in a box of volume V are in contact with probability K / (V - 2 B2), where K = ∫ exp(-U) over
the poses in contact (`association_volume_angstrom3`) and B2 is the second virial coefficient: V - 2 B2
is the integral of exp(-U) over all poses.
"""

import json
import sys
from pathlib import Path

EDGES_ANGSTROM = (120, 160, 240)
CUBE = """OFF
8 12 0
-5 -5 -5
5 -5 -5
5 5 -5
-5 5 -5
-5 -5 5
5 -5 5
5 5 5
-5 5 5
3 0 2 1
3 0 3 2
3 4 5 6
3 4 6 7
3 0 1 5
3 0 5 4
3 2 3 7
3 2 7 6
3 1 2 6
3 1 6 5
3 0 4 7
3 0 7 3
"""


def write_bodies():
    Path("cube.off").write_text(CUBE)
    Path("a.xyzq").write_text("0 0 0 4\n3 0 0 1\n")
    Path("b.xyzq").write_text("0 0 0 -4\n0 3 0 -0.5\n")
    for edge in EDGES_ANGSTROM:
        placements = [
            {"body": name, "position_angstrom": [x, 0, 0], "orientation_wxyz": [1, 0, 0, 0]}
            for name, x in (("a", 0), ("b", 12))
        ]
        bodies = [{"name": name, "file": f"{name}.body"} for name in "ab"]
        assembly = {"box_angstrom": [edge] * 3, "bodies": bodies, "placements": placements}
        Path(f"two{edge}.json").write_text(json.dumps(assembly))


def print_table():
    conditions = json.loads(Path("pair.json").read_text())["conditions"]
    print("| box (Å) | salt (M) | bound, replica exchange | bound, mass action | standard errors apart |")
    print("|---|---|---|---|---|")
    for edge in EDGES_ANGSTROM:
        sweep = json.loads(Path(f"sweep{edge}.json").read_text())
        for condition, row, replicas in zip(conditions, sweep["salts"], sweep["replicas"]):
            all_poses = edge**3 - 2 * condition["b2_angstrom3"]
            expected = condition["association_volume_angstrom3"] / all_poses
            spread = row["bound_fraction_sd"] / len(replicas) ** 0.5
            own = sum(r["bound_fraction"]["standard_error"] ** 2 for r in replicas) ** 0.5 / len(replicas)
            found, error = row["bound_fraction_mean"], max(spread, own)
            apart = (found - expected) / error
            print(
                f"| {edge} | {row['salt_M']} | {found:.4f} ± {error:.4f} | {expected:.4f} | {apart:+.1f} |"
            )


if __name__ == "__main__":
    {"bodies": write_bodies, "table": print_table}[sys.argv[1]]()
