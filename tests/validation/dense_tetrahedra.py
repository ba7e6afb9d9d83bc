"""Dense truncated tetrahedra: where alpha-arsenic, which packs densest, is more stable than the diamonds.

    python tests/validation/densest_tetrahedra.py arsenic.cell
    python tests/validation/dense_tetrahedra.py PROTOMER OUTPUT arsenic.cell

Free energies of the crystals at five densities, equations of state of the fluid and of the crystals with the free volumes of
depletants of two sizes, and the common tangents over all of them. Prints tables of
docs/validation/hard-shapes-campaign.md. Runs that have been done are not done again.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

SHAPE = "truncated-tetrahedron:0.6666666666666666"
SIZE_RATIOS = [0.1, 0.2]
DENSITIES = [0.7, 0.75, 0.8, 0.85, 0.9]
# Where the free energies are computed from which those of the phases are integrated.
ANCHOR = 0.8
FLUID = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5]
DIAMOND = [0.5, 0.54, 0.58, 0.62, 0.66, 0.7, 0.74, 0.78, 0.82, 0.86, 0.9]
ARSENIC = [0.7, 0.74, 0.78, 0.82, 0.86, 0.9]
RESERVOIRS = {
    0.1: [0, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.09, 0.1],
    0.2: [0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5],
}
# Alpha-arsenic leaves no room for the larger depletants that any point finds, and such free volumes are refused.
CRYSTALS = {0.1: ["diamond", "hexagonal-diamond", "arsenic"], 0.2: ["diamond", "hexagonal-diamond"]}
# Whole cells, and boxes near to a cube.
BODIES = {"fluid": 216, "diamond": 216, "hexagonal-diamond": 216, "arsenic": 250}


class Campaign:
    """The verbs, with a folder for their results."""

    def __init__(self, protomer: str, output: Path, cell: str) -> None:
        self.protomer, self.output, self.cell = protomer, output, cell
        output.mkdir(parents=True, exist_ok=True)

    def ask(self, *words: object) -> dict:
        command = [self.protomer, *map(str, words), "-q", "-j", "1", "--json"]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    def named(self, phase: str) -> str:
        return self.cell if phase == "arsenic" else phase

    def free_energy(self, phase: str, packing: float, bodies: int) -> dict:
        return self.ask(
            *("free-energy", "--shape", SHAPE, "--crystal", self.named(phase), "--bodies", bodies),
            *("--packing-fraction", packing, "--sweeps", 10000, "-o", self.anchor(phase, packing, bodies)),
        )

    def anchor(self, phase: str, packing: float, bodies: int) -> Path:
        return self.output / f"free_energy_{phase}_{packing}_{bodies}"

    def equation(self, phase: str, q: float) -> Path:
        directory = self.output / f"q{q}" / phase
        packings = {"fluid": FLUID, "arsenic": ARSENIC}.get(phase, DIAMOND)
        start = [] if phase == "fluid" else ["--start", self.named(phase)]
        self.ask(
            *("hpmc", "sweep", "--shape", SHAPE, "--bodies", BODIES[phase], *start),
            *("--packing-fractions", ",".join(map(str, packings)), "--depletants", f"{depletant_radius(q)}:0"),
            *("--points", 40 * BODIES[phase], "--sample-every", 20, "--equilibration", 1500, "--sweeps", 6000),
            *("--trajectory-every", 0, "-o", directory),
        )
        return directory

    def coexistences(self, q: float) -> list[dict]:
        crystals: list[object] = []
        for phase in CRYSTALS[q]:
            crystals += ["--crystal", self.equation(phase, q)]
            crystals += ["--free-energy", self.anchor(phase, ANCHOR, BODIES[phase])]
        return self.ask(
            *("phase-diagram", "--fluid", self.equation("fluid", q), *crystals),
            *("--reservoir", ",".join(map(str, RESERVOIRS[q])), "-o", self.output / f"phases_{q}.svg", "--force"),
        )["coexistences"]


def depletant_radius(q: float) -> float:
    """In circumradii of the solid that is cut from a tetrahedron with edges of 1: √11 / (6 √2)."""
    return q * 11**0.5 / (6 * 2**0.5)


def with_error(value: float, error: float, digits: int = 3) -> str:
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def main() -> None:
    protomer, output, cell = sys.argv[1:]
    campaign = Campaign(protomer, Path(output), cell)
    print("| φ | cubic | hexagonal - cubic | arsenic - cubic |\n|---|---|---|---|")
    for packing in DENSITIES:
        cubic, *others = (
            campaign.free_energy(phase, packing, 216) for phase in ("diamond", "hexagonal-diamond", "arsenic")
        )
        value, error = cubic["free_energy_per_body_kt"], cubic["free_energy_per_body_kt_error"]
        row = [with_error(value, error)]
        for other in others:
            difference = other["free_energy_per_body_kt"] - value
            row.append(with_error(difference, math.hypot(error, other["free_energy_per_body_kt_error"])))
        print(f"| {packing} | {' | '.join(row)} |", flush=True)
    found = campaign.free_energy("arsenic", ANCHOR, BODIES["arsenic"])
    print(
        f"\narsenic, {BODIES['arsenic']} bodies at {ANCHOR}:",
        with_error(found["free_energy_per_body_kt"], found["free_energy_per_body_kt_error"]),
    )
    print("\n| q | reservoir | phases | packing fractions | βP v | share of draws |\n|---|---|---|---|---|---|")
    for q in SIZE_RATIOS:
        for tie in campaign.coexistences(q):
            low, high = (with_error(*pair) for pair in zip(tie["packing_fractions"], tie["packing_fractions_error"]))
            print(
                f"| {q} | {tie['reservoir_packing_fraction']} | {', '.join(tie['phases'])} | {low}, {high} |"
                f" {with_error(tie['pressure'], tie['pressure_error'], 2)} | {tie['share_of_draws']:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
