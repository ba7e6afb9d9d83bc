#!/usr/bin/env bash
# Makes a release, on Linux with Rust, a C compiler, CPython 3.11 or newer, and pip.
#   bash release.sh 0.2.0                               for this machine
#   bash release.sh 0.2.0 aarch64-unknown-linux-gnu     and for other targets whose Rust standard library is installed
# Writes the version into the files that state it, and leaves in target/distribution/VERSION: wheels, the source
# distribution, the command with completions and man pages, the crates, the site, the conda recipe, the container file and
# checksums. Wheels are installed and tried; PYTHONS names the interpreters, RELEASE_TOOLS a folder that keeps the tools.
# Nothing is uploaded; the last lines say how.
set -euo pipefail
cd "$(dirname "$0")"
if [ $# -eq 0 ]; then
    echo "release.sh: give the version, such as 0.2.0, and targets other than this machine" >&2
    exit 2
fi
version=$1
host=$(rustc -vV | sed -n 's/^host: //p')
targets=("$host" "${@:2}")
build=$PWD/target
tools=${RELEASE_TOOLS:-$build/release-tools}
distribution=$build/distribution/$version
pythons=${PYTHONS:-python3}
export CARGO_TARGET_DIR=$build

say() {
    echo "release.sh: $*"
}

check_targets() {
    local target
    for target in "${targets[@]}"; do
        if [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; then
            say "there is no standard library for $target; rustup target add $target brings it" >&2
            exit 1
        fi
    done
}

install_tools() {
    if [ ! -x "$tools/bin/python" ]; then
        python3 -m venv "$tools"
    fi
    "$tools/bin/python" -m pip install --quiet --disable-pip-version-check -r release/requirements.txt
    export PATH=$tools/bin:$PATH
}

# Makes a wheel of the Python project in a folder. Zig links for a glibc that is older than that of this machine: 2.17
# (manylinux2014), the oldest that Rust supports.
make_wheel() {
    local target=$1 project=$2 folder=$3 system=()
    case $target in
    *-linux-gnu) system=(--zig --compatibility manylinux2014) ;;
    *-linux-musl) system=(--zig --compatibility musllinux_1_2) ;;
    esac
    (cd "$project" && maturin build --release --locked --target "$target" "${system[@]}" --out "$folder")
}

build_command() {
    local target=$1
    case $target in
    *-linux-gnu) cargo-zigbuild build --release --locked -p protomer-cli --target "$target.2.17" ;;
    *-linux-musl) cargo-zigbuild build --release --locked -p protomer-cli --target "$target" ;;
    *) cargo build --release --locked -p protomer-cli --target "$target" ;;
    esac
}

# The command with what belongs to it. Completions and man pages are those of the command for this machine.
pack_command() {
    local target=$1 name="protomer-$version-$1"
    local folder=$build/archives/$name command=$build/$host/release/protomer
    rm -rf "$folder"
    mkdir -p "$folder/completions" "$folder/man/man1"
    cp "$build/$target/release/protomer" README.md CHANGELOG.md CITATION.cff LICENSE-MIT LICENSE-APACHE "$folder"
    cp python/NOTICE-THIRD-PARTY "$folder"
    "$command" completions bash >"$folder/completions/protomer.bash"
    "$command" completions fish >"$folder/completions/protomer.fish"
    "$command" completions zsh >"$folder/completions/_protomer"
    "$command" man -o "$folder/man/man1" >"$build/man.log"
    tar --create --gzip --file "$distribution/$name.tar.gz" --owner 0 --group 0 --numeric-owner --sort name \
        --directory "$build/archives" "$name"
}

# The source distribution must make a wheel outside the project.
build_source_distribution() {
    local folder
    maturin sdist --manifest-path python/Cargo.toml --out "$distribution"
    folder=$(mktemp -d)
    tar --extract --file "$distribution/protomer-$version.tar.gz" --directory "$folder"
    make_wheel "$host" "$folder/protomer-$version" "$folder/wheels"
    rm -rf "$folder"
}

# Each crate is compiled from its package, as crates.io would give it.
package_crates() {
    rm -rf "$build/package"
    cargo publish --workspace --dry-run --locked --allow-dirty
    mkdir -p "$distribution/crates"
    find "$build/package" -name "protomer-*-$version.crate" -exec cp {} "$distribution/crates" \;
}

try_wheel() {
    local wheel
    wheel=$(ls "$distribution"/protomer-"$version"-cp310-abi3-*"${host%%-*}".whl)
    auditwheel show "$wheel"
    # shellcheck disable=SC2086 # several words
    bash tests/release/wheel.sh "$wheel" $pythons
}

# The site describes the module of the wheel.
build_site() {
    if [ ! -x .venv/bin/python ]; then
        python3 -m venv .venv
    fi
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --force-reinstall "$distribution"/protomer-*"${host%%-*}".whl
    bash docs/site.sh
    tar --create --gzip --file "$distribution/protomer-$version-site.tar.gz" --owner 0 --group 0 --numeric-owner \
        --sort name --directory "$build" site
}

# The recipe states the checksum of the source distribution.
write_recipes() {
    local sum
    sum=$(sha256sum "$distribution/protomer-$version.tar.gz" | cut -d ' ' -f 1)
    sed "s/^  sha256: .*/  sha256: $sum/" release/recipe.yaml >"$distribution/recipe.yaml"
    cp release/Containerfile "$distribution"
}

check_targets
install_tools
python3 release/version.py "$version"
cargo update --workspace --offline --quiet
rm -rf "$distribution"
mkdir -p "$distribution"
python3 release/third_party.py "$host" >python/NOTICE-THIRD-PARTY
for target in "${targets[@]}"; do
    make_wheel "$target" python "$distribution"
    build_command "$target"
    pack_command "$target"
done
try_wheel
build_source_distribution
package_crates
build_site
write_recipes
(cd "$distribution" && find . -type f ! -name SHA256SUMS -printf '%P\n' | sort | xargs sha256sum >SHA256SUMS)
ls -l "$distribution"
cat <<END
release.sh: version $version is in $distribution. To publish it:
  git commit --all --message "release: $version" && git tag v$version
  cargo publish --workspace --locked
  python3 -m twine upload $distribution/protomer-$version.tar.gz $distribution/*.whl
  and the archives, the crates and SHA256SUMS with the tag; recipe.yaml goes to conda-forge
END
