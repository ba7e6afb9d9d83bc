#!/usr/bin/env bash
# From a structure file to a stability curve, on bundled input: two supercharged variants of BPTI, two stacked rings of
# four, radius of gyration and surviving contacts against salt. Leaves demo-output/sweep/sweep.png. The same command
# continues a demo that was stopped. PROTOMER=protomer takes an installed command instead of building one.
set -euo pipefail
cd "$(dirname "$0")"
protomer=${PROTOMER:-target/release/protomer}

step() {
    echo "\$ $*"
    "$@"
}

if [ -z "${PROTOMER:-}" ]; then
    step cargo build --release --locked
fi
# BPTI has a net charge of +6 at pH 7.4. Acidic residues exchanged for lysine make it +14, basic ones for glutamate -12.
step $protomer ingest data/structures/5pti.cif.gz -o demo-output --name plus \
    --mutate A:D3K,A:E7K,A:E49K,A:D50K
step $protomer ingest data/structures/5pti.cif.gz -o demo-output --name minus \
    --mutate A:R1E,A:K15E,A:R17E,A:K26E,A:R39E,A:K41E,A:R42E,A:K46E,A:R53E
step $protomer assemble ring demo-output/plus.body demo-output/minus.body \
    --members 4 --stack 2 --box 400 -o demo-output/stack.json
step $protomer inspect demo-output/stack.json --salt 100mM
step $protomer sweep demo-output/stack.json --salt 10mM..200mM/6 --replicas 3 \
    --sweeps 800 --equilibration 200 -o demo-output/sweep
echo "The curve: demo-output/sweep/sweep.png (and .svg); the numbers: demo-output/sweep/sweep.csv"
