"""Prints the licence texts of all crates that a binary for a target holds, each text once.

    python3 release/third_party.py x86_64-unknown-linux-gnu
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NAMES = ("license", "licence", "copying", "notice", "unlicense", "copyright")
# The wheel and the command; both are linked from the same crates.
BINARIES = ("protomer-python", "protomer-cli")


def linked(metadata):
    """The packages that end up in the binaries: no tools of the build, no tests."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    waiting = [package["id"] for package in metadata["packages"] if package["name"] in BINARIES]
    reached = set()
    while waiting:
        place = waiting.pop()
        if place in reached:
            continue
        reached.add(place)
        for dependency in nodes[place]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    packages = [package for package in metadata["packages"] if package["id"] in reached and package["source"]]
    return sorted(packages, key=lambda package: (package["name"], package["version"]))


def texts(package):
    """The licence files of a package."""
    folder = Path(package["manifest_path"]).parent
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name.lower().startswith(NAMES))
    return [path.read_text(errors="replace").strip() for path in files if path.suffix not in (".rs", ".c", ".h")]


def main():
    """Prints the list of crates and the texts."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", sys.argv[1]]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    packages = linked(metadata)
    print("protomer is linked with the crates below. Their licence texts follow the list.\n")
    owners = {}
    for package in packages:
        label = f"{package['name']} {package['version']}"
        print(f"{label}: {package['license']}")
        for text in texts(package):
            owners.setdefault(text, []).append(label)
    for text, labels in owners.items():
        print(f"\n{'=' * 80}\n{', '.join(dict.fromkeys(labels))}\n\n{text}")


if __name__ == "__main__":
    main()
