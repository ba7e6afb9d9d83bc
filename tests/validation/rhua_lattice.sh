#!/usr/bin/env bash
# The figures of the two papers on the lattice of rigid squares (coarse-grained RhuA crystals), computed anew and drawn.
#
#   bash tests/validation/rhua_lattice.sh [OUTPUT]
#
# OUTPUT (docs/validation/rhua-lattice) gets tables (*.csv) and pictures (*.svg). About five minutes on one core; JOBS
# threads give the same numbers. FULL=1 takes as many trajectories as the papers everywhere. DRAW=1 only draws.
set -euo pipefail
output=${1:-docs/validation/rhua-lattice}
here=$(dirname "$0")
venv=${VENV:-target/rhua-lattice-venv}
options=(--jobs "${JOBS:-1}")
[ -z "${FULL:-}" ] || options+=(--full)

if [ -z "${DRAW:-}" ]; then
    cargo run --release --quiet -p protomer-crystal --example paper_figures -- "$output" "${options[@]}"
fi
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check numpy matplotlib
fi
"$venv/bin/python" "$here/rhua_lattice.py" "$output"
