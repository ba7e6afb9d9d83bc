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
SIZE_RATIOS = [0.1, 0.2, 0.3]
FLUID = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5]
CRYSTAL = [0.5, 0.54, 0.58, 0.62, 0.66, 0.7, 0.74]
# Where the free energies of the crystals are computed.
ANCHOR = 0.62
RESERVOIRS = [0.0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.05, 0.1, 0.15, 0.2, 0.3]


class Campaign:
    """The verbs, with a folder for their results."""

    def __init__(self, protomer: str, output: Path, sweeps: str, free_energy_sweeps: str) -> None:
        self.protomer, self.output = protomer, output
        self.sweeps, self.free_energy_sweeps = sweeps, free_energy_sweeps
        output.mkdir(parents=True, exist_ok=True)

    def ask(self, *words: object) -> dict:
        command = [self.protomer, *map(str, words), "--json"]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    def directory(self, phase: str, q: float) -> Path:
        return self.output / f"q{q}" / phase

    def sweep(self, start: str, packings: list[float], radii: list[float], insertions: int) -> list[dict]:
        equations = []
        # The free volume of the first depletant is in the table: one sweep for each size.
        for q, radius in zip(SIZE_RATIOS, radii):
            equation = self.ask(
                *("hpmc", "sweep", "--shape", SHAPE, "--bodies", BODIES, "--start", start),
                *("--packing-fractions", ",".join(map(str, packings)), "--insertions", insertions),
                *("--depletants", f"{radius}:0", "--points", 40 * BODIES, "--sample-every", 20),
                *("--equilibration", 1500, "--sweeps", self.sweeps, "--trajectory-every", 0),
                *("-o", self.directory(start, q)),
            )
            equations.append(equation["points"])
        return equations

    def free_energy(self, crystal: str) -> dict:
        return self.ask(
            *("free-energy", "--shape", SHAPE, "--crystal", crystal, "--bodies", BODIES),
            *("--packing-fraction", ANCHOR, "--sweeps", self.free_energy_sweeps),
            *("-o", self.output / f"free_energy_{crystal}"),
        )

    def coexistences(self, q: float) -> list[dict]:
        crystals: list[object] = []
        for crystal in CRYSTALS:
            crystals += ["--crystal", self.directory(crystal, q)]
            crystals += ["--free-energy", self.output / f"free_energy_{crystal}"]
        found = self.ask(
            *("phase-diagram", "--fluid", self.directory("fluid", q), *crystals),
            *("--reservoir", ",".join(map(str, RESERVOIRS)), "-o", self.output / f"q{q}.svg", "--force"),
        )
        return found["coexistences"]


def reservoirs_of_equal_crystals(
    volumes_in_reservoir: float, cubic: list[dict], hexagonal: list[dict], difference: tuple[float, float]
) -> list[tuple[float, float, float]]:
    """At each packing fraction, the reservoir from which on hexagonal diamond is lower, with its error: where what its
    larger free volume gains, per body, is the difference of the free energies without depletants. That is taken at the
    anchor and carried on by the measured compressibility factors (trapezia). `volumes_in_reservoir` is the volume of a
    body over that of a depletant."""
    x = [point["packing_fraction"] for point in cubic]
    slope = [
        (b["compressibility_factor"] - a["compressibility_factor"]) / at for at, a, b in zip(x, cubic, hexagonal)
    ]
    steps = [0.5 * (slope[i] + slope[i + 1]) * (x[i + 1] - x[i]) for i in range(len(x) - 1)]
    anchor = x.index(ANCHOR)
    found = []
    for i, (a, b) in enumerate(zip(cubic, hexagonal)):
        gain = b["free_volume_fraction"] - a["free_volume_fraction"]
        gain_error = math.hypot(a["free_volume_fraction_error"], b["free_volume_fraction_error"])
        cost = difference[0] + (sum(steps[anchor:i]) if i >= anchor else -sum(steps[i:anchor]))
        reservoir = cost * x[i] / volumes_in_reservoir / gain if gain > 2 * gain_error else math.inf
        error = reservoir * math.hypot(gain_error / gain, difference[1] / cost)
        found.append((x[i], reservoir, error))
    return found


def with_error(value: float, error: float | None, digits: int = 4) -> str:
    return f"{value:.{digits}f} ± {error:.{digits}f}" if error is not None else f"{value:.{digits}f}"


def main() -> None:
    protomer, output, sweeps, free_energy_sweeps = sys.argv[1:]
    campaign = Campaign(protomer, Path(output), sweeps, free_energy_sweeps)
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
            f" {with_error(point['excess_free_energy_per_body_kt'], point['excess_free_energy_per_body_kt_error'])} |"
            f" {potential:.4f} |"
            f" {with_error(inserted, point.get('excess_chemical_potential_kt_error')) if inserted else '-'} |"
        )

    print(f"\nFree energies of crystals at {ANCHOR}\n\n| crystal | A/(N kT) | excess |\n|---|---|---|")
    anchors = {crystal: campaign.free_energy(crystal) for crystal in CRYSTALS}
    for crystal, found in anchors.items():
        print(
            f"| {crystal} | {with_error(found['free_energy_per_body_kt'], found['free_energy_per_body_kt_error'], 5)} |"
            f" {found['excess_free_energy_per_body_kt']:.5f} |"
        )
    values = [found["free_energy_per_body_kt"] for found in anchors.values()]
    errors = [found["free_energy_per_body_kt_error"] for found in anchors.values()]
    print(f"\nhexagonal - cubic: {with_error(values[1] - values[0], math.hypot(*errors), 5)} kT per body")

    print("\nHexagonal diamond is lower\n\n| φ | q | from a reservoir of |\n|---|---|---|")
    volume = campaign.ask("shape", SHAPE)["volume"]
    difference = (values[1] - values[0], math.hypot(*errors))
    for number, (q, radius) in enumerate(zip(SIZE_RATIOS, radii)):
        volumes = volume / (4 / 3 * math.pi * radius**3)
        measured = [crystals[crystal][number] for crystal in CRYSTALS]
        for x, reservoir, error in reservoirs_of_equal_crystals(volumes, *measured, difference):
            text = with_error(reservoir, error, 2) if math.isfinite(reservoir) else "none is seen"
            print(f"| {x} | {q} | {text} |")

    heading = "| q | reservoir | phases | packing fractions | βP v | βμ | share of draws |"
    print(f"\nCoexistence\n\n{heading}\n|---|---|---|---|---|---|---|")
    for q in SIZE_RATIOS:
        for tie in campaign.coexistences(q):
            low, high = map(with_error, tie["packing_fractions"], tie["packing_fractions_error"])
            print(
                f"| {q} | {tie['reservoir_packing_fraction']} | {', '.join(tie['phases'])} | {low}, {high} |"
                f" {with_error(tie['pressure'], tie['pressure_error'])} |"
                f" {with_error(tie['chemical_potential'], tie['chemical_potential_error'])} |"
                f" {tie['share_of_draws']:.2f} |"
            )


if __name__ == "__main__":
    main()
