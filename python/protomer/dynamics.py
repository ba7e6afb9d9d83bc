"""Bodies in motion: displacements, correlations, relaxation times and bond-orientational order.

`Motion.read` takes the trajectory of a run of `md run`; `Seeds` holds runs that differ in their seed, and gives means with
standard errors over them. Displacements and bond-orientational order are those of freud (`pip install protomer[dynamics]`).

Definitions: lags t are counted from every frame; the drift of the centre of mass is taken off; angles are followed through
full turns. Times are in the unit of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._errors import unknown
from ._frames import read_frames
from ._result import new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Motion", "Seeds", "free_flight_displacement", "local_slope", "relaxation_time"]

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """Where bodies are at equally spaced times.

    Attributes
    ----------
    times
        (F,)
    positions
        Centres, not wrapped into the box, (F, N, 3)
    angles_rad
        In a plane, not wrapped, (F, N); None in space
    velocities
        Of the centres, (F, N, 3)
    spins
        Angular momenta in the frame of each body, (F, N, 3)
    box
        Edges, (3,); in a plane the third is 0
    """

    times: Numbers
    positions: Numbers
    angles_rad: Numbers | None
    velocities: Numbers
    spins: Numbers
    box: Numbers

    @classmethod
    def read(cls, run: Path | str, *, skip: int | None = None) -> Motion:
        """Reads the trajectory of a run.

        Parameters
        ----------
        run
            The directory of `md run`, or its `trajectory.gsd`
        skip
            Frames to leave out at the beginning; by default those of the equilibration

        Raises
        ------
        MissingFileError
            If there is no trajectory; also a `FileNotFoundError`
        ValueError
            If no frame is left

        Examples
        --------
        >>> motion = pm.dynamics.Motion.read("squares")                # doctest: +SKIP
        >>> t, msd = motion.displacement()                             # doctest: +SKIP
        """
        frames = read_frames(run, skip)
        flat = frames[0].configuration.dimensions == 2

        def column(name: str) -> Numbers:
            return np.array([frame.log[name] for frame in frames], dtype=np.float64)

        return cls(
            times=column("time").reshape(len(frames)),
            positions=column("particles/unwrapped_position"),
            angles_rad=column("particles/unwrapped_angle").reshape(len(frames), -1) if flat else None,
            velocities=np.array([frame.particles.velocity for frame in frames], dtype=np.float64),
            spins=column("particles/spin"),
            box=np.array(frames[-1].configuration.box[:3], dtype=np.float64),
        )

    def lags(self) -> Numbers:
        """Times between frames, beginning with 0, (F,)."""
        return np.asarray(self.times - self.times[0])

    def displacement(self) -> tuple[Numbers, Numbers]:
        """Mean squared displacement of the centres: lags and values, (F,) each (freud, all origins)."""
        import freud

        centred = self.positions - self.positions.mean(axis=1, keepdims=True)
        found = freud.msd.MSD(mode="window").compute(centred).msd
        return self.lags(), np.asarray(found, dtype=np.float64)

    def turning(self) -> tuple[Numbers, Numbers]:
        """Mean squared angle of rotation in a plane."""
        return self.lags(), self._over_origins(lambda now, then: (now - then) ** 2, self._angles())

    def orientation(self, symmetry: int = 1) -> tuple[Numbers, Numbers]:
        """⟨cos n Δθ⟩ with n the symmetry of the polygon, whose corners cannot be told apart."""
        angles = symmetry * self._angles()
        return self.lags(), self._products_over_origins(np.stack([np.cos(angles), np.sin(angles)], axis=-1))

    def velocity(self) -> tuple[Numbers, Numbers]:
        """⟨v(0)·v(t)⟩/⟨v²⟩."""
        return self.lags(), self._correlation(self.velocities)

    def spinning(self) -> tuple[Numbers, Numbers]:
        """⟨L(0)·L(t)⟩/⟨L²⟩ of the angular momenta in the frames of the bodies."""
        return self.lags(), self._correlation(self.spins)

    def bond_order(self, k: int, neighbours: int, frame: int = -1) -> NDArray[np.complex128]:
        """ψ_{k,p} of each body (eq. 5.1): the mean of exp(i k θ) over the nearest `neighbours` (freud)."""
        import freud

        box = freud.box.Box(Lx=self.box[0], Ly=self.box[1], is2D=True)
        points = box.wrap(np.ascontiguousarray(self.positions[frame], dtype=np.float32) * [1.0, 1.0, 0.0])
        order = freud.order.Hexatic(k=k, weighted=False)
        order.compute((box, points), neighbors={"num_neighbors": neighbours, "exclude_ii": True})
        return np.asarray(order.particle_order, dtype=np.complex128)

    def _angles(self) -> Numbers:
        if self.angles_rad is None:
            raise ValueError("bodies in space have no angle; this is for bodies in a plane")
        return self.angles_rad

    @staticmethod
    def _over_origins(of: Callable[[Any, Any], Any], values: Numbers) -> Numbers:
        count = len(values)
        return np.array([np.mean(of(values[lag:], values[: count - lag])) for lag in range(count)])

    def _correlation(self, values: Numbers) -> Numbers:
        """⟨a(0)·a(t)⟩/⟨a²⟩; not a number where a is always zero, as are the spins of disks."""
        found = self._products_over_origins(values)
        return np.asarray(found / found[0]) if found[0] > 0.0 else np.full_like(found, np.nan)

    @staticmethod
    def _products_over_origins(values: Numbers) -> Numbers:
        """⟨a(0)·a(t)⟩ by a Fourier transform, with as many zeros as frames (Wiener and Khinchin)."""
        count, bodies = values.shape[:2]
        transformed = np.fft.rfft(values.reshape(count, -1), 2 * count, axis=0)
        power = np.sum(np.abs(transformed) ** 2, axis=1)
        sums = np.fft.irfft(power, 2 * count)[:count]
        return np.asarray(sums / (bodies * (count - np.arange(count))))


def free_flight_displacement(times: Numbers, mass: float, kt: float, dimension: int = 2) -> Numbers:
    """d kT t²/m, the mean squared displacement of bodies that do not meet.

    Examples
    --------
    >>> float(free_flight_displacement(np.array([0.1]), 1.0, 1.0)[0])
    0.020000000000000004
    """
    return np.asarray(dimension * kt / mass * np.asarray(times) ** 2)


def local_slope(times: Numbers, values: Numbers, points: int = 24) -> tuple[Numbers, Numbers]:
    """d ln(value)/d ln(t) at lags spaced evenly in their logarithm: 2 ballistic, 1 diffusive, less subdiffusive.

    Examples
    --------
    >>> t = np.arange(200.0)
    >>> bool(np.allclose(local_slope(t, 3.0 * t**2)[1], 2.0))
    True
    """
    last = (2 * len(times)) // 3
    picked = np.unique(np.geomspace(1, max(last, 2), points).astype(int))
    picked = picked[picked < len(times)]
    t, value = np.log(times[picked]), np.log(values[picked])
    slope = np.diff(value) / np.diff(t)
    return np.exp(0.5 * (t[1:] + t[:-1])), slope


def relaxation_time(times: Numbers, correlation: Numbers) -> float:
    """The time of exp(-t/τ) fitted to the values down to 1/e, by least squares of the logarithm through one.

    Not a number if the correlation does not fall to 1/e.

    Examples
    --------
    >>> t = np.linspace(0.0, 5.0, 400)
    >>> round(relaxation_time(t, np.exp(-t / 0.7)), 6)
    0.7
    """
    below = np.flatnonzero(correlation < np.exp(-1.0))
    if below.size == 0 or below[0] < 2:
        return float("nan")
    t, value = times[1 : below[0]], np.log(correlation[1 : below[0]])
    return float(-(t @ t) / (t @ value))


_CURVES = {
    "displacement": "mean squared displacement",
    "slope": "local slope",
    "turning": "mean squared angle (rad²)",
    "orientation": "⟨cos n Δθ⟩",
    "velocity": "⟨v(0)·v(t)⟩/⟨v²⟩",
    "spinning": "⟨L(0)·L(t)⟩/⟨L²⟩",
}


class Seeds:
    """Runs that differ in their seed alone: means and standard errors over them.

    Parameters
    ----------
    runs
        Directories of `md run`, or motions
    symmetry
        The n of `orientation`: the symmetry of the polygon

    Examples
    --------
    >>> squares = pm.dynamics.Seeds(["squares1", "squares2"], symmetry=4)   # doctest: +SKIP
    >>> squares.relaxation_times()                                     # doctest: +SKIP
    >>> squares.plot(quantity="slope")                                 # doctest: +SKIP
    """

    def __init__(self, runs: Sequence[Motion | Path | str], *, symmetry: int = 1) -> None:
        self.motions = [run if isinstance(run, Motion) else Motion.read(run) for run in runs]
        self.symmetry = symmetry

    def curve(self, quantity: str) -> tuple[Numbers, Numbers, Numbers]:
        """Lags, means and standard errors (NaN for one run) of a quantity.

        Parameters
        ----------
        quantity
            `displacement`, `slope`, `turning`, `orientation`, `velocity` or `spinning`
        """
        found = [self._of(motion, quantity) for motion in self.motions]
        return found[0][0], *_mean_and_error(np.array([values for _, values in found]))

    def _of(self, motion: Motion, quantity: str) -> tuple[Numbers, Numbers]:
        match quantity:
            case "displacement":
                return motion.displacement()
            case "slope":
                return local_slope(*motion.displacement())
            case "turning":
                return motion.turning()
            case "orientation":
                return motion.orientation(self.symmetry)
            case "velocity":
                return motion.velocity()
            case "spinning":
                return motion.spinning()
            case _:
                unknown("quantity", quantity, _CURVES)

    def relaxation_times(self) -> dict[str, tuple[float, float]]:
        """Of the velocities, of the angular momenta and, in a plane, of the orientations.

        Mean and standard error over the runs; not a number where a run is too short for the correlation to fall to 1/e.
        """
        quantities = ["velocity", "spinning"]
        if all(motion.angles_rad is not None for motion in self.motions):
            quantities.append("orientation")
        times = {}
        for quantity in quantities:
            found = np.array([relaxation_time(*self._of(motion, quantity)) for motion in self.motions])
            mean, error = _mean_and_error(found)
            times[quantity] = (float(mean), float(error))
        return times

    def bond_order(self, k: int, neighbours: int, frames: int = 5) -> tuple[float, float]:
        """⟨|ψ_{k,p}|⟩ over bodies and the last frames: mean and standard error over the runs."""
        found = []
        for motion in self.motions:
            last = range(1, min(frames, len(motion.times)) + 1)
            found.append(np.mean([np.abs(motion.bond_order(k, neighbours, -frame)).mean() for frame in last]))
        mean, error = _mean_and_error(np.array(found))
        return float(mean), float(error)

    def plot(self, ax: Axes | None = None, *, quantity: str = "displacement") -> Axes:
        """A quantity against the lag with its standard error, in logarithmic axes where it is never negative."""
        if quantity not in _CURVES:
            unknown("quantity", quantity, _CURVES)
        t, mean, error = self.curve(quantity)
        ax = new_axes(ax)
        if quantity != "slope":
            t, mean, error = t[1:], mean[1:], error[1:]
        ax.errorbar(t, mean, yerr=None if np.isnan(error).all() else error, linewidth=1)
        ax.set_xscale("log")
        if quantity in ("displacement", "turning"):
            ax.set_yscale("log")
        ax.set_xlabel("time")
        ax.set_ylabel(_CURVES[quantity])
        return ax


def _mean_and_error(values: Numbers) -> tuple[Any, Any]:
    mean = values.mean(axis=0)
    if len(values) < 2:
        return mean, np.full_like(mean, np.nan)
    return mean, values.std(axis=0, ddof=1) / np.sqrt(len(values))
