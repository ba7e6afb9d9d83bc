"""Writes the version of a release, and its date, into every file that states them.

    python3 release/version.py 0.2.0

Called again with the same version it changes nothing. `crates/front/cli/tests/workspace.rs` checks that the files agree.
"""

import datetime
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def substitute(name, pattern, replacement):
    """Replaces each match in a file; a file without one has another form than this script knows."""
    path = ROOT / name
    text, matches = re.subn(pattern, replacement, path.read_text(), flags=re.MULTILINE)
    if not matches:
        sys.exit(f"release/version.py: {name} has no line of the form {pattern!r}")
    path.write_text(text)


def today():
    """Date of the release, as SOURCE_DATE_EPOCH or the clock has it."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH")
    moment = datetime.datetime.fromtimestamp(int(seconds), datetime.UTC) if seconds else datetime.datetime.now(datetime.UTC)
    return moment.date().isoformat()


def cut_changelog(version):
    """Moves what is unreleased below a heading of the version; returns its date."""
    path = ROOT / "CHANGELOG.md"
    text = path.read_text()
    dated = re.search(rf"^## \[{re.escape(version)}\] - (\S+)$", text, re.MULTILINE)
    if dated:
        return dated[1]
    unreleased = re.search(r"^## \[Unreleased\]\n(.*?)(?=^## \[|\Z)", text, re.MULTILINE | re.DOTALL)
    if not unreleased or not unreleased[1].strip():
        sys.exit("release/version.py: CHANGELOG.md has nothing below [Unreleased]; say what the release brings")
    date = today()
    heading = f"## [Unreleased]\n\n## [{version}] - {date}\n"
    path.write_text(text.replace("## [Unreleased]\n", heading, 1))
    return date


def main():
    """Writes the version that the command line states."""
    if len(sys.argv) != 2 or not re.fullmatch(r"\d+\.\d+\.\d+", sys.argv[1]):
        sys.exit("release/version.py: give a version such as 0.2.0")
    version = sys.argv[1]
    date = cut_changelog(version)
    substitute("Cargo.toml", r'^version = ".*"$', f'version = "{version}"')
    substitute("Cargo.toml", r'^(protomer-\S+ = \{ path = "\S+", version = )"[^"]*"', rf'\1"{version}"')
    substitute("CITATION.cff", r"^version: .*(\ndate-released: .*)?$", f"version: {version}\ndate-released: {date}")
    substitute("release/recipe.yaml", r'^  version: "[^"]*"$', f'  version: "{version}"')


if __name__ == "__main__":
    main()
