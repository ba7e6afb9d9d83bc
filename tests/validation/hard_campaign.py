"""Archimedean truncated tetrahedra from the shape to phase diagrams, with the verbs of protomer alone.

    python tests/validation/hard_campaign.py PROTOMER OUTPUT SWEEPS SWEEPS_OF_FREE_ENERGY

Cubic and hexagonal diamond: static and measured free volumes, free energies; the fluid: equation of state, chemical
potential; and with penetrable depletants of two sizes, free volume theory with measured free volumes: common tangents over
the fluid and both diamonds. Prints the tables of docs/validation/hard-shapes-campaign.md. Runs that have been done are not
done again.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

SHAPE = "truncated-tetrahedron:0.6666666666666666"
BODIES = 216
CRYSTALS = ["diamond", "hexagonal-diamond"]
SIZE_RATIOS = [0.1, 0.2]
FLUID = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5]
CRYSTAL = [0.5, 0.54, 0.58, 0.62, 0.66, 0.7, 0.74]
# Where the free energies of the crystals are computed.
ANCHOR = 0.62
RESERVOIRS = [0.0, 0.05, 0.1, 0.15, 0.2, 0.3]
# Steps between points of the tables of free energies.
STEP = 0.005


class Campaign:
    """The verbs, with a folder for their results."""

    def __init__(self, protomer: str, output: Path, sweeps: str, free_energy_sweeps: str) -> None:
        self.protomer, self.output = protomer, output
        self.sweeps, self.free_energy_sweeps = sweeps, free_energy_sweeps
        output.mkdir(parents=True, exist_ok=True)

    def ask(self, *words: object) -> dict:
        command = [self.protomer, *map(str, words), "--json"]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    def sweep(self, start: str, packings: list[float], radii: list[float], insertions: int) -> list[dict]:
        equations = []
        # The free volume of the first depletant is in the table: one sweep for each size.
        for radius in radii:
            equation = self.ask(
                *("hpmc", "sweep", "--shape", SHAPE, "--bodies", BODIES, "--start", start),
                *("--packing-fractions", ",".join(map(str, packings)), "--insertions", insertions),
                *("--depletants", f"{radius}:0", "--points", 40 * BODIES, "--sample-every", 20),
                *("--equilibration", 1500, "--sweeps", self.sweeps, "--trajectory-every", 0),
                *("-o", self.output / f"{start}_{radius:.4f}"),
            )
            equations.append(equation["points"])
        return equations

    def free_energy(self, crystal: str) -> dict:
        return self.ask(
            *("free-energy", "--shape", SHAPE, "--crystal", crystal, "--bodies", BODIES),
            *("--packing-fraction", ANCHOR, "--sweeps", self.free_energy_sweeps),
            *("-o", self.output / f"free_energy_{crystal}"),
        )


def interpolate(x: list[float], y: list[float], at: float) -> float:
    """Through the four nearest points (Lagrange)."""
    nearest = sorted(range(len(x)), key=lambda i: abs(x[i] - at))[:4]
    total = 0.0
    for i in nearest:
        term = y[i]
        for j in nearest:
            if j != i:
                term *= (at - x[j]) / (x[i] - x[j])
        total += term
    return total


def integral(function, low: float, high: float, parts: int = 200) -> float:
    """Simpson's rule."""
    step = (high - low) / parts
    total = function(low) + function(high)
    for number in range(1, parts):
        total += (4 if number % 2 else 2) * function(low + number * step)
    return total * step / 3


def table_of_phase(points: list[dict], free_energy: dict[float, float], volume: float, reservoir: float, radius: float):
    """Free energy per volume of a body, with what the depletants take: the density of A/V less the
    reservoir's times the free volume."""
    x = [point["packing_fraction"] for point in points]
    free = [math.log(point["free_volume_fraction"]) for point in points]
    excess = [free_energy[value] for value in x]
    depletant = 4 / 3 * math.pi * radius**3
    rows, value = [], x[0]
    while value <= x[-1] + 1e-9:
        alpha = math.exp(interpolate(x, free, value))
        ideal = math.log(value / volume) - 1
        energy = value * (ideal + interpolate(x, excess, value)) - reservoir * volume / depletant * alpha
        rows.append((value, energy))
        value += STEP
    return rows


def excess_of_crystal(points: list[dict], anchor: float) -> dict[float, float]:
    """Excess free energies from that at the anchor: the integral of (Z - 1)/φ."""
    x = [point["packing_fraction"] for point in points]
    y = [(point["compressibility_factor"] - 1) / point["packing_fraction"] for point in points]
    return {value: anchor + integral(lambda at: interpolate(x, y, at), ANCHOR, value) for value in x}


def with_error(value: float, error: float | None, digits: int = 4) -> str:
    return f"{value:.{digits}f} ± {error:.{digits}f}" if error is not None else f"{value:.{digits}f}"


def main() -> None:
    protomer, output, sweeps, free_energy_sweeps = sys.argv[1:]
    campaign = Campaign(protomer, Path(output), sweeps, free_energy_sweeps)
    shape = campaign.ask("shape", SHAPE)
    corners = 11**0.5 / (6 * 2**0.5)  # circumradius of the solid cut from a tetrahedron with edges of 1
    radii = [q * corners for q in SIZE_RATIOS]

    print("Static free volumes\n\n| φ | q | cubic | hexagonal | hexagonal - cubic |\n|---|---|---|---|---|")
    static = {}
    for crystal in CRYSTALS:
        listed = ",".join(str(q * corners) for q in (0.08, 0.12, 0.18, 0.22, 0.28))
        static[crystal] = campaign.ask(
            *("hpmc", "free-volume", "--shape", SHAPE, "--crystal", crystal, "--lines", 120),
            *("--packing-fraction", "0.52,0.58,0.62,0.75", "--depletant-radius", listed),
        )
    for cubic, hexagonal in zip(*static.values()):
        pair = [cubic["free_volume_fraction"], hexagonal["free_volume_fraction"]]
        errors = [cubic["free_volume_fraction_error"], hexagonal["free_volume_fraction_error"]]
        print(
            f"| {cubic['packing_fraction']} | {cubic['size_ratio']:.2f} | {with_error(pair[0], errors[0], 6)} |"
            f" {with_error(pair[1], errors[1], 6)} | {pair[1] - pair[0]:+.6f} |"
        )

    fluid = campaign.sweep("fluid", FLUID, radii, 400)
    crystals = {crystal: campaign.sweep(crystal, CRYSTAL, radii, 0) for crystal in CRYSTALS}

    print("\nMeasured free volumes\n\n| φ | q | cubic | hexagonal | hexagonal - cubic |\n|---|---|---|---|---|")
    for number, q in enumerate(SIZE_RATIOS):
        for cubic, hexagonal in zip(crystals["diamond"][number], crystals["hexagonal-diamond"][number]):
            values = [point["free_volume_fraction"] for point in (cubic, hexagonal)]
            errors = [point["free_volume_fraction_error"] for point in (cubic, hexagonal)]
            print(
                f"| {cubic['packing_fraction']} | {q} | {with_error(values[0], errors[0], 5)} |"
                f" {with_error(values[1], errors[1], 5)} | {with_error(values[1] - values[0], math.hypot(*errors), 5)} |"
            )

    print("\nThe fluid\n\n| φ | Z | free energy | f + Z - 1 | insertion |\n|---|---|---|---|---|")
    for point in fluid[0]:
        inserted = point.get("excess_chemical_potential_kt")
        potential = point["excess_free_energy_per_body_kt"] + point["compressibility_factor"] - 1
        print(
            f"| {point['packing_fraction']} |"
            f" {with_error(point['compressibility_factor'], point['compressibility_factor_error'])} |"
            f" {with_error(point['excess_free_energy_per_body_kt'], point['excess_free_energy_per_body_error_kt'])} |"
            f" {potential:.4f} |"
            f" {with_error(inserted, point.get('excess_chemical_potential_error_kt')) if inserted else '-'} |"
        )

    print(f"\nFree energies of crystals at {ANCHOR}\n\n| crystal | A/(N kT) | excess |\n|---|---|---|")
    anchors = {crystal: campaign.free_energy(crystal) for crystal in CRYSTALS}
    for crystal, found in anchors.items():
        print(
            f"| {crystal} | {with_error(found['free_energy_per_body_kt'], found['free_energy_per_body_error_kt'], 5)} |"
            f" {found['excess_free_energy_per_body_kt']:.5f} |"
        )
    values = [found["free_energy_per_body_kt"] for found in anchors.values()]
    errors = [found["free_energy_per_body_error_kt"] for found in anchors.values()]
    print(f"\nhexagonal - cubic: {with_error(values[1] - values[0], math.hypot(*errors), 5)} kT per body")

    print("\nCoexistence\n\n| q | reservoir | phases | packing fractions | βP v | μ |\n|---|---|---|---|---|---|")
    for number, (q, radius) in enumerate(zip(SIZE_RATIOS, radii)):
        for reservoir in RESERVOIRS:
            branches = []
            points = {"fluid": fluid[number], **{name: crystals[name][number] for name in CRYSTALS}}
            for name, found in points.items():
                if name == "fluid":
                    energies = {row["packing_fraction"]: row["excess_free_energy_per_body_kt"] for row in found}
                else:
                    energies = excess_of_crystal(found, anchors[name]["excess_free_energy_per_body_kt"])
                path = campaign.output / f"q{q}_r{reservoir}" / f"{name}.txt"
                path.parent.mkdir(exist_ok=True)
                rows = table_of_phase(found, energies, shape["volume"], reservoir, radius)
                path.write_text("".join(f"{x:.6f} {y:.12f}\n" for x, y in rows))
                branches += ["--branch", str(path)]
            found = campaign.ask("phase-diagram", *branches)["coexistences"]
            for tie in found:
                low, high = tie["packing_fractions"]
                print(
                    f"| {q} | {reservoir} | {', '.join(tie['phases'])} | {low:.4f}, {high:.4f} |"
                    f" {tie['pressure']:.4f} | {tie['chemical_potential']:.4f} |"
                )
            if not found:
                print(f"| {q} | {reservoir} | no coexistence in these branches | | | |")


if __name__ == "__main__":
    main()
