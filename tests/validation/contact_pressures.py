"""Pressures of soft squares and cubes (AWCA) compared with hard ones.

    python tests/validation/contact_pressures.py OUTPUT [FORMS [SHAPES]]

`protomer md run` measures the pressure of bodies that repel each other at kT = 1, in each form of the
repulsion; `protomer hpmc run` that of hard bodies at the same number density, rounded by half of a
contact distance. The contact distance is that at which the energy of two aligned faces is kT: one
term of the contact point, four of squares, eight (smooth) or twenty (face sum) of cubes. The last
columns give the pressure of hard bodies at 0.150 and at that distance, and the distance at which
hard bodies have the pressure that was measured, between two more runs.
The command is $PROTOMER, or target/release/protomer; $LENGTH (1) makes all runs so many times longer.
"""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROTOMER = os.environ.get("PROTOMER", str(HERE / "../../target/release/protomer"))
# Terms of aligned faces at the same distance.
TERMS = {
    ("polygon:4", "contact"): 1, ("polygon:4", "face-sum"): 4, ("polygon:4", "smooth"): 4,
    ("cube", "contact"): 1, ("cube", "smooth"): 8, ("cube", "face-sum"): 20,
}
PACKINGS = {"polygon:4": (0.3, 0.5, 0.6), "cube": (0.2, 0.3, 0.4)}
BODIES = {"polygon:4": 144, "cube": 125}
LENGTH = int(os.environ.get("LENGTH", "1"))
SWEEPS = {"polygon:4": 12000 * LENGTH, "cube": 8000 * LENGTH}
STEPS = {"polygon:4": 30000 * LENGTH, "cube": 12000 * LENGTH}


def run(*words: object) -> dict:
    done = subprocess.run([PROTOMER, *map(str, words), "--json", "-q", "-j", "1"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def distance_at_kt(terms: int) -> float:
    """x/σ with terms (2 (σ_c/x)⁶ - 1)² = 1 and σ_c = 0.15 σ."""
    sixth = 0.5 * (1.0 + terms ** -0.5)
    return 0.15 * sixth ** (-1.0 / 6.0)


def barker_henderson(terms: int) -> float:
    """x/σ of hard bodies that hold as little room as soft ones whose energy depends on one distance: ∫ (1 - exp(-u/kT)) dx."""
    end, points = 0.15 * 2.0 ** (1.0 / 6.0), 20_000
    step = end / points
    energies = (terms * (2.0 * (0.15 / ((number + 0.5) * step)) ** 6 - 1.0) ** 2 for number in range(points))
    return step * sum(1.0 - math.exp(-energy) for energy in energies)


def volume(shape: str, radius: float) -> float:
    """Of a body with a layer (Steiner)."""
    pi = 3.141592653589793
    if shape == "cube":
        return 1.0 + 6.0 * radius + 3.0 * pi * radius**2 + 4.0 / 3.0 * pi * radius**3
    return 1.0 + 4.0 * radius + pi * radius**2


def hard(output: Path, shape: str, distance: float, density: float) -> tuple[float, float]:
    """P v/kT over v, the pressure, of hard bodies that touch at a distance, and its error."""
    radius = 0.5 * distance
    packing = density * volume(shape, radius)
    name = f"hard_{shape.replace(':', '')}_{distance:.4f}_{density:.5f}"
    found = run(
        "hpmc", "run", "--shape", shape, "--rounding", radius, "--bodies", BODIES[shape], "--packing-fraction", packing,
        "--sweeps", SWEEPS[shape], "--equilibration", 2000, "-o", output / name,
    )
    return found["compressibility_factor"] * density, found["compressibility_factor_error"] * density


def main() -> None:
    output = Path(sys.argv[1])
    output.mkdir(parents=True, exist_ok=True)
    forms = sys.argv[2].split(",") if len(sys.argv) > 2 else ["contact", "face-sum", "smooth"]
    shapes = sys.argv[3].split(",") if len(sys.argv) > 3 else list(PACKINGS)
    distances = ", ".join(f"{terms}: {barker_henderson(terms):.4f}" for terms in (1, 4, 8, 20))
    print(f"Barker-Henderson distances by the number of terms: {distances}")
    print("| body | form | density | P (soft) | x₁ | P (hard, 0.150) | P (hard, x₁) | x of equal P |")
    print("|---|---|---|---|---|---|---|---|")
    for shape in shapes:
        for packing in PACKINGS[shape]:
            density = packing / volume(shape, 0.075)
            known: dict[float, tuple[float, float]] = {}
            for form in forms:
                name = f"soft_{shape.replace(':', '')}_{form}_{packing}"
                soft = run(
                    "md", "run", "--shape", shape, "--bodies", BODIES[shape], "--packing-fraction", packing, "--potential", form,
                    "--ensemble", "nvt", "--time-step", 5e-4, "--steps", STEPS[shape], "--compress-steps", 5000,
                    "--equilibrate-steps", 5000, "--trajectory-every", 0, "-o", output / name,
                )
                x = distance_at_kt(TERMS[shape, form])
                for distance in (0.15, x, 0.17):
                    if distance not in known:
                        known[distance] = hard(output, shape, distance, density)
                (low, low_error), (high, _) = known[0.15], known[0.17]
                pressure = soft["pressure"]
                # None if the run is too short for independent blocks.
                own = soft["pressure_error"] or float("nan")
                equal = 0.15 + 0.02 * (pressure - low) / (high - low)
                error = 0.02 * (own**2 + low_error**2) ** 0.5 / (high - low)
                print(
                    f"| {shape} | {form} | {density:.4f} | {pressure:.3f} ± {own:.3f} | {x:.4f} | "
                    f"{low:.3f} ± {low_error:.3f} | {known[x][0]:.3f} ± {known[x][1]:.3f} | {equal:.4f} ± {error:.4f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
