"""Figure 4 of Grima et al. (2005): how far one mechanism alone is from the network, against its Young's modulus.

    python tests/validation/emuda_figure4.py PROTOMER [FIGURE]

Rows of table 3, hinging and stretching: Poisson's ratios and moduli of the networks ("EMUDA") compared with the closed formulas of one
mechanism ("AM"), as printed and as computed, against the modulus of the formula along the axis of the load.
"""

import json
import subprocess
import sys

import numpy as np


def number(text: str) -> float:
    return float(text.replace(" ", ""))


def points() -> list[dict]:
    """One point for each mechanism, angle and axis."""
    rows = json.loads(subprocess.run([sys.argv[1], "framework", "tables", "--json"], capture_output=True, text=True, check=True).stdout)
    by_key: dict = {}
    for row in rows:
        if row["table"] == 3:
            of_row = {value["quantity"]: value for value in row["values"]}
            by_key.setdefault((row["mechanism"], row["theta_deg"]), {})[row["method"]] = of_row
    found = []
    for (mechanism, theta), methods in by_key.items():
        formula, network = methods["am"], methods["emuda"]
        for axis, ratio in (("y", "nu_yz"), ("z", "nu_zy")):
            modulus = f"e_{axis}_gpa"
            point = {"mechanism": mechanism, "theta": theta, "axis": axis, "e": formula[modulus]["computed"]}
            for name, quantity in (("nu", ratio), ("e_off", modulus)):
                pairs = {"computed": (network[quantity]["computed"], formula[quantity]["computed"])}
                pairs["printed"] = (number(network[quantity]["printed"]), number(formula[quantity]["printed"]))
                point[name] = {key: 100.0 * abs(ours / theirs - 1.0) for key, (ours, theirs) in pairs.items()}
            found.append(point)
    return sorted(found, key=lambda point: point["e"])


def main() -> None:
    found = points()
    print("| mechanism | θ | load | E of the formula (GPa) | ν off, computed (%) | printed (%) | E off, computed (%) | printed (%) |")
    print("|---|---|---|---|---|---|---|---|")
    for point in found:
        words = [f"{point[name][key]:.2f}" for name in ("nu", "e_off") for key in ("computed", "printed")]
        print(f"| {point['mechanism']} | {point['theta']:g}° | {point['axis']} | {point['e']:.0f} | " + " | ".join(words) + " |")
    for mechanism in ("hinging", "stretching"):
        chosen = [point for point in found if point["mechanism"] == mechanism]
        logs = np.log([[point["e"], point["nu"]["computed"]] for point in chosen])
        print(f"{mechanism}: correlation of ln(ν off) with ln E {np.corrcoef(logs.T)[0, 1]:.3f}")
    below = [max(point["nu"]["computed"], point["e_off"]["computed"]) for point in found if point["e"] < 1e4]
    print(f"below 1e4 GPa at most {max(below):.2f} % off")
    if len(sys.argv) > 2:
        draw(found, sys.argv[2])


def draw(found: list[dict], path: str) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    for mechanism, colour in (("hinging", "#0072b2"), ("stretching", "#d55e00")):
        chosen = [point for point in found if point["mechanism"] == mechanism]
        e = [point["e"] for point in chosen]
        ax.loglog(e, [point["nu"]["computed"] for point in chosen], "o", color=colour, label=mechanism)
        ax.loglog(e, [point["nu"]["printed"] for point in chosen], "x", color=colour, label=f"{mechanism}, as printed")
    ax.axvline(1e4, color="grey", linewidth=0.8)
    ax.axhline(10.0, color="grey", linewidth=0.8)
    ax.set_xlabel("Young's modulus by the formula of one mechanism (GPa)")
    ax.set_ylabel("|difference| of Poisson's ratio (%)")
    ax.legend(fontsize="small")
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    main()
