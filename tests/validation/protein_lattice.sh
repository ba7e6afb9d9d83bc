#!/usr/bin/env bash
# From a structure with a four-fold axis and a salt concentration to the open fraction and Poisson's ratio of its crystal.
#
#   bash tests/validation/protein_lattice.sh PROTOMER STRUCTURE CHAIN OUTPUT
#
# The structure is taken with its first assembly and one chain, as 1NCB with chain N (neuraminidase). Each joint of the
# lattice has the potential of mean force of two tied bodies at this salt; 4 x 4 squares move in a heat bath. SALTS, ROD,
# TIME, SEEDS and FACING (--turned-over) change what is run. Half an hour on one core.
set -euo pipefail
protomer=$1 structure=$2 chain=$3 output=$4
salts=${SALTS:-5mM 20mM 100mM}
rod=${ROD:-8A}
time=${TIME:-1500}
seeds=${SEEDS:-1 2 3 4}
mkdir -p "$output"
cd "$output"
[ -d bodies ] || "$protomer" ingest -q "$structure" --assembly 1 --chain "$chain" -o bodies
body=$(echo bodies/*.body)
run() {
    local name=$1
    shift
    for seed in $seeds; do
        "$protomer" lattice run -q square.toml -o "$name/seed_$seed" --ns 4 --velocities thermal --temperature 0.1 \
            --friction 0.3 --time "$time" --log-every 50 --trajectory-every 0 --seed "$seed" "$@"
    done
}
"$protomer" lattice square -q --force "$body" -o whole.toml 2>/dev/null
# The joint stands for the charges: the size and the inertia are left.
awk '/^\[/ { in_charges = /charges/ } !in_charges' whole.toml >square.toml
for salt in $salts; do
    [ -f "joint_$salt.csv" ] || "$protomer" lattice joint "$body" --salt "$salt" --rod "$rod" ${FACING:-} \
        -o "joint_$salt.csv" --json >"joint_$salt.json"
done
r0=$(grep -ho '"r0": *[0-9.]*' joint_*.json | head -1 | grep -o '[0-9.]*$')
run hard --r0 "$r0"
for salt in $salts; do
    run "$salt" --r0 "$r0" --angle-potential "joint_$salt.csv"
done
for name in hard $salts; do
    "$protomer" lattice elastic "$name"/seed_* --json >"elastic_$name.json"
done
python3 - hard $salts <<'PYTHON'
import csv, json, math, pathlib, sys

def mean(values):
    centre = sum(values) / len(values)
    return centre, math.sqrt(sum((v - centre) ** 2 for v in values) / (len(values) * (len(values) - 1)))

print("joint,open_fraction,error,opening_deg,error,poisson_ratio_xy,error")
for name in sys.argv[1:]:
    fractions, openings = [], []
    for run in sorted(pathlib.Path(name).glob("seed_*")):
        rows = list(csv.DictReader((run / "log.csv").open()))
        rows = rows[len(rows) // 10:]
        # The distance from the open state, whatever side the lattice closes to.
        away = [abs(math.degrees(float(row["checkerboard"])) - 45) for row in rows]
        fractions.append(sum(a < 15 for a in away) / len(away))
        openings.append(45 - sum(away) / len(away))
    runs = json.loads(pathlib.Path(f"elastic_{name}.json").read_text())["runs"]
    ratios = [run["poisson_ratio_xy"]["value"] for run in runs]
    numbers = [*mean(fractions), *mean(openings), *mean(ratios)]
    print(name, *(f"{number:.4f}" for number in numbers), sep=",")
PYTHON
