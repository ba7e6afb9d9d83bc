#!/usr/bin/env bash
# The scan of `residues --mutations` beside the mutants simulated anew: two bodies made from BPTI in a box.
#
#     bash tests/validation/mutation_scan.sh OUTPUT
#
# Prints the table of docs/validation/mutation-scan.md. PROTOMER names another program, SWEEPS another length, CORE (default:
# surface) what is hard, INTERACTION (default: bare) what the inside of the bodies does to the charges, and BOX the edge of the
# box, Å (default: 100, too small for response).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
protomer=${PROTOMER:-$here/../../target/release/protomer}
structure=$here/../../data/structures/5pti.cif.gz
sweeps=${SWEEPS:-5000} core=${CORE:-surface} interaction=${INTERACTION:-bare} box=${BOX:-100}
mkdir -p "$1"
cd "$1"
minus=A:R17E,A:K26E,A:R39E,A:K41E,A:R42E,A:K46E,A:R53E
ingest() { # name, mutations
    "$protomer" ingest -q --force --core "$core" "$structure" -o . --name "$1" --charges formal --density 1 --mutate "$2"
}
sweep() { # name, seed, further flags
    "$protomer" sweep "$1.json" --salt 30mM,60mM,120mM --replicas 4 --starts both --exchange-every 10 \
        --equilibration 200 --sweeps "$sweeps" --seed "$2" --energy direct --interaction "$interaction" --force -q -o "$1" "${@:3}" --json > "$1.sweep.json"
}
ingest plus A:D3K,A:E49K
ingest unchanged $minus
ingest E17Q A:R17Q,A:K26E,A:R39E,A:K41E,A:R42E,A:K46E,A:R53E
ingest D50N $minus,A:D50N
ingest K15E $minus,A:K15E
seed=1
for name in unchanged E17Q D50N K15E; do
    "$protomer" assemble ring plus.body $name.body --members 2 --box "$box" -o $name.json --force -q
    sweep $name $seed --trajectory-every 20
    seed=$((seed + 1))
done
"$protomer" residues unchanged --mutations --salt 30mM --frames 100000 --force --json -q > scan.json
python3 "$here/mutation_scan.py"
