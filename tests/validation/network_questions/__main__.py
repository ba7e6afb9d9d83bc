"""Two questions to the network, with baselines: does charge make copies of a protein attract, and is a chain a monomer?

    python tests/validation/network_questions STRUCTURES OUTPUT [STAGE...]

STRUCTURES is a folder of structure files with a MANIFEST.tsv (file, cluster, n_nucleotides); OUTPUT gets everything else. The
stages, in order; all if none is named, and each does only what is not there yet:

    chains    one chain of each entry as a body and a PQR file, its cluster, and its label from the deposited assembly
    pairs     small chains and a charge mutant of each: B2 of two copies by `pair`
    sets      the voxels of both questions, a set per fold
    networks  for each question and fold a network trained on the other folds, and its predictions
    permuted  the same with labels exchanged between clusters (--retrained times)
    report    scores with intervals, baselines and permutation tests, as tables, as report.json and as a figure

Folds and intervals are by cluster: entries of one cluster of the manifest, or whose chains share a tenth of the 5-mers of the
shorter one, are one cluster. PROTOMER names another program. Needs numpy, scipy, zarr and matplotlib. All work is done by one thread.
"""

import argparse
import itertools
from pathlib import Path

from entries import stage_chains
from networks import folder_of, stage_networks, stage_sets, tried
from pairs import stage_pairs
from plan import PERMUTED
from report import stage_report

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
STAGES = ["chains", "pairs", "sets", "networks", "permuted", "report"]
parser.add_argument("structures", type=Path)
parser.add_argument("output", type=Path)
parser.add_argument("stages", nargs="*", metavar="STAGE", help="all if none is named: " + ", ".join(STAGES))
parser.add_argument("--minutes", type=float, default=60.0, help="time for the stage pairs (60)")
parser.add_argument("--retrained", type=int, default=1, help="rounds of training on exchanged labels (1)")


def main():
    arguments = parser.parse_args()
    structures, output = arguments.structures, arguments.output
    unknown = set(arguments.stages) - set(STAGES)
    if unknown:
        parser.error(f"no such stage: {', '.join(sorted(unknown))}; there are {', '.join(STAGES)}")
    for stage in STAGES:
        if arguments.stages and stage not in arguments.stages:
            continue
        if stage == "chains" and not (output / "chains.json").exists():
            stage_chains(structures, output)
        elif stage == "pairs":
            stage_pairs(structures, output, arguments.minutes)
        elif stage == "sets":
            for task, setting in tried():
                stage_sets(output, task, setting)
        elif stage == "networks":
            for task, setting in tried():
                stage_networks(folder_of(output, task, setting), task, setting)
        elif stage == "permuted":
            for (task, setting), permutation in itertools.product(PERMUTED.items(), range(1, arguments.retrained + 1)):
                stage_networks(stage_sets(output, task, setting, permutation), task, setting)
        elif stage == "report":
            stage_report(output)


if __name__ == "__main__":
    main()
