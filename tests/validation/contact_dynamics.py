"""How well contact dynamics keeps the energy, in two and three dimensions, and how fast it is.

    python tests/validation/contact_dynamics.py OUTPUT [--short | --tetrahedra]

Runs `protomer md run` for small systems of polygons (20 time units) and for octahedra at high density
(0.08 time units with every form of the repulsion, 100 with the smooth one), halves the time step, and
prints the tables of docs/validation/contact-dynamics.md. `--short` leaves out the hundred time units; `--tetrahedra` makes
those of tetrahedra alone.
The command is $PROTOMER, or target/release/protomer.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROTOMER = os.environ.get("PROTOMER", str(HERE / "../../target/release/protomer"))
FORMS = ("contact", "face-sum", "smooth")


def run(output: Path, name: str, **flags) -> dict:
    """The answer of one run."""
    words = [PROTOMER, "md", "run", "-o", str(output / name), "--json", "-q", "--threads", "1"]
    words += ["--trajectory-every", "0"]
    for flag, value in flags.items():
        words += [f"--{flag.replace('_', '-')}", str(value)]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        return {"failed": done.stderr.strip().splitlines()[-1]}
    return json.loads(done.stdout)


def energies(answer: dict) -> str:
    """The cells of a table that say how well the energy was kept."""
    if "failed" in answer:
        return f"{answer['failed']} | | "
    return (
        f"{answer['energy_noise_per_body']:.1e} | {answer['energy_drift_per_body']:+.1e} | "
        f"{answer['temperature_kt']:.3f}"
    )


def polygons(output: Path) -> None:
    print("| polygon | packing fraction | form | time step | noise per body | drift per body | kT |")
    print("|---|---|---|---|---|---|---|")
    for corners, packing in ((4, 0.6), (6, 0.6), (3, 0.4)):
        for form in FORMS:
            for step in (2e-4, 1e-4, 5e-5):
                answer = run(
                    output, f"polygon{corners}_{form}_{step}", shape=f"polygon:{corners}", bodies=36,
                    packing_fraction=packing, potential=form, time_step=step, steps=round(20 / step),
                )
                print(f"| {corners} | {packing} | {form} | {step:g} | {energies(answer)} |", flush=True)


def octahedra(output: Path, packing: float) -> None:
    print("| form | time | time step | noise per body | drift per body | kT |")
    print("|---|---|---|---|---|---|")
    runs = [(form, 0.08, step) for form in FORMS for step in (1e-4, 5e-5)]
    runs += [(form, 2.0, step) for form in FORMS for step in (2e-4, 1e-4, 5e-5)]
    if "--short" not in sys.argv:
        runs += [("smooth", 100.0, 1e-4)]
    for form, time, step in runs:
        answer = run(
            output, f"octahedra_{form}_{time}_{step}", shape="octahedron", bodies=64,
            packing_fraction=packing, potential=form, time_step=step, steps=round(time / step),
            compress_steps=20000,
        )
        print(f"| {form} | {time:g} | {step:g} | {energies(answer)} |", flush=True)


def tetrahedra(output: Path) -> None:
    print("| packing fraction | of the cores | form | bodies | time | time step | noise per body | drift per body | kT |")
    print("|---|---|---|---|---|---|---|---|---|")
    # At 0.6 the box of 64 bodies is too small for their range.
    each = [(packing, form, bodies) for packing, bodies in ((0.4, 64), (0.6, 90)) for form in ("face-sum", "smooth")]
    runs = [(*one, 2.0, step) for one in each for step in (2e-4, 1e-4, 5e-5)]
    runs += [(*one, 100.0, 1e-4) for one in each]
    # As long as the runs of the thesis.
    runs += [(*one, 1000.0, 1e-4) for one in each[:2]]
    for packing, form, bodies, time, step in runs:
        answer = run(
            output, f"tetrahedra_{packing}_{form}_{bodies}_{time}_{step}", shape="tetrahedron", bodies=bodies,
            packing_fraction=packing, potential=form, time_step=step, steps=round(time / step), compress_steps=20000,
        )
        core = f"{answer['core_packing_fraction']:.3f}" if "failed" not in answer else ""
        print(f"| {packing} | {core} | {form} | {bodies} | {time:g} | {step:g} | {energies(answer)} |", flush=True)


def speed(output: Path) -> None:
    print("| bodies | packing fraction | form | steps per CPU-second | body-steps per CPU-second |")
    print("|---|---|---|---|---|")
    for shape, bodies, packing in (("polygon:4", 1000, 0.6), ("octahedron", 500, 0.5)):
        for form in FORMS:
            answer = run(
                output, f"speed_{bodies}_{form}", shape=shape, bodies=bodies, packing_fraction=packing,
                potential=form, steps=5000,
            )
            rate = answer["body_steps_per_cpu_second"]
            print(f"| {bodies} {shape} | {packing} | {form} | {rate / bodies:.0f} | {rate:.2e} |")


def main() -> None:
    output = Path(sys.argv[1])
    output.mkdir(parents=True, exist_ok=True)
    if "--tetrahedra" in sys.argv:
        tetrahedra(output)
        return
    print("\nPolygons, 36 bodies, 20 time units:\n")
    polygons(output)
    print("\nOctahedra, 64 bodies, packing fraction 0.6:\n")
    octahedra(output, 0.6)
    print("\nSpeed on one core:\n")
    speed(output)


if __name__ == "__main__":
    main()
