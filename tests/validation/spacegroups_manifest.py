"""Turns a folder of structures with a MANIFEST.tsv (file, sg_reference_name, cluster, cell) into a manifest of protomer voxelize.

    python tests/validation/spacegroups_manifest.py FOLDER [--first N] > spacegroups.csv

The label is the space group. Copies of one crystal form, which share cluster, space group and a cell within 2 %, share a family.
"""

import argparse
import csv
import sys
from pathlib import Path

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder", type=Path)
parser.add_argument("--first", type=int, help="only so many structures")
arguments = parser.parse_args()

with open(arguments.folder / "MANIFEST.tsv", newline="") as file:
    rows = list(csv.DictReader(file, delimiter="\t"))[: arguments.first]

families = {}


def family(row):
    """The first structure of the same cluster, group and cell stands for all of them."""
    cell = [float(word) for word in row["cell"].split()]
    known = families.setdefault((row["cluster"], row["sg_reference_name"]), [])
    for other, name in known:
        if all(abs(a - b) <= 0.02 * max(a, b) for a, b in zip(cell, other)):
            return name
    known.append((cell, row["file"].split(".")[0]))
    return known[-1][1]


writer = csv.writer(sys.stdout, lineterminator="\n")
writer.writerow(["file", "label", "cluster", "family"])
for row in rows:
    writer.writerow([(arguments.folder / row["file"]).resolve(), row["sg_reference_name"], row["cluster"], family(row)])
