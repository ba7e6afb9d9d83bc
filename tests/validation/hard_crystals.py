"""Free energies of crystals, constant pressure and gravity of hard bodies against known numbers.

python tests/validation/hard_crystals.py PROTOMER FRENKEL_LADD_EXACT FRENKEL_LADD_MONTE_CARLO SEDIMENTATION OUTPUT [SWEEPS [PART ...]]

Prints the tables of docs/validation/hard-shapes-free-energies.md. Parts: rods, crystals, limit, pressure, gravity.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

PROGRAM, OUTPUT = sys.argv[1], Path(sys.argv[5])
SWEEPS = int(sys.argv[6]) if len(sys.argv) > 6 else 20000
PARTS = sys.argv[7:] or ["rods", "crystals", "limit", "pressure", "gravity"]


def reference(number):
    return json.loads(Path(sys.argv[number]).read_text())


def protomer(name, *arguments):
    command = [PROGRAM, *map(str, arguments), "--json", "-q", "--no-progress", "-o", str(OUTPUT / name)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def free_energy(name, shape, crystal, bodies, packing, sweeps):
    found = protomer(
        name, "free-energy", "--shape", *shape, "--crystal", crystal, "--bodies", bodies, "--packing-fraction", packing,
        "--sweeps", sweeps,
    )  # fmt: skip
    return found["free_energy_per_body_kt"], found["free_energy_per_body_kt_error"], found


def row(*cells):
    print("| " + " | ".join(cell if isinstance(cell, str) else f"{cell:.5f}" for cell in cells) + " |", flush=True)


def head(*cells):
    print()
    row(*cells)
    row(*["---" for _ in cells])


def rods():
    head("rods", "density", "A/(N kT), exact", "protomer", "±", "difference", "slow points")
    for exact in reference(2)["tonks"]["rows"]:
        bodies, density = exact["N"], exact["rho"]
        ours, error, found = free_energy(f"rods-{bodies}", ["rod:1"], "row", bodies, density, SWEEPS)
        apart = ours - exact["A_over_NkT"]
        row(str(bodies), density, exact["A_over_NkT"], ours, error, apart, str(len(found["slow_points"])))


def sphere():
    point = OUTPUT / "point.txt"
    point.write_text("0 0 0\n")
    return [str(point), "--rounding", "0.5"]


def crystals():
    head("crystal", "N", "number density", "reference", "±", "protomer", "±", "difference", "rules", "slow points")
    for known in reference(3)["rows"]:
        is_cube, bodies, density = known["body"].startswith("cube"), known["N"], known["number_density"]
        shape, crystal = (["cube"], "simple-cubic") if is_cube else (sphere(), "fcc")
        packing = density * (1 if is_cube else math.pi / 6)
        name = f"{crystal}-{bodies}-{density}"
        ours, error, found = free_energy(name, shape, crystal, bodies, packing, SWEEPS)
        rules, slow = found["terms"]["rules_difference_kt"], str(len(found["slow_points"]))
        value, its_error = known["A_over_NkT"], known["error"]
        row(crystal, str(bodies), density, value, its_error, ours, error, ours - value, rules, slow)


def limit():
    """A/N + ln N/(2N) is linear in 1/N (Polson et al. 2000)."""
    head("N", "A/(N kT)", "±", "A/(N kT) + ln N/(2N)")
    points = []
    for bodies in (108, 256, 500):
        packing = 1.15 * math.pi / 6
        name = f"fcc-{bodies}-1.15"
        ours, error, _ = free_energy(name, sphere(), "fcc", bodies, packing, SWEEPS)
        points.append((1 / bodies, ours + math.log(bodies) / (2 * bodies), error))
        row(str(bodies), ours, error, points[-1][1])
    weights = [1 / error**2 for _, _, error in points]
    total = sum(weights)
    x = sum(weight * point[0] for weight, point in zip(weights, points, strict=True)) / total
    y = sum(weight * point[1] for weight, point in zip(weights, points, strict=True)) / total
    spread = sum(weight * (point[0] - x) ** 2 for weight, point in zip(weights, points, strict=True))
    slope = sum(weight * (point[0] - x) * point[1] for weight, point in zip(weights, points, strict=True)) / spread
    print(f"\nN → ∞: {y - slope * x:.4f} ± {math.sqrt(1 / total + x * x / spread):.4f}, literature 6.2732 ± 0.002")


def pressure():
    """Packing fractions at the pressures of Z at constant volume, by an independent program."""
    head("body", "βP", "packing fraction at it", "protomer", "±", "its own Z there times φ/v")
    for shape, volume, packing, factor in (
        (["cube"], 1, 0.3, 6.2354),
        (sphere(), math.pi / 6, 0.4, 6.949),
        (["tetrahedron"], math.sqrt(2) / 12, 0.25, 6.3963),
    ):
        kt_per_volume = factor * packing / volume
        found = protomer(
            f"pressure-{packing}", "hpmc", "run", "--shape", *shape, "--packing-fraction", packing, "--pressure", kt_per_volume,
            "--equilibration", 4000, "--sweeps", SWEEPS, "--trajectory-every", 0,
        )  # fmt: skip
        ours, error = found["packing_fraction"], found["packing_fraction_error"]
        row(shape[0].split("/")[-1], kt_per_volume, packing, ours, error, found["reduced_pressure"] / volume)


def packing_of(mu, low=0.0, high=0.6):
    """The packing fraction at which the chemical potential of Carnahan and Starling has a value."""
    for _ in range(80):
        middle = (low + high) / 2
        below = potential(middle) < mu
        low, high = (middle, high) if below else (low, middle)
    return (low + high) / 2


def potential(eta):
    return math.log(eta) + (8 * eta - 9 * eta**2 + 3 * eta**3) / (1 - eta) ** 3


def gravity():
    """The sum rule of the walls for several bodies; spheres against the local density approximation."""
    head("bodies", "weight per length", "lower pressure", "±", "upper pressure", "weight per area", "difference / error")
    for shape, weight in ((sphere(), 0.5), (["cube"], 0.5), (["truncated-tetrahedron:0.6667"], 3)):
        name = f"gravity-{shape[0].split('/')[-1].split(':')[0]}"
        found = protomer(
            name, "hpmc", "run", "--shape", *shape, "--bodies", 300, "--packing-fraction", 0.2, "--box", "1,1,3",
            "--gravity", weight, "--equilibration", 4000, "--sweeps", SWEEPS, "--trajectory-every", 0,
        )  # fmt: skip
        walls = found["walls"]
        error = math.hypot(walls["lower_pressure_error"], walls["upper_pressure_error"])
        apart = walls["lower_pressure"] - walls["upper_pressure"] - walls["weight_per_area"]
        row(
            name.removeprefix("gravity-"), float(weight), walls["lower_pressure"], walls["lower_pressure_error"],
            walls["upper_pressure"], walls["weight_per_area"], apart / error,
        )  # fmt: skip
    known = reference(4)["hard_spheres_local_density"]["rows"][0]
    # Spheres of diameter 1, l_g = 10: the column of the reference holds so many per area.
    length, edge = 10.0, 6.0
    bodies = round(known["total_eta_dz_over_l_g"] * length * edge * edge * 6 / math.pi)
    height = 12 * length
    packing = bodies * math.pi / 6 / (edge * edge * height)
    found = protomer(
        "column", "hpmc", "run", "--shape", *sphere(), "--bodies", bodies, "--packing-fraction", packing, "--box",
        f"{edge},{edge},{height}", "--gravity", 1 / length, "--equilibration", SWEEPS, "--sweeps", SWEEPS,
        "--sample-every", 20, "--trajectory-every", 0,
    )  # fmt: skip
    lines = (OUTPUT / "column" / "profile.csv").read_text().splitlines()[1:]
    profile = [tuple(map(float, line.split(","))) for line in lines]
    head("z / l_g", "packing fraction, local density", "protomer (mean over l_g/2)")
    bottom = potential(known["eta_bottom"])
    # Heights are those over the lowest place of a centre, half a diameter above the wall.
    for z in (0.5, 1, 2, 3, 4, 5, 6):
        near = [entry[2] for entry in profile if abs(entry[0] - 0.5 - z * length) < length / 4]
        row(float(z), packing_of(bottom - z), sum(near) / len(near))
    walls = found["walls"]
    print(f"\npressure below {walls['lower_pressure']:.4f} ± {walls['lower_pressure_error']:.4f}, weight {walls['weight_per_area']:.4f}")


OUTPUT.mkdir(parents=True, exist_ok=True)
for part in PARTS:
    {"rods": rods, "crystals": crystals, "limit": limit, "pressure": pressure, "gravity": gravity}[part]()
