#!/usr/bin/env bash
# Poisson's ratio of 6 x 6 rigid squares in a heat bath, by the response to a load and by fluctuation, from independent runs.
#
#   bash tests/validation/rhua_elastic_seeds.sh PROTOMER OUTPUT
#
# Rods of 3/22 half-diagonals, kT = 0.1, stresses of -0.01, 0 and 0.01 along x, ten seeds; a line for each seed, and one for all runs
# together. About half an hour on one core.
# JOBS runs side by side; SIZE, R0, TIME, SEEDS and STRESSES change what is run.
set -euo pipefail
protomer=$1 output=$2
size=${SIZE:-6} r0=${R0:-0.13636363636363635} time=${TIME:-3000} seeds=${SEEDS:-11 12 13 14 15 16 17 18 19 20} stresses=${STRESSES:--0.01 0 0.01}
mkdir -p "$output"
one() {
    "$1" lattice run -q -j 1 -o "$2/seed$6_s$7" --ns "$3" --r0 "$4" --velocities thermal --temperature 0.1 --friction 0.3 \
        --time "$5" --log-every 20 --trajectory-every 0 --stress-xx "$7" --seed "$6"
}
export -f one
for seed in $seeds; do
    for stress in $stresses; do
        echo "$seed $stress"
    done
done | xargs -P "${JOBS:-1}" -L 1 bash -c 'one "$0" "$1" "$2" "$3" "$4" "$5" "$6"' "$protomer" "$output" "$size" "$r0" "$time"
for seed in $seeds; do
    "$protomer" lattice elastic "$output/seed${seed}_s"* | tail -1
done
"$protomer" lattice elastic "$output"/seed* --json >"$output/all.json"
"$protomer" lattice elastic "$output"/seed* | tail -1
