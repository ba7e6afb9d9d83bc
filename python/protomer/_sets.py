"""Sets of voxels as samples."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import unknown
from ._result import missing

Grid = NDArray[np.float32]


class VoxelSet:
    """The samples of a set made by `protomer.voxelize`: pairs of a grid (C, z, y, x) and the number of its class.

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

    Raises
    ------
    MissingFileError
        If there is no such set; also a `FileNotFoundError`
    KeyError
        For a channel that the set does not have; it lists those that exist

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
        self.classes: list[str] = sorted(set(self.labels))
        self._numbers = {label: number for number, label in enumerate(self.classes)}

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

    def __getitem__(self, sample: int) -> tuple[Any, int]:
        if not -len(self) <= sample < len(self):
            raise IndexError(f"sample {sample} of {len(self)}")
        sample %= len(self)
        grid = self.grid(sample)
        return (grid if self._transform is None else self._transform(grid)), self._numbers[self.labels[sample]]

    def __iter__(self) -> Iterator[tuple[Any, int]]:
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
