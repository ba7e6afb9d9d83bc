"""The templates for Slurm arrays, run as their tasks would be."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import protomer as pm

ROOT = Path(__file__).resolve().parents[2]
TEMPLATES = ROOT / "docs" / "cluster"


def begin(template, task, tasks, *words):
    """Starts a task of an array."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    variables = {"SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": str(tasks), "PATH": path}
    command = ["bash", str(TEMPLATES / template), *map(str, words)]
    return subprocess.Popen(command, env={**os.environ, **variables}, stderr=subprocess.PIPE, text=True)


def array(template, tasks, *words):
    """Runs the tasks of an array, all at once."""
    running = [begin(template, task, tasks, *words) for task in range(1, tasks + 1)]
    for process in running:
        _, errors = process.communicate(timeout=300)
        assert process.returncode == 0, errors


def test_the_tasks_of_an_array_make_the_local_sweep(ring, tmp_path):
    words = ["--salt=30mM,300mM", "--replicas=2", "--sweeps=20", "--equilibration=10", "--seed=7"]
    array("sweep.slurm", 3, ring, tmp_path / "array", *words)
    settings = {"salt": "30mM,300mM", "replicas": 2, "sweeps": 20, "equilibration": 10, "seed": 7}
    assert not (tmp_path / "array" / "sweep.csv").exists()
    assert pm.sweep(ring, **settings, output=tmp_path / "array") == pm.sweep(ring, **settings, output=tmp_path / "local")
    assert (tmp_path / "array" / "sweep.csv").read_bytes() == (tmp_path / "local" / "sweep.csv").read_bytes()


def test_the_tasks_of_an_array_make_the_local_pair(pebbles, tmp_path):
    words = ["--salt=30mM,300mM", "--relative-error=0.4", "--most-directions=64"]
    array("pair.slurm", 2, tmp_path / "array", *pebbles, *words)
    settings = {"salt": "30mM,300mM", "relative_error": 0.4, "most_directions": 64}
    assert not (tmp_path / "array" / "pair.csv").exists()
    collected = pm.pair(*pebbles, **settings, output=tmp_path / "array")
    assert collected == pm.pair(*pebbles, **settings, output=tmp_path / "local")
    assert (tmp_path / "array" / "pair.csv").read_bytes() == (tmp_path / "local" / "pair.csv").read_bytes()


def test_the_tasks_of_an_array_make_a_set(tmp_path):
    structures = {path.name.split(".")[0]: path for path in sorted((ROOT / "data" / "structures").glob("*.gz"))}
    manifest = tmp_path / "manifest.csv"
    rows = [f"{path},{name},{name}" for name, path in structures.items()]
    manifest.write_text("\n".join(["file,label,cluster", *rows]) + "\n")
    array("voxelize.slurm", 2, manifest, tmp_path / "parts", "--size", 32, "--spacing", "fit", "--channels", "shape")
    parts = sorted((tmp_path / "parts").glob("*.zarr"))
    assert len(parts) == 2
    merged = pm.merge(parts, output=tmp_path / "set.zarr")
    whole = pm.voxelize(
        manifest=manifest, output=tmp_path / "whole.zarr", size=32, spacing="fit", channels=["shape"]
    )
    assert merged.samples == whole.samples > 1


def test_the_signal_before_the_time_is_up_stops_a_task_resumably(ring, tmp_path):
    for template in TEMPLATES.glob("*.slurm"):
        # Without the B Slurm signals the steps of a job only, and there are none.
        assert "#SBATCH --signal=B:TERM@" in template.read_text(), template.name
    words = ["--salt=30mM", "--replicas=1", "--sweeps=10000000", "--equilibration=0"]
    task = begin("sweep.slurm", 1, 1, ring, tmp_path / "sweep", *words)
    log = tmp_path / "sweep" / "salt_0.030000M" / "replica_0" / "log.csv"
    deadline = time.monotonic() + 60
    while not log.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    # To the shell of the script, which protomer has become.
    task.send_signal(signal.SIGTERM)
    _, errors = task.communicate(timeout=60)
    assert task.returncode == 3, errors
