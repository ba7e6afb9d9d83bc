"""The concentrations and the table of reweighting.sh.

    python reweighting.py concentrations    those of two bodies in the two larger boxes
    python reweighting.py table             prints the table from pair.json and curves.json

As in mass_action.py two bodies in a box of volume V are in contact with probability K / (V - 2 B2).
"""

import json
import sys
from pathlib import Path

from mass_action import EDGES_ANGSTROM

PER_MOLAR = 6.02214076e-4  # bodies per Å³


def concentration_molar(edge):
    return 2 / edge**3 / PER_MOLAR


def print_table():
    conditions = json.loads(Path("pair.json").read_text())["conditions"]
    curves = json.loads(Path("curves.json").read_text())["concentrations"]
    print("| box (Å) | salt (M) | bound, weighted | bound, mass action | standard errors apart | effective frames |")
    print("|---|---|---|---|---|---|")
    for edge, curve in zip(EDGES_ANGSTROM, curves, strict=True):
        assert abs(curve["concentration_M"] / concentration_molar(edge) - 1) < 1e-6
        for condition, point in zip(conditions, curve["points"], strict=True):
            volume = edge**3 - 2 * condition["b2_angstrom3"]
            expected = condition["association_volume_angstrom3"] / volume
            bound = point["bound_fraction"]
            apart = (bound["mean"] - expected) / bound["error"]
            print(
                f"| {edge} | {point['salt_M']} | {bound['mean']:.4f} ± {bound['error']:.4f} | {expected:.4f} | "
                f"{apart:+.1f} | {point['effective_frames']:.0f} |"
            )


if __name__ == "__main__":
    if sys.argv[1] == "concentrations":
        print(",".join(f"{1e6 * concentration_molar(edge):.9f}uM" for edge in EDGES_ANGSTROM[1:]))
    else:
        print_table()
