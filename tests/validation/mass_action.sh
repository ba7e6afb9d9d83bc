#!/usr/bin/env bash
# Two oppositely charged cubes in boxes of three sizes: the bound fraction of a sweep with replica
# exchange beside the association constant of `pair` by mass action.
#
#     bash tests/validation/mass_action.sh OUTPUT
#
# Takes about a minute of processor time and prints the table of docs/validation/mass-action.md.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
protomer=${PROTOMER:-$here/../../target/release/protomer}
mkdir -p "$1"
cd "$1"
python3 "$here/mass_action.py" bodies
for body in a b; do
    "$protomer" body -q --force --mesh cube.off --charges $body.xyzq -o $body.body
done
salts=50mM,100mM,200mM,400mM
"$protomer" pair a.body b.body --salt $salts -o pair --force --json -q > pair.json
for edge in 120 160 240; do
    "$protomer" sweep two$edge.json --salt $salts --replicas 8 --sweeps 60000 --equilibration 5000 \
        --starts both --exchange-every 10 --trajectory-every 0 --energy direct --seed 3 \
        --force -q -o sweep$edge --json > sweep$edge.json
done
python3 "$here/mass_action.py" table
