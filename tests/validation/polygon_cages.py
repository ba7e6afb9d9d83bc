"""Cages and dynamic heterogeneity of the polygons of chapter 5.

    python tests/validation/polygon_cages.py RUNS

RUNS is the output of polygon_dynamics.py, or what there is of it: shapes at 0.68 and pentagons at all densities. For each: the largest
non-Gaussian parameter of the displacements and its time, that of the angles, the time after which the self-intermediate scattering
function at k = 6 falls to 1/e, and the time after which 1/e of the bodies have stayed within 0.3 (of the edge of a square of the same
area). Means and standard errors over the seeds; a dash where the run is too short.
"""

import sys
from pathlib import Path

import numpy as np

from protomer.dynamics import Motion, Seeds

WAVE_NUMBER, DISTANCE = 6.0, 0.3


def falls(times: np.ndarray, values: np.ndarray) -> float:
    """The time at which values fall to 1/e, between lags along a straight line."""
    below = np.flatnonzero(values < np.exp(-1.0))
    if below.size == 0:
        return float("nan")
    after = int(below[0])
    return float(np.interp(-np.exp(-1.0), -values[after - 1 : after + 1], times[after - 1 : after + 1]))


def words(values: list[float]) -> str:
    found = np.array(values)
    if not np.isfinite(found).all():
        return "-"
    return f"{found.mean():.3g} ± {found.std(ddof=1) / np.sqrt(len(found)):.1g}"


def main() -> None:
    runs = Path(sys.argv[1])
    print("| shape | packing | largest α₂ | at t | largest α₂ of angles | F_s(k = 6) falls to 1/e at | escape from 0.3 at |")
    print("|---|---|---|---|---|---|---|")
    states = [(shape, 0.68) for shape in (*(f"polygon{n}" for n in range(3, 10)), "disk")]
    states += [("polygon5", density) for density in (0.5, 0.6, 0.65, 0.7, 0.72, 0.75, 0.78)]
    for shape, density in states:
        folders = sorted(runs.glob(f"{shape}_{density}_*"))
        if not folders:
            continue
        motions = [Motion.read(folder) for folder in folders]
        # The last lags have few origins.
        parameters = [[part[: -len(part) // 4] for part in motion.non_gaussian()] for motion in motions]
        turning = "-"
        if shape != "disk":
            turning = words([float(np.max(motion.non_gaussian_turning()[1][:-15])) for motion in motions])
        row = [
            words([float(values.max()) for _, values in parameters]),
            f"{Seeds(motions).curve('non_gaussian')[0][int(np.argmax(np.mean([values for _, values in parameters], axis=0)))]:.2g}",
            turning,
            words([falls(*motion.intermediate(WAVE_NUMBER)) for motion in motions]),
            words([motion.escape_time(DISTANCE) for motion in motions]),
        ]
        print(f"| {shape} | {density} | " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
