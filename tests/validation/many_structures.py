#!/usr/bin/env python3
"""Ten thousand small structures as a stream: memory that does not grow, and what is left of runs that were killed.

    python3 tests/validation/many_structures.py OUTPUT [COUNT]

Cuts COUNT different pieces of a few residues out of a bundled protein, moves their atoms by a few hundredths of an Å,
and gives them to `ingest --stream` and to `voxelize`: a tenth of them, all of them, and all of them again with the program
killed (SIGKILL) several times on the way and started again. Prints peak memory, processor time and structures per second,
and fails if the folder of the killed runs differs from the other in a byte, or if memory grows by more than a tenth.
PROTOMER names another program, KILLS another number of kills, VERBS one of the two verbs.
"""

import gzip
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("PROTOMER", str(ROOT / "target/release/protomer"))
SOURCE = ROOT / "data/structures/4e43.pdb.gz"
RESIDUES = 2
LARGEST_GROWTH = 1.1
SECONDS_BETWEEN_LOOKS = 0.05
# Peaks are those of what the program holds: glibc would keep some MB of what it has freed, more in some runs than in others.
WITHOUT_LEFTOVERS = os.environ | {"GLIBC_TUNABLES": "glibc.malloc.mmap_threshold=131072"}


def pieces_of_the_protein():
    """The ATOM records of the first chain, residue by residue."""
    residues = {}
    with gzip.open(SOURCE, "rt") as lines:
        for line in lines:
            if line.startswith("ATOM") and line[21] == "A" and line[16] in " A":
                residues.setdefault(line[22:27], []).append(line)
    return list(residues.values())


def write_structures(folder, count):
    """COUNT structures in a folder and a manifest that names the first tenth of them and one that names all."""
    folder.mkdir(parents=True)
    residues = pieces_of_the_protein()
    draw = random.Random(1)
    for number in range(count):
        first = number % (len(residues) - RESIDUES)
        lines = []
        for line in sum(residues[first : first + RESIDUES], []):
            x, y, z = (float(line[at : at + 8]) + draw.gauss(0.0, 0.03) for at in (30, 38, 46))
            lines.append(f"{line[:16]} {line[17:30]}{x:8.3f}{y:8.3f}{z:8.3f}{line[54:]}")
        lines += ["TER\n", "END\n"]
        (folder / f"piece{number:05d}.pdb").write_text("".join(lines))
    for name, share in (("tenth", count // 10), ("all", count)):
        rows = [f"{folder.name}/piece{n:05d}.pdb,{'AB'[n % 2]},{n // 10}" for n in range(share)]
        (folder.parent / f"{name}.csv").write_text("\n".join(["file,label,cluster", *rows]) + "\n")
        paths = [f"{folder.name}/piece{n:05d}.pdb" for n in range(share)]
        (folder.parent / f"{name}.txt").write_text("\n".join(paths) + "\n")


def commands(which):
    """What is run, by verb, for the list `which`; all write the same name, each in a separate folder."""
    ingest = [PROGRAM, "ingest", f"../{which}.txt", "-o", "written", "--stream"]
    voxelize = [PROGRAM, "voxelize", "--manifest", f"../{which}.csv", "-o", "written", "--size", "32", "--seed", "1"]
    return {verb: [*line, "-q", "-j", "1"] for verb, line in (("ingest", ingest), ("voxelize", voxelize))}


def high_water_mark(process):
    """Peak memory of a running process so far, in MB. The kernel counts it from the start of the program; what wait4 gives
    includes that of this script, from which the process was forked."""
    with open(f"/proc/{process.pid}/status") as lines:
        kilobytes = [line.split()[1] for line in lines if line.startswith("VmHWM:")]
    return max(map(float, kilobytes), default=0.0) / 1024


def wait(process):
    """Exit status, peak memory in MB and processor time in s of a process."""
    peak, ended = 0.0, 0
    while not ended:
        peak = max(peak, high_water_mark(process))
        time.sleep(SECONDS_BETWEEN_LOOKS)
        ended, status, usage = os.wait4(process.pid, os.WNOHANG)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, peak, usage.ru_utime + usage.ru_stime


def run(command, where):
    where.mkdir()
    start = time.monotonic()
    process = subprocess.Popen(command, cwd=where, stdout=subprocess.DEVNULL, env=WITHOUT_LEFTOVERS)
    status, peak, cpu = wait(process)
    assert status == 0, f"{' '.join(command)} ended with {status}"
    return peak, cpu, time.monotonic() - start


def run_killed(command, where, kills, seconds):
    """Runs a command that takes about `seconds`, killing it `kills` times at points spread over that time."""
    where.mkdir()
    killed = 0
    draw = random.Random(2)
    while True:
        process = subprocess.Popen(command, cwd=where, stdout=subprocess.DEVNULL)
        if killed < kills:
            deadline = time.monotonic() + seconds / (kills + 1) * draw.uniform(0.5, 1.0)
            while process.poll() is None and time.monotonic() < deadline:
                time.sleep(SECONDS_BETWEEN_LOOKS)
            if process.returncode is None:
                process.send_signal(signal.SIGKILL)
                killed += 1
                process.wait()
                continue
        status = process.wait()
        assert status == 0, f"the last run ended with {status}"
        return killed


def contents(folder):
    return {path.relative_to(folder): path for path in sorted(folder.rglob("*")) if path.is_file()}


def differences(one, other):
    """The files that two folders do not have in common byte for byte."""
    a, b = contents(one), contents(other)
    wrong = sorted(str(name) for name in a.keys() ^ b.keys())
    for name in a.keys() & b.keys():
        if a[name].read_bytes() != b[name].read_bytes():
            wrong.append(str(name))
    return wrong


def check(verb, where, count):
    kills = int(os.environ.get("KILLS", "5"))
    tenth, whole, cut = (where / f"{verb}-{case}" for case in ("tenth", "whole", "killed"))
    small_peak, _, _ = run(commands("tenth")[verb], tenth)
    peak, cpu, seconds = run(commands("all")[verb], whole)
    killed = run_killed(commands("all")[verb], cut, kills, seconds)
    wrong = differences(whole, cut)
    files = contents(whole)
    size = sum(path.stat().st_size for path in files.values()) / 2**20
    print(
        f"{verb}: {count} structures, {cpu:.0f} s of processor time, {count / cpu:.0f} a second; peak memory "
        f"{small_peak:.1f} MB for {count // 10}, {peak:.1f} MB for {count}; killed {killed} times, "
        f"{len(wrong)} of {len(files)} files ({size:.0f} MB) differ",
        flush=True,
    )
    assert killed == kills, "the runs ended before they could be killed"
    assert not wrong, f"these files differ: {wrong[:10]}"
    assert peak < LARGEST_GROWTH * small_peak, "memory grows with the number of structures"


def main():
    where = Path(sys.argv[1]).resolve()
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 10_000
    shutil.rmtree(where, ignore_errors=True)
    where.mkdir(parents=True)
    write_structures(where / "structures", count)
    for verb in os.environ.get("VERBS", "ingest,voxelize").split(","):
        check(verb, where, count)


if __name__ == "__main__":
    main()
