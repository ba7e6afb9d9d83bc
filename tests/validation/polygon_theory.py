"""Claim P3 of chapter 5: does the Langevin equation with a quadratic friction describe the motion of polygons?

    python tests/validation/polygon_theory.py RUNS

RUNS is the output of polygon_dynamics.py. Eq. 5.3 of the thesis, with |v| v in the place of v² (which has no direction), is

    dv/dt = -ξ v - γ |v| v + f(t)

with white noise f, whose strength follows from the mean square velocity. Its mean squared displacement is integrated for several
ratios of the two frictions and fitted to that of each shape at each density by one time scale. The table gives the best
ratio, the root mean square of the logarithm's difference, and the least local slopes of both.
"""

import sys
from pathlib import Path

import numpy as np

from protomer.dynamics import Seeds, local_slope

SHAPES = [*(f"polygon{n}" for n in range(3, 10)), "disk"]
# The part of the quadratic friction: w |v| v in addition to (1 - w) v, in units of the root mean square of a component.
PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)
PARTICLES, STEP, STEPS, EVERY = 4000, 0.02, 20_000, 5
RATES = np.geomspace(0.3, 300.0, 400)


def noise(part: float) -> float:
    """The strength of the noise for which a component of the velocity has the mean square 1.

    The stationary density of the speed is v exp(-V(v)/D) with V = (1 - w) v²/2 + w v³/3.
    """
    speed = np.linspace(0.0, 12.0, 4001)
    potential = 0.5 * (1.0 - part) * speed**2 + part * speed**3 / 3.0
    low, high = 0.05, 20.0
    for _ in range(60):
        middle = np.sqrt(low * high)
        density = speed * np.exp(-potential / middle)
        low, high = (low, middle) if np.sum(density * speed**2) > 2.0 * np.sum(density) else (middle, high)
    return float(np.sqrt(low * high))


def theory(part: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and mean squared displacements of the equation in units of its friction, by the method of Heun."""
    rng = np.random.default_rng(1)
    strength = noise(part)
    velocity, place = rng.normal(size=(PARTICLES, 2)), np.zeros((PARTICLES, 2))
    places = []

    def friction(v: np.ndarray) -> np.ndarray:
        return -((1.0 - part) + part * np.linalg.norm(v, axis=1, keepdims=True)) * v

    for step in range(-2000, STEPS):
        kick = np.sqrt(2.0 * strength * STEP) * rng.normal(size=velocity.shape)
        first = friction(velocity)
        trial = velocity + STEP * first + kick
        new = velocity + 0.5 * STEP * (first + friction(trial)) + kick
        place += 0.5 * STEP * (velocity + new)
        velocity = new
        if step >= 0 and step % EVERY == 0:
            places.append(place.copy())
    track = np.array(places)
    lags = np.unique(np.geomspace(1, len(track) // 4, 60).astype(int))
    squares = [np.mean(np.sum((track[lag::7] - track[: len(track) - lag : 7]) ** 2, axis=2)) for lag in lags]
    return lags * EVERY * STEP, np.array(squares)


def fit(times: np.ndarray, squares: np.ndarray, component: float, curves: dict) -> tuple[float, float, float]:
    """From the root mean square of a component of the velocity: best part of the quadratic friction, its rate, and the root mean square of the logarithm's difference."""
    best = (0.0, 0.0, np.inf)
    for part, (t, of_theory) in curves.items():
        for rate in RATES:
            # Free flight before the first time of the theory, diffusion after its last.
            scaled = np.clip(rate * times, t[0], t[-1])
            value = np.exp(np.interp(np.log(scaled), np.log(t), np.log(of_theory)))
            value *= np.where(rate * times < t[0], (rate * times / t[0]) ** 2, np.maximum(rate * times / t[-1], 1.0))
            difference = np.log(squares) - np.log(value * (component / rate) ** 2)
            found = float(np.sqrt(np.mean(difference**2)))
            best = min(best, (part, float(rate), found), key=lambda of: of[2])
    return best


def main() -> None:
    runs = Path(sys.argv[1])
    curves = {part: theory(part) for part in PARTS}
    for part, (t, squares) in curves.items():
        print(f"w = {part}: least slope of the equation {np.min(local_slope(t, squares)[1]):.3f}")
    print("| shape | packing | w | rate | rms of ln | least slope, measured | below 1 by (errors) |")
    print("|---|---|---|---|---|---|---|")
    densities = sorted({float(folder.name.split("_")[1]) for folder in runs.glob("disk_*_1")})
    for density in densities:
        for shape in SHAPES:
            seeds = Seeds(sorted(runs.glob(f"{shape}_{density}_*")))
            times, squares, _ = seeds.curve("displacement")
            kept = np.unique(np.geomspace(1, len(times) // 2, 40).astype(int))
            component = np.sqrt(np.mean([np.mean(motion.velocities[..., :2] ** 2) for motion in seeds.motions]))
            part, rate, rms = fit(times[kept], squares[kept], component, curves)
            _, slope, error = seeds.curve("slope")
            least = int(np.argmin(slope))
            below = (1.0 - slope[least]) / error[least]
            print(f"| {shape} | {density} | {part} | {rate:.1f} | {rms:.3f} | {slope[least]:.3f} ± {error[least]:.3f} | {below:.1f} |", flush=True)


if __name__ == "__main__":
    main()
