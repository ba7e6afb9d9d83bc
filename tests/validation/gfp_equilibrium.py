"""The tables of gfp_equilibrium.sh: what runs from five arrangements and from fluids come to.

    python3 tests/validation/gfp_equilibrium.py OUTPUT
"""

import json
import math
import random
import sys
from pathlib import Path

ARRANGEMENTS = ["candidate_1", "candidate_2", "candidate_3", "candidate_4", "tilted"]
COLUMNS = {"energy_kT": "energy (kT)", "bound_fraction": "bound bodies", "largest_cluster": "largest cluster"}
# Between the means of all stacks and of all fluids, and between one stack and the fluids.
MOST_STANDARD_ERRORS = 3.0
MOST_STANDARD_DEVIATIONS = 4.0
# Smaller differences do not matter.
LEAST_DIFFERENCE = {"energy_kT": 1.0, "bound_fraction": 0.05, "largest_cluster": 0.5}


def mean_and_error(estimates):
    """The mean of independent estimates, with the larger of two errors: their own, and that of their scatter."""
    count = len(estimates)
    mean = sum(value for value, _ in estimates) / count
    own = math.sqrt(sum(error**2 for _, error in estimates)) / count
    scatter = math.sqrt(sum((value - mean) ** 2 for value, _ in estimates) / (count - 1) / count)
    return mean, max(own, scatter)


def estimate(replica, observable):
    summary = replica[observable]
    return summary["mean"], summary["standard_error"]


def agree(observable, stacks, fluids):
    """Whether the stacks have become what the fluids are: their mean, and each of them."""
    (stack, stack_error), (fluid, fluid_error) = mean_and_error(stacks), mean_and_error(fluids)
    of_means = MOST_STANDARD_ERRORS * math.hypot(stack_error, fluid_error)
    of_each = MOST_STANDARD_DEVIATIONS * fluid_error * math.sqrt(len(fluids))
    least = LEAST_DIFFERENCE[observable]
    return abs(stack - fluid) <= max(of_means, least) and all(
        abs(value - fluid) <= max(of_each, least) for value, _ in stacks
    )


def crossing(salts, curve):
    """The salt where a falling curve goes through one half, linear in the logarithm of the salt; 0 or infinity where it
    is below or above one half throughout."""
    if curve[0] < 0.5:
        return 0.0
    for (low, high), (above, below) in zip(zip(salts, salts[1:]), zip(curve, curve[1:])):
        if above >= 0.5 > below:
            return low * (high / low) ** ((above - 0.5) / (above - below))
    return math.inf


def half_salt(salts, runs, draws=2000):
    """Where the mean of the runs goes through one half, and an interval of 95 % from runs drawn again."""

    def of(chosen):
        return crossing(salts, [sum(run[index] for run in chosen) / len(chosen) for index in range(len(salts))])

    generator = random.Random(1)
    drawn = sorted(of(generator.choices(runs, k=len(runs))) for _ in range(draws))
    return of(runs), drawn[int(0.025 * draws)], drawn[int(0.975 * draws)]


def main(output):
    sweeps = {name: json.loads((output / f"{name}.json").read_text()) for name in ARRANGEMENTS}
    salts = [row["salt_M"] for row in next(iter(sweeps.values()))["salts"]]
    agreed = set(range(len(salts)))
    for observable, title in COLUMNS.items():
        print(f"| {title} | " + " | ".join(ARRANGEMENTS) + " | all stacks | all fluids | agree |")
        print("|---" * (len(ARRANGEMENTS) + 4) + "|")
        for index, salt in enumerate(salts):
            # Even replicas begin from the stack, odd ones from a fluid.
            stacks = [estimate(sweep["replicas"][index][0], observable) for sweep in sweeps.values()]
            fluids = [estimate(sweep["replicas"][index][1], observable) for sweep in sweeps.values()]
            both = [mean_and_error(stacks), mean_and_error(fluids)]
            if not agree(observable, stacks, fluids):
                agreed.discard(index)
            cells = [f"{value:.3g} ± {error:.2g}" for value, error in [*stacks, *both]]
            print(f"| {1000 * salt:g} mM | " + " | ".join(cells) + f" | {'yes' if agree(observable, stacks, fluids) else 'no'} |")
        print()
    kept = sorted(agreed)
    runs = [
        [sweep["replicas"][index][start]["bound_fraction"]["mean"] for index in kept]
        for sweep in sweeps.values()
        for start in (0, 1)
    ]
    names = ", ".join(f"{1000 * salts[index]:g} mM" for index in kept) or "no salt"
    print(f"all three agree at {names}")
    if kept:
        middle, low, high = half_salt([1000 * salts[index] for index in kept], runs)
        print(f"half of the bodies bound at {middle:.0f} mM (95 %: {low:.0f} to {high:.0f} mM; 0 and inf: outside these salts)")
    for name, sweep in sweeps.items():
        print(f"{name}: {sweep['equilibration']}; exchanges:", sweep["exchanges"])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
