"""Sweeps on Dask workers: bit for bit those of this machine, also when a worker is killed."""

import os
import signal

import pytest

import protomer as pm

distributed = pytest.importorskip("distributed", reason="dask's distributed is not installed")

SETTINGS = {"salt": ["30mM", "300mM"], "replicas": 2, "sweeps": 400, "equilibration": 50, "seed": 7, "checkpoint_every": 0.05}


def files(folder):
    """Every file but locks, and what a killed process may leave."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != ".lock"
    }


@pytest.fixture
def cluster():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster


def test_a_killed_worker_costs_its_own_task_and_the_result_is_the_local_one(ring, tmp_path, cluster):
    local = pm.sweep(ring, **SETTINGS, output=tmp_path / "local")
    killed = []

    def kill_one(done, total, unit):
        if not killed:
            killed.append(done)
            worker = next(iter(cluster.workers.values()))
            os.kill(worker.process.pid, signal.SIGKILL)

    with distributed.Client(cluster) as client:
        remote = pm.sweep(ring, **SETTINGS, output=tmp_path / "remote", client=client, progress=kill_one)
    assert killed == [1]
    assert remote == local
    assert files(tmp_path / "remote") == files(tmp_path / "local")


def test_an_error_of_a_worker_is_the_caller_s(tmp_path, cluster):
    with distributed.Client(cluster) as client, pytest.raises(pm.ProtomerError, match="nowhere.json"):
        pm.sweep("nowhere.json", **SETTINGS, output=tmp_path / "remote", client=client, retries=0)
