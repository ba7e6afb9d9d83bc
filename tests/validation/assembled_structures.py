#!/usr/bin/env python3
"""How well `assemble structure --relax` keeps the contacts of crystal structures.

usage: python3 tests/validation/assembled_structures.py PROTOMER FOLDER [-- FLAGS ...]

FOLDER holds structure files. Each is assembled (first biological assembly, where the file describes one) with the given
flags in addition; entries of one body or without contacts between bodies are left out. Prints a line per entry and the summary:
entries with 95 % of their native residue contacts left and no body moved by more than 1 Å.
"""
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LEAST_KEPT, MOST_MOVED = 0.95, 1.0


def assembled(protomer, file, flags):
    """The answer of `assemble structure`, or what it said instead."""
    said = ""
    for assembly in (["--assembly", "1"], []):
        with tempfile.TemporaryDirectory() as folder:
            command = [protomer, "assemble", "structure", file, *assembly, "--relax", "-o", folder, "--json", "-q", *flags]
            try:
                done = subprocess.run(command, capture_output=True, text=True, timeout=1800)
            except subprocess.TimeoutExpired:
                return None, "more than half an hour"
        if done.returncode == 0:
            return json.loads(done.stdout), None
        said = done.stderr.strip().splitlines()[-1]
        if "no biological assembly" not in said:
            break
    return None, said


def main():
    protomer, folder, *rest = sys.argv[1:]
    flags, good, seen, failed = rest[1:], 0, 0, []
    for file in sorted(Path(folder).glob("*.gz")):
        begin = time.time()
        answer, error = assembled(protomer, file, flags)
        if error:
            failed.append(file.name)
            print(f"{file.name:16} {error[:150]}", flush=True)
            continue
        if len(answer["placed"]) < 2 or not answer["native_contacts"]:
            continue
        seen += 1
        moved, kept = max(answer["moved_angstrom"]), answer["native_contacts_kept"]
        is_good = kept >= LEAST_KEPT and moved <= MOST_MOVED
        good += is_good
        print(f"{file.name:16} {len(answer['placed']):4} bodies, {len(answer['overlaps']):4} overlapped, {len(answer['own_shapes']):3} own "
              f"shapes, moved {moved:6.2f} Å, {100 * kept:6.2f} % of {answer['native_contacts']} contacts, "
              f"{time.time() - begin:.0f} s{'' if is_good else '  <--'}", flush=True)
    print(f"{good} of {seen} entries keep {LEAST_KEPT:.0%} of their contacts and move no body by more than {MOST_MOVED} Å; "
          f"{len(failed)} could not be assembled")


if __name__ == "__main__":
    main()
