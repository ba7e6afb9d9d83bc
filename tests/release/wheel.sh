#!/usr/bin/env bash
# Installs a wheel in bare virtual environments, with no Rust and no compiler on the path, and has each make the first
# result of the README.
#   bash tests/release/wheel.sh WHEEL [PYTHON ...]      interpreters; python3 unless others are named
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
if [ $# -eq 0 ]; then
    echo "wheel.sh: give the wheel" >&2
    exit 2
fi
wheel=$(realpath "$1")
shift
if [ $# -eq 0 ]; then
    set -- python3
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for python in "$@"; do
    environment=$work/$(basename "$python")-environment
    "$python" -m venv "$environment"
    # Nothing of this machine but the environment is left on the path.
    bare=(env -i "PATH=$environment/bin" "HOME=$work" "PROTOMER_CACHE_DIR=$work/cache")
    "${bare[@]}" python -m pip install --quiet --disable-pip-version-check --only-binary :all: "$wheel"
    "${bare[@]}" python -m pip check --disable-pip-version-check
    "${bare[@]}" python "$root/tests/release/first_result.py" "$root"
    rm -rf "$environment"
done
