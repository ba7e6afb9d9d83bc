"""The tables of gfp_equilibrium.sh: what runs from five arrangements and from fluids come to.

    python3 tests/validation/gfp_equilibrium.py OUTPUT
"""

import json
import math
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


def main(output):
    sweeps = {name: json.loads((output / f"{name}.json").read_text()) for name in ARRANGEMENTS}
    salts = [row["salt_M"] for row in next(iter(sweeps.values()))["salts"]]
    for observable, title in COLUMNS.items():
        print(f"| {title} | " + " | ".join(ARRANGEMENTS) + " | all stacks | all fluids | agree |")
        print("|---" * (len(ARRANGEMENTS) + 4) + "|")
        for index, salt in enumerate(salts):
            # Even replicas begin from the stack, odd ones from a fluid.
            stacks = [estimate(sweep["replicas"][index][0], observable) for sweep in sweeps.values()]
            fluids = [estimate(sweep["replicas"][index][1], observable) for sweep in sweeps.values()]
            both = [mean_and_error(stacks), mean_and_error(fluids)]
            cells = [f"{value:.3g} ± {error:.2g}" for value, error in [*stacks, *both]]
            print(f"| {1000 * salt:g} mM | " + " | ".join(cells) + f" | {'yes' if agree(observable, stacks, fluids) else 'no'} |")
        print()
    for name, sweep in sweeps.items():
        print(f"{name}: {sweep['equilibration']}; exchanges:", sweep["exchanges"])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
