#!/usr/bin/env bash
# Cost of `score` by group of columns, and the contacts of crystals: the tables of docs/validation/interfaces.md.
#
#     bash tests/validation/scores.sh COMPLEXES CRYSTALS OUTPUT
#
# COMPLEXES holds NAME_receptor_bound.pdb.gz and NAME_ligand_bound.pdb.gz (docking benchmark 5), CRYSTALS entries of the Protein
# Data Bank with their space group and biological assembly, one of each cluster of sequences. Takes some two hours of
# processor time.
set -euo pipefail
protomer=${PROTOMER:-target/release/protomer}
complexes=$1 crystals=$2 output=$3
mkdir -p "$output"
for columns in charge area shape energy; do
    rm -rf "$output/$columns"
    "$protomer" score "$complexes" -o "$output/$columns" --columns "$columns" -q -j 1
    python3 - "$output/$columns/score.json" "$columns" <<'PYTHON'
import json, sys

found = json.load(open(sys.argv[1]))
print(sys.argv[2], found["rows"], "complexes,", round(3600 * found["rows"] / found["cpu_seconds"]), "rows per CPU-hour")
PYTHON
done
"$protomer" score "$crystals" --crystal -o "$output/crystals" --columns affinity,area,shape,contacts,charge,quality -q
python3 "$(dirname "$0")/interfaces.py" "$output/crystals/score.csv"
