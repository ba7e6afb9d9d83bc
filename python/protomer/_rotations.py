"""Rotations as quaternions w, x, y, z: products and characters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]


def turned_vectors(quaternions: Numbers, vector: Numbers) -> Numbers:
    """A vector of the frame of the bodies in the frame of the box, (..., 3), for quaternions (..., 4)."""
    scalar, axis = quaternions[..., :1], quaternions[..., 1:]
    twice = 2.0 * np.cross(axis, np.broadcast_to(vector, axis.shape))
    return np.asarray(vector + scalar * twice + np.cross(axis, twice))


def between(first: Numbers, then: Numbers) -> Numbers:
    """conj(first) · then, the rotation from one orientation to the other in the frame of the body, (..., 4)."""
    a, b = first[..., :1], first[..., 1:]
    c, d = then[..., :1], then[..., 1:]
    scalar = a * c + np.sum(b * d, axis=-1, keepdims=True)
    return np.asarray(np.concatenate([scalar, a * d - c * b - np.cross(b, d)], axis=-1))


def symmetric_character(turns: Numbers, symmetry: Numbers, degree: int) -> Numbers:
    """Σ over the symmetries g of χ_l of the rotation turn · g, (...), for turns (..., 4) and symmetries (S, 4).

    χ_l(ω) = sin((l + ½)ω)/sin(½ω), the trace of a rotation by ω among the spherical harmonics of degree l, is the Chebyshev
    polynomial U_2l of the scalar part of the quaternion.
    """
    # The scalar part of a product is the scalar product with the conjugate.
    cosines = turns @ (symmetry * [1.0, -1.0, -1.0, -1.0]).T
    before, now = np.zeros_like(cosines), np.ones_like(cosines)
    for _ in range(2 * degree):
        before, now = now, 2.0 * cosines * now - before
    return np.asarray(now.sum(axis=-1))


def invariants(symmetry: Numbers, degree: int) -> int:
    """The number of functions of degree l on the sphere that the rotations of a group leave as they are."""
    still = np.array([1.0, 0.0, 0.0, 0.0])
    return round(float(symmetric_character(still, symmetry, degree)) / len(symmetry))
