"""Sets of voxels as samples."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _protomer
from ._errors import unknown
from ._result import missing

Grid = NDArray[np.float32]


def _number(label: str) -> float | None:
    """The finite number that a label is, as `train --target number` reads it."""
    # Only Python takes underscores between digits.
    if "_" in label:
        return None
    try:
        number = float(label)
    except ValueError:
        return None
    return number if np.isfinite(number) else None


class VoxelSet:
    """The samples of a set made by `protomer.voxelize`: pairs of a grid (C, z, y, x) and its target.

    The target is the number of the class of a sample, its place in `classes`. If every label of the set is a number, such as a melting
    temperature, it is that number instead, and `values` holds all of them; `target` says otherwise.

    A map-style dataset: `torch.utils.data.DataLoader(VoxelSet("set.zarr"), batch_size=8)` takes it as it is, and torch is not
    needed for anything else. Samples are read one by one, so a set may be larger than memory. Needs zarr
    (`pip install './python[sets]'` from the root of the project).

    Parameters
    ----------
    path
        The zarr group
    channels
        The channels wanted, in order; all if left out
    transform
        Called with every grid, for scaling or rotation
    target
        `"number"` or `"class"`; by default numbers if all labels are numbers, classes otherwise. Labels that count
        classes, such as 0 and 1, need `target="class"`
    labels
        Labels by the name of the sample instead of those of the set

    Raises
    ------
    MissingFileError
        If there is no such set; also a `FileNotFoundError`
    KeyError
        For a channel that the set does not have; it lists those that exist
    ConfigError
        For `target="number"` of a set with a label that is no number, and for a sample that `labels` lacks; it names
        the sample

    Examples
    --------
    >>> grid, number = pm.VoxelSet("set.zarr", channels=["occupancy"])[0]      # doctest: +SKIP
    """

    def __init__(
        self,
        path: Path | str,
        *,
        channels: list[str] | None = None,
        transform: Callable[[Grid], Any] | None = None,
        target: Literal["number", "class"] | None = None,
        labels: Mapping[str, str | float] | None = None,
    ) -> None:
        self._path = os.fspath(path)
        self._transform = transform
        self._open()
        known = dict(self._group.attrs)
        self.channels: list[str] = list(known["channels"]) if channels is None else list(channels)
        for channel in self.channels:
            if channel not in known["channels"]:
                unknown(f"channel of {self._path}", channel, known["channels"])
        self.size: int = int(known["size"])
        self._implied = set(known["implied_channels"])
        samples = known["samples"]
        self.names: list[str] = list(samples["name"])
        self.labels: list[str] = list(samples["label"]) if labels is None else self._joined(labels)
        self.clusters: list[str] = list(samples["cluster"])
        numbers = [_number(label) for label in self.labels]
        if target is None:
            target = "class" if None in numbers or not numbers else "number"
        elif target not in ("number", "class"):
            unknown("target", target, ["number", "class"])
        self.target: Literal["number", "class"] = target
        self.values: NDArray[np.float64] | None = None
        """The numbers of the samples, (S,); None for classes."""
        self.classes: list[str] = []
        """The classes in alphabetical order; none for numbers."""
        self._targets: list[int] | list[float]
        if target == "number":
            found = [number for number in numbers if number is not None]
            if len(found) < len(numbers):
                sample = numbers.index(None)
                raise _protomer.ConfigError(
                    f"{self._path}: the label '{self.labels[sample]}' of {self.names[sample]} is no number; use target=\"class\""
                )
            self.values = np.array(found, dtype=np.float64)
            self._targets = found
        else:
            self.classes = sorted(set(self.labels))
            places = {label: place for place, label in enumerate(self.classes)}
            self._targets = [places[label] for label in self.labels]

    def _joined(self, labels: Mapping[str, str | float]) -> list[str]:
        for name in self.names:
            if name not in labels:
                raise _protomer.ConfigError(f"{self._path}: there is no label for {name}; give one for each sample")
        return [str(labels[name]) for name in self.names]

    def _open(self) -> None:
        try:
            import zarr
        except ImportError as error:
            raise ImportError("sets need zarr: pip install './python[sets]' from the root of the project") from error
        if not os.path.isdir(self._path):
            raise missing(f"there is no set {self._path}", self._path)
        # Types of what a group holds are known only when it is open.
        group: Any = zarr.open_group(self._path, mode="r")
        self._group = group
        self._offsets: NDArray[np.int64] = group["offsets"][:]

    def __getstate__(self) -> dict[str, Any]:
        # Each loader worker opens the set itself.
        return {name: value for name, value in self.__dict__.items() if name not in ("_group", "_offsets")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._open()

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, sample: int) -> tuple[Any, int | float]:
        if not -len(self) <= sample < len(self):
            raise IndexError(f"sample {sample} of {len(self)}")
        sample %= len(self)
        grid = self.grid(sample)
        return (grid if self._transform is None else self._transform(grid)), self._targets[sample]

    def __iter__(self) -> Iterator[tuple[Any, int | float]]:
        return (self[sample] for sample in range(len(self)))

    def grid(self, sample: int) -> Grid:
        """The grid of a sample, (C, z, y, x)."""
        begin, end = self._offsets[sample], self._offsets[sample + 1]
        index = self._group["index"][begin:end]
        grid = np.zeros((len(self.channels), self.size**3), np.float32)
        for row, channel in zip(grid, self.channels):
            row[index] = 1.0 if channel in self._implied else self._group[channel][begin:end]
        return grid.reshape(-1, self.size, self.size, self.size)

    def __repr__(self) -> str:
        return f"VoxelSet({self._path!r}, {len(self)} samples of {self.size}³, {', '.join(self.channels)})"


Part = Literal["training", "validation", "test"]


@functools.cache
def _class_for_torch() -> type[VoxelStream] | None:
    """The class that `torch.utils.data.DataLoader` takes for a stream; none without torch."""
    try:
        # Lazily: torch takes seconds to load, and nothing else here needs it.
        from torch.utils.data import IterableDataset
    except ImportError:
        return None
    return type("VoxelStream", (VoxelStream, IterableDataset), {"__module__": __name__})


def _restored(state: dict[str, Any]) -> VoxelStream:
    """A stream in another process, which makes its class there again."""
    stream = object.__new__(_class_for_torch() or VoxelStream)
    stream.__dict__.update(state)
    return stream


class VoxelStream:
    """Batches of a set of voxels, or of one part of its split: pairs of dense grids (B, C, z, y, x) and targets (B,).

    With torch installed it is a `torch.utils.data.IterableDataset`; give it to a loader with `batch_size=None`, as it
    makes the batches itself. Without torch it is an iterable of arrays. Grids are read and made dense when their batch
    is due. The order depends on `seed` and the epoch alone: workers of a loader share the batches among them, and together
    they give the batches that one process would, in the same order.

    Parameters
    ----------
    samples
        The set, or its path
    part
        `"training"`, `"validation"` or `"test"` of the split that `protomer.train` makes with the same arguments; all
        samples if left out. Samples that `train` leaves out because they cannot be read are in their part here
    batch
        Samples per batch; the last batch may have fewer
    shuffle
        Whether every epoch has another order; by default for the training part only
    seed
        Seed of the order
    split_seed, fractions, split_by, least_samples, number_classes
        As for `protomer.train`
    shard
        The number of this process and how many there are, such as rank and world size: each takes its share of the
        batches

    Raises
    ------
    ConfigError
        For a part that cannot be made, such as one of too few clusters
    KeyError
        For a part that does not exist

    Examples
    --------
    >>> training = pm.VoxelStream("set.zarr", "training", batch=8)                        # doctest: +SKIP
    >>> loader = torch.utils.data.DataLoader(training, batch_size=None, num_workers=2)    # doctest: +SKIP
    >>> for epoch in range(20):                                                           # doctest: +SKIP
    ...     training.set_epoch(epoch)
    ...     for grids, targets in loader: ...
    """

    def __new__(cls, *_arguments: Any, **_named: Any) -> VoxelStream:
        # A separate class for torch, because a loader asks for the type.
        return object.__new__((_class_for_torch() or cls) if cls is VoxelStream else cls)

    def __init__(
        self,
        samples: VoxelSet | Path | str,
        part: Part | None = None,
        *,
        batch: int = 8,
        shuffle: bool | None = None,
        seed: int = 1,
        split_seed: int = 1,
        fractions: tuple[float, float, float] = (0.7, 0.15, 0.15),
        split_by: Literal["cluster", "sample"] = "cluster",
        least_samples: int = 10,
        number_classes: int = 5,
        shard: tuple[int, int] = (0, 1),
    ) -> None:
        self.set: VoxelSet = samples if isinstance(samples, VoxelSet) else VoxelSet(samples)
        """The set."""
        if batch < 1:
            raise _protomer.ConfigError(f"batch must be 1 or more, not {batch}")
        index, count = shard
        if not 0 <= index < count:
            raise _protomer.ConfigError(f"shard {index} of {count} does not exist; count from 0")
        if split_by not in ("cluster", "sample"):
            unknown("unit of the split", split_by, ["cluster", "sample"])
        self.part: Part | None = part
        self.batch = batch
        self.shuffle = part == "training" if shuffle is None else shuffle
        self._seed, self._epoch, self._shard = seed, 0, (index, count)
        if part is None:
            samples_of_part: Sequence[int] = range(len(self.set))
        else:
            names = ["training", "validation", "test"]
            if part not in names:
                unknown("part", part, names)
            parts = _protomer.parts(
                self.set.labels,
                self.set.clusters,
                numbers=self.set.target == "number",
                least_samples=least_samples,
                number_classes=number_classes,
                by_cluster=split_by == "cluster",
                seed=split_seed,
                fractions=fractions,
            )
            samples_of_part = parts[names.index(part)]
        self.samples: NDArray[np.int64] = np.array(samples_of_part, dtype=np.int64)
        """The samples of the part, as numbers in the set."""

    def set_epoch(self, epoch: int) -> None:
        """Takes the order of an epoch; call it before each pass over a shuffled stream."""
        self._epoch = epoch

    def order(self) -> NDArray[np.int64]:
        """The samples in the order of this epoch, as numbers in the set."""
        if not self.shuffle:
            return self.samples
        return np.random.default_rng([self._seed, self._epoch]).permutation(self.samples)

    def __len__(self) -> int:
        """The number of batches of this shard."""
        index, count = self._shard
        return len(range(index, -(-len(self.samples) // self.batch), count))

    def __iter__(self) -> Iterator[tuple[Any, NDArray[Any]]]:
        order = self.order()
        starts = range(0, len(order), self.batch)
        (index, count), (worker, workers) = self._shard, _worker()
        # A loader takes a batch from each of its workers in turn: dealt out in the same way, the order is kept.
        for start in starts[index::count][worker::workers]:
            yield self._batch(order[start : start + self.batch])

    def _batch(self, samples: NDArray[np.int64]) -> tuple[Any, NDArray[Any]]:
        pairs = [self.set[int(sample)] for sample in samples]
        grids = [grid for grid, _ in pairs]
        kind = np.float32 if self.set.target == "number" else np.int64
        return _stacked(grids), np.array([target for _, target in pairs], dtype=kind)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.__dict__,)

    def __repr__(self) -> str:
        part = self.part or "all samples"
        return f"VoxelStream({part}, {len(self.samples)} samples in batches of {self.batch}, {self.set!r})"


def _worker() -> tuple[int, int]:
    """The number of this worker of a loader, and how many there are."""
    if _class_for_torch() is None:
        return 0, 1
    from torch.utils.data import get_worker_info

    information = get_worker_info()
    return (0, 1) if information is None else (information.id, information.num_workers)


def _stacked(grids: list[Any]) -> Any:
    """Grids as one array; tensors, of a transformation, as one tensor."""
    if isinstance(grids[0], (np.ndarray, np.generic, int, float)):
        return np.stack(grids)
    import torch

    return torch.stack(grids)
