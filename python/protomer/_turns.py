"""How far bodies turn, and how they move meanwhile, in the frame that they had before.

A turn between two frames of a trajectory is a rotation vector in the frame of the box. Their sums are followed through full turns,
as displacements are through the faces of a box.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._rotations import between

Numbers = NDArray[np.float64]


def rotation_vectors(quaternions: Numbers) -> Numbers:
    """Rotation vectors, at most π long, of quaternions w, x, y, z, (..., 3)."""
    # A quaternion and its negative are one rotation: the one with a positive scalar is that of the shorter turn.
    short = quaternions * np.where(quaternions[..., :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(short[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sine, short[..., :1])
    # 2 arcsin(s)/s is 2 where s is nothing.
    factor = 2.0 * np.divide(half, sine, out=np.ones_like(half), where=sine > 1e-300)
    return np.asarray(factor * short[..., 1:])


def matrices(quaternions: Numbers) -> Numbers:
    """Rotation matrices from the frames of bodies to that of the box, (..., 3, 3)."""
    unit = quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True)
    w, x, y, z = np.moveaxis(unit, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.asarray(np.moveaxis(np.array(rows), [0, 1], [-2, -1]))


def angle_matrices(angles_rad: Numbers) -> Numbers:
    """Rotation matrices in a plane, (..., 2, 2)."""
    cosine, sine = np.cos(angles_rad), np.sin(angles_rad)
    return np.asarray(np.moveaxis(np.array([[cosine, -sine], [sine, cosine]]), [0, 1], [-2, -1]))


def followed(quaternions: Numbers) -> Numbers:
    """The sums of the turns from frame to frame, in the frame of the box, (F, N, 3), for quaternions (F, N, 4)."""
    steps = rotation_vectors(between(quaternions[:-1], quaternions[1:]))
    # The axis of a turn is the same before and after it.
    in_box = np.einsum("fnab,fnb->fna", matrices(quaternions[:-1]), steps)
    return np.concatenate([np.zeros((1, *in_box.shape[1:])), np.cumsum(in_box, axis=0)])


def in_frames(frames: Numbers, track: Numbers, lag: int) -> Numbers:
    """Changes of vectors (F, N, d) over a lag in the frames (F, N, d, d) that bodies had before, (F - lag, N, d)."""
    change = track[lag:] - track[: len(track) - lag]
    return np.asarray(np.einsum("fnba,fnb->fna", frames[: len(track) - lag], change))


def mean_product(first: Numbers, second: Numbers) -> Numbers:
    """⟨a bᵀ⟩ over origins and bodies, (d, e)."""
    a, b = (values.reshape(-1, values.shape[-1]) for values in (first, second))
    return np.asarray(a.T @ b / len(a))


def correlation_of_squares(first: Numbers, second: Numbers) -> float:
    """⟨a² b²⟩/(⟨a²⟩⟨b²⟩) - 1; not a number where one of them is nothing."""
    a, b = (np.sum(values**2, axis=-1) for values in (first, second))
    scale = float(a.mean() * b.mean())
    return float((a * b).mean() / scale - 1.0) if scale > 0.0 else float("nan")
