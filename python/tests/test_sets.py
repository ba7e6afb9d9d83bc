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


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """A set of 24 samples in 12 clusters, with two classes."""
    folder = tmp_path_factory.mktemp("many")
    rows = "".join(f"{BPTI},{'ab'[n // 2 % 2]},c{n // 2},s{n}\n" for n in range(24))
    (folder / "set.csv").write_text("file,label,cluster,name\n" + rows)
    pm.voxelize(manifest=folder / "set.csv", output=folder / "set.zarr", size=24, spacing="fit", channels=["shape"])
    return folder / "set.zarr"


def test_labels_of_a_mapping_are_joined_by_name(many):
    other = {f"s{n}": n * 0.5 for n in range(24)}
    samples = pm.VoxelSet(many, labels=other)
    assert samples.target == "number" and samples[3][1] == 1.5 and pm.VoxelSet(many).classes == ["a", "b"]
    del other["s7"]
    with pytest.raises(pm.ConfigError, match="no label for s7"):
        pm.VoxelSet(many, labels=other)


SPLIT = {"least_samples": 1, "fractions": (0.5, 0.25, 0.25)}


def test_parts_are_those_of_a_training(many, tmp_path):
    import json

    fractions = list(SPLIT["fractions"])
    pm.train(many, least_samples=1, fractions=fractions, widths="4", groups=0, epochs=1, seed=3, output=tmp_path / "run")
    seen = json.loads((tmp_path / "run" / "trained_on.json").read_text())
    streams = {part: pm.VoxelStream(many, part, split_seed=3, **SPLIT) for part in ("training", "validation", "test")}
    for part in ("training", "validation"):
        names = {streams[part].set.names[sample] for sample in streams[part].samples}
        assert names == {sample["name"] for sample in seen[part]}
    together = np.concatenate([stream.samples for stream in streams.values()])
    assert sorted(together) == list(range(24))
    assert streams["training"].shuffle and not streams["test"].shuffle


def test_a_stream_gives_every_sample_once_in_the_order_of_its_seed(many):
    stream = pm.VoxelStream(many, shuffle=True, batch=5, seed=2)
    batches = list(stream)
    assert len(batches) == len(stream) == 5 and [len(targets) for _, targets in batches] == [5, 5, 5, 5, 4]
    order = stream.order()
    assert sorted(order) == list(range(24)) and order.tolist() != list(range(24))
    # The twin: each sample by itself.
    grids = np.concatenate([grids for grids, _ in batches])
    np.testing.assert_array_equal(grids, np.stack([stream.set.grid(int(sample)) for sample in order]))
    targets = np.concatenate([targets for _, targets in batches])
    np.testing.assert_array_equal(targets, [stream.set[int(sample)][1] for sample in order])
    np.testing.assert_array_equal(pm.VoxelStream(many, shuffle=True, batch=5, seed=2).order(), order)
    stream.set_epoch(1)
    assert stream.order().tolist() != order.tolist()


def test_shards_deal_out_the_batches(many):
    whole = [targets.tolist() for _, targets in pm.VoxelStream(many, shuffle=True, batch=5)]
    parts = [pm.VoxelStream(many, shuffle=True, batch=5, shard=(index, 2)) for index in range(2)]
    assert [len(part) for part in parts] == [3, 2]
    dealt = [[targets.tolist() for _, targets in part] for part in parts]
    assert dealt == [whole[0::2], whole[1::2]]


def test_streams_that_make_no_sense_are_refused(many):
    with pytest.raises(KeyError, match="no part .*'train'"):
        pm.VoxelStream(many, "train")
    with pytest.raises(pm.ConfigError, match="shard 2 of 2"):
        pm.VoxelStream(many, shard=(2, 2))
    with pytest.raises(pm.ConfigError, match="batch"):
        pm.VoxelStream(many, batch=0)
    with pytest.raises(pm.ConfigError, match="sum to 1"):
        pm.VoxelStream(many, "test", least_samples=1, fractions=(0.5, 0.5, 0.5))


@pytest.mark.parametrize("start", [None, "fork", "spawn"])
def test_workers_of_torch_share_the_batches_and_keep_their_order(many, start):
    torch = pytest.importorskip("torch", reason="torch is not installed; it is not required")
    stream = pm.VoxelStream(many, shuffle=True, batch=5, seed=4)
    assert isinstance(stream, torch.utils.data.IterableDataset)
    stream.set_epoch(3)
    workers = {} if start is None else {"num_workers": 2, "multiprocessing_context": start, "timeout": 120}
    loaded = list(torch.utils.data.DataLoader(stream, batch_size=None, **workers))
    expected = list(stream)
    assert len(loaded) == len(expected)
    for (grids, targets), (dense, numbers) in zip(loaded, expected):
        assert isinstance(grids, torch.Tensor) and targets.dtype == torch.int64
        np.testing.assert_array_equal(grids.numpy(), dense)
        np.testing.assert_array_equal(targets.numpy(), numbers)
