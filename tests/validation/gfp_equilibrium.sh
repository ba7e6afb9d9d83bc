#!/usr/bin/env bash
# Sixteen supercharged GFPs at equilibrium: replica exchange over salt from each of five closed stacks, and as often
# from fluids. Where all starts come to the same energies and contacts, the arrangement that a run began with is
# forgotten, and the answer is one for all five.
#
#     bash tests/validation/gfp_equilibrium.sh STACKS OUTPUT
#
# STACKS is the output of tests/validation/supercharged_gfp.sh: the bodies and the five arrangements. INTERACTION=bare
# (default) or effective, SALTS and SWEEPS set the ladder. Stopped and called again, it goes on.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
stacks=$1 output=$2
protomer=${PROTOMER:-$here/../../target/release/protomer}
mkdir -p "$output"
seed=0
for arrangement in candidate_1 candidate_2 candidate_3 candidate_4 tilted; do
    # Each arrangement has fluids of its own.
    seed=$((seed + 1))
    "$protomer" sweep "$stacks/$arrangement.json" --salt "${SALTS:-40mM,50mM,65mM,80mM,100mM,150mM}" --starts both \
        --replicas 2 --sweeps "${SWEEPS:-6000}" --equilibration "${EQUILIBRATION:-2000}" --exchange-every 5 \
        --interaction "${INTERACTION:-bare}" --seed $seed --log-every 20 --trajectory-every 0 -j 1 -q --json \
        -o "$output/$arrangement" > "$output/$arrangement.json"
done
python3 "$here/gfp_equilibrium.py" "$output"
