"""Sets of voxels as a dataset."""

import pickle

import numpy as np
import pytest

import protomer as pm
from conftest import BPTI

zarr = pytest.importorskip("zarr", reason="zarr is not installed")


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    folder = tmp_path_factory.mktemp("set")
    (folder / "set.csv").write_text(f"file,label,cluster,name\n{BPTI},b,c,one\n{BPTI},a,c,two\n")
    pm.voxelize(manifest=folder / "set.csv", output=folder / "set.zarr", size=32, spacing="fit", seed=3)
    return folder / "set.zarr"


def test_samples_are_grids_with_the_number_of_their_class(path):
    samples = pm.VoxelSet(path)
    assert len(samples) == 2 and samples.classes == ["a", "b"] and samples.names == ["one", "two"]
    (first, label), (second, other) = samples
    assert first.shape == (3, 32, 32, 32) and first.dtype == np.float32 and (label, other) == (1, 0)
    assert not np.array_equal(first, second), "two random orientations are one"
    shape, potential, hydropathy = first
    assert shape.sum() > 100 and not potential[shape == 0].any() and np.abs(hydropathy).max() <= 4.5
    only = pm.VoxelSet(path, channels=["potential", "shape"], transform=lambda grid: grid[0].sum())
    assert only[-1][0] == pytest.approx(float(samples.grid(1)[1].sum()))
    with pytest.raises(IndexError):
        samples[2]
    with pytest.raises(KeyError, match="no channel of .* 'colour'"):
        pm.VoxelSet(path, channels=["colour"])


def test_labels_that_are_numbers_stay_numbers(tmp_path):
    # Sorted as text they would be 100.5, 20, 9.25, and the places in that order 2, 1, 0.
    rows = "".join(f"{BPTI},{label},c,{name}\n" for label, name in [("9.25", "one"), ("20", "two"), ("100.5", "three")])
    (tmp_path / "set.csv").write_text("file,label,cluster,name\n" + rows)
    pm.voxelize(manifest=tmp_path / "set.csv", output=tmp_path / "set.zarr", size=24, spacing="fit", channels=["shape"])
    samples = pm.VoxelSet(tmp_path / "set.zarr")
    assert samples.target == "number" and samples.classes == []
    np.testing.assert_array_equal(samples.values, [9.25, 20.0, 100.5])
    assert samples.values.dtype == np.float64
    assert [target for _, target in samples] == [9.25, 20.0, 100.5]
    assert pickle.loads(pickle.dumps(samples))[0][1] == 9.25
    classes = pm.VoxelSet(tmp_path / "set.zarr", target="class")
    assert classes.values is None and classes.classes == ["100.5", "20", "9.25"]
    assert [target for _, target in classes] == [2, 1, 0]
    with pytest.raises(KeyError, match="target"):
        pm.VoxelSet(tmp_path / "set.zarr", target="colour")


def test_classes_are_no_numbers(path):
    assert pm.VoxelSet(path).values is None
    with pytest.raises(pm.ConfigError, match="'b' of one is no number"):
        pm.VoxelSet(path, target="number")


def test_workers_of_a_loader_can_have_it(path):
    samples = pickle.loads(pickle.dumps(pm.VoxelSet(path)))
    np.testing.assert_array_equal(samples.grid(0), pm.VoxelSet(path).grid(0))


@pytest.mark.parametrize("start", [None, "fork", "spawn"])
def test_a_loader_of_torch_takes_it_as_it_is(path, start):
    torch = pytest.importorskip("torch", reason="torch is not installed; it is not required")
    samples = pm.VoxelSet(path)
    # Read before there are workers: what zarr keeps open must not stop those that are forked.
    expected = np.stack([samples.grid(0), samples.grid(1)])
    workers = {} if start is None else {"num_workers": 2, "multiprocessing_context": start, "timeout": 120}
    batches = list(torch.utils.data.DataLoader(samples, batch_size=1, **workers))
    assert [labels.tolist() for _, labels in batches] == [[1], [0]]
    grids = torch.cat([grids for grids, _ in batches])
    assert grids.dtype == torch.float32 and tuple(grids.shape) == (2, 3, 32, 32, 32)
    np.testing.assert_array_equal(grids.numpy(), expected)


def test_a_loader_of_torch_shuffles_and_transforms(path):
    torch = pytest.importorskip("torch", reason="torch is not installed; it is not required")
    samples = pm.VoxelSet(path, channels=["shape"], transform=torch.from_numpy)
    loader = torch.utils.data.DataLoader(samples, batch_size=2, shuffle=True, generator=torch.Generator().manual_seed(0))
    (grids, labels), *none = list(loader)
    assert not none and grids.shape == (2, 1, 32, 32, 32) and sorted(labels.tolist()) == [0, 1]
    first = labels.tolist().index(1)
    np.testing.assert_array_equal(grids[first].numpy(), pm.VoxelSet(path, channels=["shape"]).grid(0))
