#!/usr/bin/env bash
# The figures of the two papers on the lattice of rigid squares (coarse-grained RhuA crystals), computed anew and drawn.
#
#   bash tests/validation/rhua_lattice.sh [OUTPUT]
#
# OUTPUT (docs/validation/rhua-lattice) gets tables (*.csv) and pictures (*.svg). About eight minutes on one core; JOBS
# threads give the same numbers. FULL=1 takes as many trajectories as the papers everywhere. DRAW=1 only draws.
set -euo pipefail
output=${1:-docs/validation/rhua-lattice}
here=$(dirname "$0")
venv=${VENV:-target/rhua-lattice-venv}
sweeps=${SWEEPS:-target/rhua-lattice-sweeps}
jobs=${JOBS:-1}
options=(--jobs "$jobs")
small=16
if [ -n "${FULL:-}" ]; then
    options+=(--full)
    small=100
fi
mkdir -p "$sweeps"
third=0.13636363636363635 # 3/22

# A sweep of 2 x 2 squares; the same command continues it.
sweep() {
    local name=$1
    shift
    target/release/protomer lattice sweep -q -j "$jobs" -o "$sweeps/$name" --ns 2 --trajectory-every 0 "$@"
}

if [ -z "${DRAW:-}" ]; then
    cargo build --release --quiet -p protomer-cli
    cargo run --release --quiet -p protomer-linkage --example paper_figures -- "$output" "${options[@]}"
    # Paper, figure 8: near the coherent orbit, with collisions and without, and along the orbit itself.
    lengths=0.05,0.1,$third,0.25,0.5,0.75,1,1.5,2
    near=(--r0-list "$lengths" --seeds 4 --angle-spread 0.01 --velocity-spread 0.01 --time 10 --lyapunov)
    sweep lyapunov "${near[@]}" --lyapunov-intervals 180
    sweep lyapunov_free "${near[@]}" --lyapunov-intervals 180 --no-collisions
    printf '[sweep.lyapunov]\ninterval = 0.1\ndiscarded = 0\nintervals = 15\n' >"$sweeps/growth.toml"
    sweep lyapunov_growth "$sweeps/growth.toml" --r0-list "$lengths" --seeds 8 --time 1.5 --no-collisions
    # Paper, figure 7: disorder of angles and spins.
    for angles in 0 0.01 0.1; do
        for spins in 0 0.001 0.01 0.1 0.3 1; do
            sweep "checkerboard_${angles}_$spins" --r0-list "0.05,$third,0.5,1,2" --seeds "$small" --time 30 --log-every 5 \
                --angle-spread "$angles" --velocity-spread "$spins"
        done
    done
fi
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check numpy matplotlib
fi
"$venv/bin/python" "$here/rhua_lattice.py" "$output" "$sweeps"
