#!/usr/bin/env bash
# Every check of the project on a machine with Rust, a C compiler and CPython 3.11 with pip.
#   bash test.sh            everything
#   bash test.sh rust       format, lints, documentation and Rust tests only
#   bash test.sh python     the Python package, and checks against other programs, only
set -euo pipefail
cd "$(dirname "$0")"

rust_checks() {
    cargo fmt --all --check
    cargo clippy --workspace --all-targets --locked -- -D warnings
    # The command line without networks and voxel sets, for those who do not need them.
    cargo clippy -p protomer-cli --no-default-features --locked -- -D warnings
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked
    cargo test --workspace --locked
}

install_requirements() {
    if [ ! -x .venv/bin/python ]; then
        python3 -m venv .venv
    fi
    # Modules are compiled when they are first imported, which most of these never are.
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-compile \
        -r python/checks/requirements.txt -r docs/requirements.txt
}

python_checks() {
    install_requirements
    # The package brings the command that the checks run. It shares the build of the Rust tests.
    CARGO_TARGET_DIR="$PWD/target" .venv/bin/python -m pip install --quiet --disable-pip-version-check \
        --config-settings=build-args=--profile=dev ./python
    # The Rust checks have built target/doc; without them the site builds it.
    if [ -e target/doc/protomer/index.html ]; then
        bash docs/site.sh --no-rust
    else
        bash docs/site.sh
    fi
    .venv/bin/python -m mypy --config-file python/pyproject.toml
    .venv/bin/python -m pytest -q -rs -n 2 python/tests
    .venv/bin/python -m pytest -q -rs -n 2 python/checks
}

case "${1:-all}" in
rust) rust_checks ;;
python) python_checks ;;
all)
    # Downloads come in while the compiler works.
    install_requirements &
    downloads=$!
    # Not joined by &&: within such a list an error would not end the first function.
    rust_checks
    wait "$downloads"
    python_checks
    ;;
*) echo "test.sh: '$1' is not one of: rust, python" >&2 && exit 2 ;;
esac
