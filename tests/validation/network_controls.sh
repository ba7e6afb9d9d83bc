#!/usr/bin/env bash
# Every control of the network in its full form: what must be learnt is learnt, and nothing else is.
#
#   bash tests/validation/network_controls.sh [OUTPUT] [CONTROL...]
#
# OUTPUT (target/network-controls) gets a directory per control with its metrics.json; the levels are printed and judged.
# SHORT=1 runs the short forms. Interrupted, the same command goes on. Ends with an error if a level is missed.
set -euo pipefail
output=${1:-target/network-controls}
shift || true
controls=("$@")
if [ ${#controls[@]} -eq 0 ]; then
    controls=(shapes charge patch xor assemblies permuted identity orientation size heavy-tails)
fi
options=()
[ -z "${SHORT:-}" ] || options+=(--short)

cargo build --release --quiet -p protomer-cli
missed=0
for control in "${controls[@]}"; do
    report=$(target/release/protomer train --control "$control" ${options[@]+"${options[@]}"} -o "$output/$control") ||
        [ $? -eq 1 ] # A missed level, counted below.
    grep "^$control " <<<"$report"
    if grep -q "NOT AS EXPECTED" <<<"$report"; then
        missed=$((missed + 1))
    fi
done
if [ "$missed" -gt 0 ]; then
    echo "$missed controls missed a level" >&2
    exit 1
fi
