"""Frames of the trajectories that runs of bodies write."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._protomer import ParseError
from ._result import missing


def read_frames(run: Path | str, skip: int | None = None) -> list[Any]:
    """The frames of a run's `trajectory.gsd`, or of the file itself, without the first `skip`; by default without those
    of the equilibration, where the file says when it ended.

    Raises
    ------
    MissingFileError
        If there is no trajectory; also a `FileNotFoundError`
    ParseError
        If the file is not a GSD trajectory
    ValueError
        If no frame is left
    """
    import gsd.hoomd

    path = Path(run)
    path = path / "trajectory.gsd" if path.is_dir() else path
    if not path.exists():
        raise missing(f"there is no {path}; a run writes it unless trajectory_every is 0", path)
    try:
        with gsd.hoomd.open(str(path), "r") as file:
            frames = [frame for frame in file]
    except RuntimeError as error:
        raise ParseError(f"{path} cannot be read as a GSD trajectory ({error}); give the directory of a run, or its trajectory.gsd") from error
    if skip is None:
        skip = _equilibrating(frames)
    if len(frames) <= skip:
        raise ValueError(f"{path} has {len(frames)} frames; skip fewer than these (skip is {skip})")
    return frames[skip:]


def vertices_of(frame: Any) -> NDArray[np.float64] | None:
    """The vertices of the shape, (V, 3), where the frame has one shape with vertices; those in a plane get a z of 0."""
    shapes = frame.particles.type_shapes or []
    vertices = shapes[0].get("vertices") if len(shapes) == 1 else None
    if vertices is None:
        return None
    points = np.array(vertices, dtype=np.float64)
    return points if points.shape[1] == 3 else np.column_stack([points, np.zeros(len(points))])


def _equilibrating(frames: list[Any]) -> int:
    """The number of frames at the beginning that are not of the measurement."""
    ends = frames[0].log.get("equilibration_sweeps") if frames else None
    if ends is None:
        return 0
    return sum(int(frame.configuration.step) <= int(ends[0]) for frame in frames)
