#!/usr/bin/env bash
# Two oppositely charged cubes: curves from the frames of one sweep in one box, between its salts and at
# two other concentrations of bodies, beside the association constant of `pair` at the same salts.
#
#     bash tests/validation/reweighting.sh OUTPUT
#
# Takes a minute or two of processor time and prints the table of docs/validation/reweighting.md.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
protomer=${PROTOMER:-$here/../../target/release/protomer}
mkdir -p "$1"
cd "$1"
python3 "$here/mass_action.py" bodies
for body in a b; do
    "$protomer" body -q --force --mesh cube.off --charges $body.xyzq -o $body.body
done
curve=50mM,70mM,100mM,140mM,200mM,280mM,400mM
"$protomer" pair a.body b.body --salt $curve -o pair --force --json -q > pair.json
"$protomer" sweep two120.json --salt 50mM,100mM,200mM,400mM --replicas 8 --sweeps 20000 \
    --equilibration 2000 --starts both --exchange-every 10 --trajectory-every 20 --energy direct --seed 3 \
    --force -q -o sweep120 --json > sweep120.json
"$protomer" reweight sweep120 --salt $curve --concentration "$(python3 "$here/reweighting.py" concentrations)" \
    --most-frames 1000 --force -q --json -o curves > curves.json
python3 "$here/reweighting.py" table
