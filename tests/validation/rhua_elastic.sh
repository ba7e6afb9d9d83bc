#!/usr/bin/env bash
# Poisson's ratio of lattices of rigid squares in a heat bath, by the response to a load and by fluctuation.
#
#   bash tests/validation/rhua_elastic.sh PROTOMER OUTPUT
#
# 4 x 4 squares at kT = 0.1 under stresses of -0.02, 0 and 0.02 along x, for rods of 2 % to 2 half-diagonals; a JSON file for each
# length, and a table. About ten minutes on one core; JOBS runs side by side, TIME shortens all.
set -euo pipefail
protomer=$1 output=$2
mkdir -p "$output"
runs() {
    for r0 in 0.02 0.05 0.13636363636363635 0.35 0.5 1 2; do
        case $r0 in
            0.02) time=${TIME:-400} ;;
            0.05) time=${TIME:-1500} ;;
            *) time=${TIME:-3000} ;;
        esac
        for stress in -0.02 0 0.02; do
            echo "$r0 $stress $time"
        done
    done
}
one() {
    "$1" lattice run -q -o "$2/r${3}_s$4" --ns 4 --r0 "$3" --velocities thermal --temperature 0.1 --friction 0.3 \
        --time "$5" --log-every 20 --trajectory-every 0 --stress-xx "$4" --seed 1
}
export -f one
runs | xargs -P "${JOBS:-1}" -L 1 bash -c 'one "$0" "$1" "$2" "$3" "$4"' "$protomer" "$output"
for r0 in 0.02 0.05 0.13636363636363635 0.35 0.5 1 2; do
    "$protomer" lattice elastic "$output/r${r0}_s-0.02" "$output/r${r0}_s0" "$output/r${r0}_s0.02" --json >"$output/$r0.json"
    "$protomer" lattice elastic "$output/r${r0}_s-0.02" "$output/r${r0}_s0" "$output/r${r0}_s0.02" | tail -1
done
