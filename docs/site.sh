#!/usr/bin/env bash
# Builds the documentation as a site in target/site: the pages of docs, the Rust API and the Python API.
#   bash docs/site.sh              everything; needs Rust, and CPython 3.11 with pip
#   bash docs/site.sh --no-rust    the Rust API as it is in target/doc
# A link that leads nowhere is an error. The Python package is installed in .venv if it is not there yet.
set -euo pipefail
cd "$(dirname "$0")/.."
pages=target/site-pages
python=.venv/bin/python

install_tools() {
    if [ ! -x $python ]; then
        python3 -m venv .venv
    fi
    $python -m pip install --quiet --disable-pip-version-check -r docs/requirements.txt
    if ! $python -c "import protomer" 2>/dev/null; then
        CARGO_TARGET_DIR="$PWD/target" $python -m pip install --quiet --disable-pip-version-check ./python
    fi
}

# The pages keep their places in the project, so that links between them work in both.
gather_pages() {
    rm -rf $pages target/site
    mkdir -p $pages/data/structures $pages/notebooks $pages/python $pages/api/rust
    cp -R README.md ARCHITECTURE.md CONTRIBUTING.md CHANGELOG.md docs $pages
    cp data/structures/PROVENANCE.md $pages/data/structures
    cp python/README.md $pages/python
    cp notebooks/*.ipynb $pages/notebooks
    cp docs/api.html $pages/api/rust/index.html
    # MkDocs knows no second word after the language of a block.
    sed -i 's/^```console approximate$/```console/' $pages/docs/*/*.md
    cat > $pages/api.md <<'API'
# Programming interfaces

* [Rust](api/rust/index.html): every crate of the workspace.
* [Python](api/python/index.html): the module `protomer`.
API
}

case "${1:-}" in
"") RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked ;;
--no-rust) ;;
*) echo "docs/site.sh: '$1' is not an option; there is only --no-rust" >&2 && exit 2 ;;
esac
if [ ! -e target/doc/protomer_protein_verbs/index.html ]; then
    echo "docs/site.sh: target/doc is missing; leave out --no-rust" >&2 && exit 1
fi
install_tools
gather_pages
$python -m pdoc protomer --output-directory $pages/api/python
NO_MKDOCS_2_WARNING=1 $python -m mkdocs build --strict
cp -R target/doc/. target/site/api/rust
cp docs/api.html target/site/api/rust/index.html
echo "The site: target/site/index.html"
