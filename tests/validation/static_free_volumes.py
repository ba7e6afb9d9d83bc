"""Free volumes of depletants in perfect diamonds of truncated tetrahedra: hexagonal less cubic (thesis, figures 2.4d and A.14).

    python tests/validation/static_free_volumes.py PROTOMER

The first table has the difference against the size ratio q at four packing fractions and its largest value; the second has it for
rounded bodies at q = 0.2. q is the depletant's radius over the circumradius of the (rounded) body; roundings are parts of the
circumradius R of the sharp one.
"""

import json
import subprocess
import sys

import numpy as np

SHAPE = "truncated-tetrahedron:0.6666666666666666"
# The edge of the tetrahedron is 1.
CIRCUMRADIUS = np.sqrt(22.0) / 12.0
RATIOS = [0.08, 0.12, 0.16, 0.2, 0.24, 0.28, 0.32]
DENSITIES = [0.5, 0.58, 0.66, 0.74]


def free_volumes(crystal: str, densities: list[float], ratios: list[float], rounding: float) -> tuple[np.ndarray, np.ndarray]:
    """Fractions and their errors, (densities, ratios)."""
    listed = lambda values: ",".join(f"{value:.10g}" for value in values)  # noqa: E731
    words = [
        sys.argv[1], "hpmc", "free-volume", "--shape", SHAPE, "--crystal", crystal, "--packing-fraction", listed(densities),
        "--depletant-radius", listed([ratio * (1.0 + rounding) * CIRCUMRADIUS for ratio in ratios]), "--rounding", str(rounding * CIRCUMRADIUS), "--json",
    ]
    rows = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    shape = (len(densities), len(ratios))
    return tuple(np.array([row[key] for row in rows]).reshape(shape) for key in ("free_volume_fraction", "free_volume_fraction_error"))


def difference(densities: list[float], ratios: list[float], rounding: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    cubic, of_cubic = free_volumes("diamond", densities, ratios, rounding)
    hexagonal, of_hexagonal = free_volumes("hexagonal-diamond", densities, ratios, rounding)
    return hexagonal - cubic, np.hypot(of_cubic, of_hexagonal)


def main() -> None:
    print("| packing | " + " | ".join(f"q = {ratio}" for ratio in RATIOS) + " | largest at q |")
    print("|---" * (len(RATIOS) + 2) + "|")
    found, errors = difference(DENSITIES, RATIOS)
    for density, row, error in zip(DENSITIES, found, errors, strict=True):
        words = [f"{1e3 * value:.2f} ± {1e3 * of:.2f}" for value, of in zip(row, error, strict=True)]
        print(f"| {density} | " + " | ".join(words) + f" | {RATIOS[int(np.argmax(row))]} |")
    print("\n| packing | rounding 0 | rounding 0.05 R | rounding 0.1 R |")
    print("|---|---|---|---|")
    densities = [0.58, 0.66]
    columns = [difference(densities, [0.2], rounding) for rounding in (0.0, 0.05, 0.1)]
    for number, density in enumerate(densities):
        words = [f"{1e3 * value[number, 0]:.2f} ± {1e3 * of[number, 0]:.2f}" for value, of in columns]
        print(f"| {density} | " + " | ".join(words) + " |")


if __name__ == "__main__":
    main()
