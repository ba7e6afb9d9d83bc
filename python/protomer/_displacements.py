"""Statistics of displacements: their shape, their waves, and the time that bodies stay where they are.

Tracks are places against time, (F, N, d), without the drift of the centre of mass; lags are numbers of frames, and every frame
is an origin.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]

# Of the table of J0, between whose entries it is a straight line: an error below 1e-6.
_STEP = 0.002


def displacements(track: Numbers, lag: int) -> Numbers:
    """All displacements over a lag, (origins · N, d)."""
    return np.asarray((track[lag:] - track[: len(track) - lag]).reshape(-1, track.shape[2]))


def non_gaussian(track: Numbers, lag: int) -> float:
    """d⟨r⁴⟩/((d + 2)⟨r²⟩²) - 1: 0 for Gaussian displacements; not a number where nothing moves."""
    dimension = track.shape[2]
    squares = np.sum(displacements(track, lag) ** 2, axis=1)
    mean = float(np.mean(squares))
    if mean == 0.0:
        return float("nan")
    return float(dimension * np.mean(squares**2) / ((dimension + 2) * mean**2) - 1.0)


def van_hove(track: Numbers, lag: int, edges: Numbers) -> Numbers:
    """The density of displacements, per area or volume, between distances, (B,)."""
    dimension = track.shape[2]
    distances = np.linalg.norm(displacements(track, lag), axis=1)
    counts, _ = np.histogram(distances, bins=edges)
    measure = {1: 2.0, 2: np.pi, 3: 4.0 / 3.0 * np.pi}[dimension] * np.diff(edges**dimension)
    return np.asarray(counts / (len(distances) * measure))


def intermediate(track: Numbers, lag: int, wave_number: float) -> float:
    """⟨exp(i k·Δr)⟩ averaged over the directions of k: sin(kr)/(kr) in space, J0(kr) in a plane."""
    waves = wave_number * np.linalg.norm(displacements(track, lag), axis=1)
    return float(np.mean(np.sinc(waves / np.pi) if track.shape[2] == 3 else _bessel(waves)))


def _bessel(values: Numbers) -> Numbers:
    """J0 of values that are not negative."""
    last = float(values.max())
    table = np.arange(0.0, last + 2.0 * _STEP, _STEP)
    # Evenly spaced over half a turn of ∫cos(x sin τ)dτ/π: with n of them the error is 2 J_2n(x), nothing for 2n > x + 48.
    angles = np.pi * np.linspace(0.0, 1.0, int(0.5 * last) + 24, endpoint=False)
    found = np.zeros_like(table)
    for sine in np.sin(angles):
        found += np.cos(table * sine)
    return np.interp(values, table, found / len(angles))


def staying(track: Numbers, distance: float, origins: int) -> Numbers:
    """The part of bodies that have never been farther than a distance from their place at an origin, for each lag, (L,).

    Origins are spaced evenly over the first half of the frames, and L is the number of frames from the last of them on, so
    that every lag has the same origins.
    """
    count = len(track)
    starts = np.unique(np.linspace(0, count // 2, origins).astype(int))
    last = count - int(starts[-1])
    part = np.zeros(last)
    for start in starts:
        inside = np.ones(track.shape[1], dtype=bool)
        for lag in range(last):
            inside &= np.sum((track[start + lag] - track[start]) ** 2, axis=1) <= distance**2
            part[lag] += inside.mean()
    return np.asarray(part / len(starts))
