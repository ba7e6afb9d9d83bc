#!/usr/bin/env bash
# Eight GFPs of +33 e and eight of -17 e, started from a dilute random fluid: how far do they assemble at which salt
# concentration, and into what? The same bodies started from a closed stack of two rings say what there is to reach.
#
#   bash tests/validation/assembly_from_fluid.sh STRUCTURE OUTPUT
#
# STRUCTURE is GFP, PDB entry 1EMA (protomer fetch 1EMA). One core; stopped and called again, it continues, and
# with more SWEEPS it runs on. REPLICAS and NATIVE_REPLICAS are the numbers of runs at each of the SALTS.
set -euo pipefail
structure=$1 output=$2
sweeps=${SWEEPS:-1000} replicas=${REPLICAS:-3} native_replicas=${NATIVE_REPLICAS:-1}
here=$(dirname "$0")
protomer=${PROTOMER:-target/release/protomer}
# The residues of tests/validation/supercharged_gfp.sh: the most exposed charged ones.
plus=A:D190K,A:D76K,A:D102K,A:D117K,A:D133K,A:D129K,A:D173K,A:E172K,A:E115K,A:D197K,A:E32K,A:E34K,A:D155K,A:D210K
plus+=,A:D21K,A:E142K,A:D19K,A:E95K,A:E213K
minus=A:R80E,A:R109E,A:K41E,A:K126E,A:K166E,A:R215E

if [ ! -e "$output/tilted.json" ]; then
    $protomer ingest "$structure" --core surface -q -o "$output" --name plus --charges formal --mutate $plus
    $protomer ingest "$structure" --core surface -q -o "$output" --name minus --charges formal --mutate $minus
    $protomer candidates "$output/plus.body" "$output/minus.body" --ring 8 --stack 2 --box 500 -o "$output"
    $protomer assemble ring "$output/plus.body" "$output/minus.body" --members 8 --stack 2 --tilt 40,0 --box 500 \
        -o "$output/tilted.json"
fi

# start ASSEMBLY FOLDER SALT REPLICA: one run, the user CPU seconds of each call noted beside its results.
start() {
    local folder=$output/$2/$3/replica_$4 status=0
    [ "$(cat "$folder/sweeps" 2>/dev/null || true)" != "$sweeps" ] || return 0
    TIMEFORMAT=%U
    { time $protomer simulate "$1" --salt "$3" --seed "$4" --sweeps "$sweeps" --equilibration 500 --cluster-moves 4 \
        --log-every 1000 --trajectory-every 5000 -j 1 -q -o "$folder" 2>"$output/messages"; } \
        2>"$output/cpu_seconds" || status=$?
    cat "$output/cpu_seconds" >>"$folder/cpu_seconds"
    if [ "$status" -ne 0 ]; then
        cat "$output/messages" >&2
        return "$status"
    fi
    echo "$sweeps" >"$folder/sweeps"
    echo "$2 $3 replica $4: $(cat "$output/cpu_seconds") CPU-seconds"
}

salts=${SALTS:-10mM 50mM 100mM 300mM}
for replica in $(seq "$replicas"); do
    fluid=$output/fluid_$replica.json
    [ -e "$fluid" ] || $protomer assemble fluid "$output/plus.body" "$output/minus.body" --counts 8,8 --box 500 \
        --seed "$replica" -o "$fluid"
    for salt in $salts; do start "$fluid" fluid "$salt" "$replica"; done
done
for replica in $(seq "$native_replicas"); do
    for salt in $salts; do start "$output/candidate_3.json" native "$salt" "$replica"; done
done

if [ ! -x "$output/venv/bin/python" ]; then
    python3 -m venv "$output/venv"
    "$output/venv/bin/python" -m pip install --quiet --disable-pip-version-check gsd numpy scipy matplotlib
fi
"$output/venv/bin/python" "$here/assembly_from_fluid.py" "$output"
