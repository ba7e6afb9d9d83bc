"""Work on Dask workers: byte for byte that of this machine, also when a worker is killed."""

import os
import signal
import subprocess
import sys

import pytest

import protomer as pm
from conftest import BPTI
from protomer import _cluster, _protomer

distributed = pytest.importorskip("distributed", reason="dask's distributed is not installed")

SWEEP = {"salt": ["30mM", "300mM"], "replicas": 2, "sweeps": 100, "equilibration": 50, "seed": 7, "checkpoint_every": 0.05}
VOXELS = {"size": 24, "spacing": 2, "channels": "shape", "seed": 3}


def files(folder):
    """Every file but locks."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not path.name.endswith(".lock")
    }


@pytest.fixture(scope="module")
def cluster():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster


@pytest.fixture
def client(cluster):
    with distributed.Client(cluster) as client:
        # One that a test killed may still be coming back.
        client.wait_for_workers(1, timeout=60)
        yield client


@pytest.fixture(scope="module")
def manifest(tmp_path_factory):
    """Six structures that are voxelised, and one that is left out."""
    path = tmp_path_factory.mktemp("manifest") / "manifest.csv"
    rows = [f"{BPTI},even,c{n},s{n}" for n in range(6)]
    path.write_text("\n".join(["file,label,cluster,name", *rows, "nowhere.pdb,odd,d,lost"]) + "\n")
    return path


class KillOne:
    """Kills a worker when the first part is done."""

    def __init__(self, cluster, look=lambda: None):
        self.cluster, self.look, self.seen = cluster, look, []

    def __call__(self, done, total, unit):
        if not self.seen:
            self.seen.append(self.look())
            os.kill(next(worker.pid for worker in self.cluster.workers.values() if worker.pid), signal.SIGKILL)


def command(*words):
    """The command line of the same package."""
    return subprocess.run([sys.executable, "-m", "protomer", *map(str, words)], capture_output=True, text=True, timeout=300)


def test_a_killed_worker_costs_its_own_task_and_the_sweep_is_the_local_one(ring, tmp_path, cluster, client):
    local = pm.sweep(ring, **SWEEP, output=tmp_path / "local")
    kill = KillOne(cluster)
    remote = pm.sweep(ring, **SWEEP, output=tmp_path / "remote", client=client, progress=kill)
    assert kill.seen and remote == local
    assert files(tmp_path / "remote") == files(tmp_path / "local")


def test_a_killed_worker_costs_its_own_conditions_and_the_pair_is_the_local_one(pebbles, tmp_path, cluster, client):
    pair = {"salt": ["30mM", "100mM", "300mM"], "relative_error": 0.4, "most_directions": 64, "checkpoint_every": 0}
    local = pm.pair(*pebbles, **pair, output=tmp_path / "local")
    kill = KillOne(cluster)
    remote = pm.pair(*pebbles, **pair, output=tmp_path / "remote", client=client, parts=3, progress=kill)
    assert kill.seen and remote == local and len(remote.conditions) == 3
    assert files(tmp_path / "remote") == files(tmp_path / "local")
    with pytest.raises(pm.ConfigError, match="add --output"):
        pm.pair(*pebbles, **pair, client=client)


def test_a_killed_worker_costs_its_own_strengths_and_the_free_energy_is_the_local_one(tmp_path, cluster, client):
    rods = {"shape": "rod:1", "crystal": "row", "bodies": 8, "packing_fraction": 0.5, "equilibration": 100, "sweeps": 2000}
    rods |= {"share": "even", "checkpoint_every": 0}
    local = pm.free_energy(**rods, output=tmp_path / "local")
    kill = KillOne(cluster)
    remote = pm.free_energy(**rods, output=tmp_path / "remote", client=client, parts=5, progress=kill)
    assert kill.seen and remote == local and len(remote.points) == 21
    assert files(tmp_path / "remote") == files(tmp_path / "local")
    with pytest.raises(pm.ProtomerError, match="--share even"):
        pm.free_energy(**{**rods, "share": "errors"}, output=tmp_path / "refused", client=client)


def test_every_verb_that_takes_a_client_can_be_shared_out():
    verbs = [function["verb"] for group in _protomer.verbs() for function in group["functions"] if takes_client(function)]
    assert {verb[0] for verb in verbs} == set(_cluster._SHARED_OUT) and len(verbs) == 9


def takes_client(function):
    return any(parameter["name"] == "client" for parameter in function["parameters"])


def test_a_killed_worker_costs_its_own_task_and_the_set_is_the_local_one(manifest, tmp_path, cluster, client, monkeypatch):
    local = pm.voxelize(manifest=manifest, **VOXELS, output=tmp_path / "local.zarr")
    parts = tmp_path / "remote.zarr.parts"

    def made():
        """When each part was finished."""
        return {path.parent.name: path.stat().st_mtime_ns for path in parts.glob("*.zarr/zarr.json")}

    at_the_end = []
    monkeypatch.setattr(_cluster.shutil, "rmtree", lambda folder: at_the_end.append(made()))
    kill = KillOne(cluster, made)
    remote = pm.voxelize(
        manifest=manifest, **VOXELS, output=tmp_path / "remote.zarr", client=client, parts=5, progress=kill
    )
    assert files(tmp_path / "remote.zarr") == files(tmp_path / "local.zarr")
    assert remote.samples == local.samples == 6
    assert [left.name for left in remote.excluded] == ["lost"]
    # What was finished when the worker was killed was not made again.
    assert kill.seen[0] and kill.seen[0].items() <= at_the_end[0].items()
    assert len(at_the_end[0]) == 5


def test_a_set_goes_on_with_the_parts_of_an_earlier_call(manifest, tmp_path, client):
    voxelize = {"manifest": manifest, **VOXELS, "output": tmp_path / "set.zarr", "client": client}
    with pytest.raises(pm.StoppedError, match="continues it"):
        pm.voxelize(**voxelize, parts=3, time_limit=0)
    heard = []
    pm.voxelize(**voxelize, progress=lambda *news: heard.append(news))
    assert heard == [(1, 3, "parts"), (2, 3, "parts"), (3, 3, "parts")]
    assert [path.name for path in tmp_path.iterdir()] == ["set.zarr"]
    # A complete set leaves nothing for the workers; another set must not be overwritten.
    assert pm.voxelize(**voxelize, progress=lambda *news: heard.append(news)).state == "nothing-to-do"
    with pytest.raises(pm.ProtomerError, match="holds another set"):
        pm.voxelize(**{**voxelize, "seed": 4})
    assert len(heard) == 3
    assert pm.voxelize(**{**voxelize, "seed": 4}, force=True).samples == 6


def test_a_search_on_workers_is_the_local_one(tmp_path, cluster, client):
    manifest = tmp_path / "manifest.csv"
    rows = [f"{BPTI},{'odd' if n % 2 else 'even'},c{n},s{n}" for n in range(16)]
    manifest.write_text("\n".join(["file,label,cluster,name", *rows]) + "\n")
    pm.voxelize(manifest=manifest, **VOXELS, output=tmp_path / "set.zarr")
    search = {"trials": 4, "epochs": 3, "least_samples": 5, "checkpoint_every": 0}
    local = pm.tune(tmp_path / "set.zarr", **search, output=tmp_path / "local")
    kill = KillOne(cluster)
    remote = pm.tune(tmp_path / "set.zarr", **search, output=tmp_path / "remote", client=client, parts=3, progress=kill)
    assert kill.seen and remote.trials[0].to_dict() == local.trials[0].to_dict()
    assert [trial.epochs for trial in remote.trials] == [3, 3, 1, 1]
    assert files(tmp_path / "remote") == files(tmp_path / "local")


def test_the_command_line_uses_a_scheduler(ring, manifest, tmp_path, cluster):
    words = ["--salt=30mM,300mM", "--replicas=2", "--sweeps=20", "--equilibration=10", "--seed=7", "-o"]
    here = command("sweep", ring, *words, tmp_path / "here")
    there = command("sweep", "--scheduler", cluster.scheduler_address, ring, *words, tmp_path / "there")
    assert (here.returncode, there.returncode) == (0, 0), there.stderr
    assert files(tmp_path / "here") == files(tmp_path / "there")
    assert here.stdout == there.stdout
    # Without an address: workers of this machine.
    voxelize = ["voxelize", "--manifest", manifest, "--size=24", "--spacing=2", "--channels=shape", "-o", tmp_path / "set.zarr"]
    made = command(*voxelize, "--scheduler", "-q")
    assert made.returncode == 0, made.stderr
    assert "6 samples" in command(*voxelize).stdout


def test_errors_say_what_to_do(ring, tmp_path, client, monkeypatch):
    def sweep(client, **settings):
        return pm.sweep(ring, **{**SWEEP, **settings}, output=tmp_path / "remote", client=client)

    with pytest.raises(pm.ProtomerError, match="nowhere.json"):
        pm.sweep("nowhere.json", **SWEEP, output=tmp_path / "remote", client=client)
    with pytest.raises(pm.ConfigError, match="omit it"):
        sweep(client, shard="1/2")
    with pytest.raises(pm.ConfigError, match="tcp://host:8786"):
        sweep("nonsense")
    monkeypatch.setattr(_cluster, "SECONDS_TO_ANSWER", 1)
    with pytest.raises(pm.ProtomerError, match="dask scheduler"):
        sweep("tcp://127.0.0.1:1")
    assert "install the same" in str(_cluster._run(["sweep"], "0.0.0"))
    refused = command("sweep", ring, "--salt=30mM", "--scheduler=nonsense", "-o", tmp_path / "remote")
    assert refused.returncode == 1 and "not the address of a scheduler" in refused.stderr
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match=r"./python\[cluster\]"):
        sweep(client)
