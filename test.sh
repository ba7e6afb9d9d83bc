#!/usr/bin/env bash
# Every check of the project on a machine with Rust, a C compiler and CPython 3.11 with pip.
#   bash test.sh            everything
#   bash test.sh rust       format, lints, documentation and Rust tests only
#   bash test.sh python     the Python package, and checks against other programs, only
set -euo pipefail
cd "$(dirname "$0")"
# Most of the time goes into compiling once: no records for a next time, no line numbers for a debugger.
export CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_DEBUG=false
# Energy tables, kept from test to test but not from call to call.
if [ -z "${PROTOMER_TEST_CACHE_DIR:-}" ]; then
    PROTOMER_TEST_CACHE_DIR=$(mktemp -d)
    export PROTOMER_TEST_CACHE_DIR
    trap 'rm -rf "$PROTOMER_TEST_CACHE_DIR"' EXIT
fi

lints() {
    cargo fmt --all --check
    cargo clippy --workspace --all-targets --locked -- -D warnings
    # The command line without networks and voxel sets, for those who do not need them. Dependencies
    # have the features that they have above, so only our own crates are checked once more.
    cargo clippy --workspace --no-default-features --locked -- -D warnings
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked
}

# Examples are compiled by clippy; nothing is gained by building them.
rust_tests() {
    cargo test --workspace --locked --lib --bins --tests "$@"
}

# The integration tests of the command line take as long as all other Rust tests.
command_line_tests() {
    cargo test --workspace --locked $(test_names crates/front/cli)
}

other_rust_tests() {
    cargo test --workspace --locked --lib --bins $(test_names $(ls -d crates/*/* | grep -v '/cli$'))
    data_tests
    documentation_tests
}

# The integration tests of crates as --test options, one for all tests of a name: with packages as
# options instead, dependencies would have other features and be compiled again.
test_names() {
    local crate test
    for crate in "$@"; do
        for test in "$crate"/tests/*.rs "$crate"/tests/*/main.rs; do
            case $test in
            *'*'*) ;;
            */main.rs) echo "--test $(basename "$(dirname "$test")")" ;;
            *) echo "--test $(basename "$test" .rs)" ;;
            esac
        done
    done | sort -u
}

documentation_tests() {
    cargo test --workspace --locked --doc
}

# Tests of data that are not part of the repository, by the names that stand below their marks. Without the data they
# are ignored.
data_tests() {
    local names
    if [ -z "${PROTOMER_TEST_DATA:-}" ]; then
        echo "test.sh: tests that need PROTOMER_TEST_DATA are ignored"
        return
    fi
    mapfile -t names < <(grep -rhA1 '#\[ignore = "needs PROTOMER_TEST_DATA' crates --include='*.rs' |
        sed -n 's/^ *fn \([a-z0-9_]*\)(.*/\1/p')
    cargo test --workspace --locked --lib --tests -- --ignored "${names[@]}"
}

install_requirements() {
    if [ ! -x .venv/bin/python ]; then
        python3 -m venv .venv
    fi
    # Modules are compiled when they are first imported, which most of these never are.
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-compile \
        -r python/checks/requirements.txt -r docs/requirements.txt
}

install_package() {
    # The package brings the command that the checks run. It shares the build of the Rust tests.
    CARGO_TARGET_DIR="$PWD/target" .venv/bin/python -m pip install --quiet --disable-pip-version-check \
        --config-settings=build-args=--profile=dev ./python
}

python_tests() {
    # The lints have built target/doc; without them the site builds it.
    if [ -e target/doc/protomer_protein_verbs/index.html ]; then
        bash docs/site.sh --no-rust
    else
        bash docs/site.sh
    fi
    .venv/bin/python -m mypy --config-file python/pyproject.toml
    # The tests of a file share what its fixtures made.
    .venv/bin/python -m pytest -q -rs -n 2 --dist loadfile python/tests
    .venv/bin/python -m pytest -q -rs -n 2 --dist loadfile python/checks
}

# Each kind of test leaves a processor idle now and then, so they run side by side, each in a shell of
# its own: an error would not end a function that is followed by ||.
all_tests() {
    local kind failed=0
    declare -A running
    for kind in command-line other-rust python; do
        bash test.sh "$kind-tests" >"target/$kind-tests.log" 2>&1 &
        running[$kind]=$!
    done
    for kind in "${!running[@]}"; do
        if wait "${running[$kind]}"; then
            running[$kind]=passed
        else
            running[$kind]=failed
            failed=1
        fi
        cat "target/$kind-tests.log"
    done
    for kind in "${!running[@]}"; do
        echo "test.sh: $kind tests ${running[$kind]}"
    done
    return $failed
}

case "${1:-all}" in
rust)
    lints
    rust_tests
    data_tests
    documentation_tests
    ;;
python)
    install_requirements
    install_package
    python_tests
    ;;
command-line-tests) command_line_tests ;;
other-rust-tests) other_rust_tests ;;
python-tests) python_tests ;;
all)
    # Downloads come in while the compiler works.
    install_requirements &
    downloads=$!
    lints
    rust_tests --no-run
    wait "$downloads"
    install_package
    all_tests
    ;;
*) echo "test.sh: '$1' is not one of: rust, python" >&2 && exit 2 ;;
esac
