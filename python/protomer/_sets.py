"""Sets of voxels as samples."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
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

    Raises
    ------
    MissingFileError
        If there is no such set; also a `FileNotFoundError`
    KeyError
        For a channel that the set does not have; it lists those that exist
    ConfigError
        For `target="number"` of a set with a label that is no number; it names the sample

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
        self.labels: list[str] = list(samples["label"])
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
