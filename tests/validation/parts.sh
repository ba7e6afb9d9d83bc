#!/usr/bin/env bash
# Patchy cubes: pairs in a box of 64 bodies under replica exchange beside the partition function of `stability`.
#
#     bash tests/validation/parts.sh OUTPUT
#
# Takes about a quarter of an hour of processor time and prints the table of docs/validation/parts-of-assemblies.md. Needs gsd and scipy.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
protomer=${PROTOMER:-$here/../../target/release/protomer}
mkdir -p "$1"
cd "$1"
python3 "$here/parts.py" bodies
"$protomer" body -q --force --mesh cube.off --charges patchy.xyzq -o patchy.body
salts=500mM,560mM,640mM,760mM,1M
"$protomer" stability ring.json --model thesis --salt $salts --concentration 10mM --live-states 200 --runs 8 \
    --force -q -o stability
cp stability/stability.json .
"$protomer" assemble fluid patchy.body --counts 64 --box 220 --force -q -o fluid.json
"$protomer" sweep fluid.json --salt $salts --model thesis --exchange-every 10 --binding-moves 64 --replicas 2 \
    --starts fluid --sweeps 12000 --equilibration 1000 --trajectory-every 25 --log-every 25 --energy direct \
    --force -q -o fluid
python3 "$here/parts.py" table
