"""Bodies in motion: displacements, correlations, relaxation times, cages and bond-orientational order.

`Motion.read` takes the trajectory of a run of `md run`; `Seeds` holds runs that differ in their seed, and gives means with
standard errors over them. Displacements and bond-orientational order are those of freud (`pip install protomer[dynamics]`).

Definitions: lags t are counted from every frame; the drift of the centre of mass is taken off; angles are followed through
full turns. Times are in the unit of the run. Quantities that are no sums of products, and so cannot be Fourier transformed, are
computed at lags spaced evenly in their logarithm.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _displacements, _turns
from ._errors import unknown
from ._frames import read_frames, vertices_of
from ._chart import new_axes
from ._rotations import between, invariants, symmetric_character, turned_vectors
from .structure import rotations_of

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
    orientations
        Quaternions w, x, y, z, (F, N, 4), or None
    vertices
        Of the shape, in the frame of a body, (V, 3); None where the trajectory has none, or several shapes
    """

    times: Numbers
    positions: Numbers
    angles_rad: Numbers | None
    velocities: Numbers
    spins: Numbers
    box: Numbers
    orientations: Numbers | None = None
    vertices: Numbers | None = None

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
            orientations=np.array([frame.particles.orientation for frame in frames], dtype=np.float64),
            vertices=vertices_of(frames[0]),
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

    def orientation_in_space(self, degree: int | None = None, *, symmetry: ArrayLike | None = None) -> tuple[Numbers, Numbers]:
        """Correlation of the orientations of bodies in space that look alike after each rotation of their symmetry.

        C_l(t) = ⟨Σ_g χ_l(R(0)⁻¹ R(t) g)⟩ / Σ_g χ_l(g), over the symmetries g, with χ_l(ω) = sin((l + ½)ω)/sin(½ω): 1 while a body
        keeps its orientation or takes one that looks the same, 0 when it has forgotten it. Without symmetry it is the mean of
        ⟨P_l(u(0)·u(t))⟩ over all axes u of the body. Bodies that turn by isotropic Brownian motion have exp(-l(l + 1) D t).

        Parameters
        ----------
        degree
            l; the least that the symmetry allows without it: 3 for tetrahedra, 4 for cubes, 6 for icosahedra, 1 without symmetry
        symmetry
            Rotations of the shape, quaternions (S, 4); those of `vertices` without it

        Raises
        ------
        ValueError
            If bodies are in a plane, or nothing of this degree has the symmetry
        """
        orientations = self._orientations()
        if symmetry is None:
            symmetry = [[1.0, 0.0, 0.0, 0.0]] if self.vertices is None else rotations_of(self.vertices)
        group = np.asarray(symmetry, dtype=np.float64)
        allowed = [number for number in range(1, 13) if invariants(group, number) > 0]
        degree = allowed[0] if degree is None else degree
        if degree < 1 or invariants(group, degree) == 0:
            raise ValueError(
                f"no function of degree {degree} keeps its form under the {len(group)} rotations of the shape; take one of "
                f"{', '.join(map(str, allowed[:5]))}"
            )
        still = float(symmetric_character(np.array([1.0, 0.0, 0.0, 0.0]), group, degree))
        return self._at_lags(
            lambda lag: np.mean(symmetric_character(between(orientations[:-lag], orientations[lag:]), group, degree)) / still
        )

    def axis(self, direction: ArrayLike, degree: int = 2) -> tuple[Numbers, Numbers]:
        """⟨P_l(u(0)·u(t))⟩ of an axis u in the frame of the bodies, for example the long one of ellipsoids.

        Parameters
        ----------
        direction
            In the frame of a body, (3,)
        degree
            l, 1 or more; even where both ends look the same
        """
        unit = np.asarray(direction, dtype=np.float64)
        axes = turned_vectors(self._orientations(), unit / np.linalg.norm(unit))
        legendre = np.polynomial.Legendre.basis(degree)
        return self._at_lags(lambda lag: np.mean(legendre(np.sum(axes[lag:] * axes[:-lag], axis=-1))))

    def turning_in_space(self) -> tuple[Numbers, Numbers]:
        """Mean squared turn of bodies in space, through full turns.

        It is 6 D t for isotropic Brownian rotation and ω² t² for free rotation about a principal axis. The turns from frame to frame are rotation vectors, which are added up; so bodies must turn by less than π between frames.
        """
        turns = _turns.followed(self._orientations())
        picked = self._picked()
        values = [float(np.mean(np.sum((turns[lag:] - turns[: len(turns) - lag]) ** 2, axis=-1))) for lag in picked]
        return self.lags()[picked], np.array(values)

    def displacement_in_frame(self) -> tuple[Numbers, Numbers]:
        """⟨Δr Δrᵀ⟩ in the frame that each body had before: lags, (L,), and matrices, (L, d, d).

        The sum of the diagonal is the mean squared displacement. A body that diffuses faster along an axis has 2 D t of that axis at
        first, and a third (in a plane a half) of the displacement in each direction when it has forgotten its orientation.
        """
        frames, track = self._frames(), self._track()
        picked = self._picked()
        moved = (_turns.in_frames(frames, track, int(lag)) for lag in picked)
        return self.lags()[picked], np.array([_turns.mean_product(one, one) for one in moved])

    def displacement_with_turn(self) -> tuple[Numbers, Numbers]:
        """⟨Δr Δφᵀ⟩ of displacements and turns in the frame that each body had before: lags, (L,), and matrices, (L, 3, 3).

        Rows are those of the displacement. A body that moves along its axis as it turns about it, like a screw, has its pitch
        times the mean squared turn there; bodies with planes of symmetry have nothing along the axes of these. In a plane there is
        one turn, and a column, (L, 2, 1).
        """
        frames, track, turns = self._frames(), self._track(), self._turned()
        picked = self._picked()
        found = []
        for lag in picked:
            # In a plane a turn is the same in all frames.
            change = turns[lag:] - turns[: len(turns) - lag] if turns.shape[2] == 1 else _turns.in_frames(frames, turns, int(lag))
            found.append(_turns.mean_product(_turns.in_frames(frames, track, int(lag)), change))
        return self.lags()[picked], np.array(found)

    def coupling(self) -> tuple[Numbers, Numbers]:
        """⟨Δr² Δφ²⟩/(⟨Δr²⟩⟨Δφ²⟩) - 1 of displacements and turns.

        It is 0 where they are independent, as in free flight, above 0 where bodies that move far also turn far, and below 0 where
        a turn costs a displacement. The first lag is one frame.
        """
        track, turns = self._track(), self._turned()
        picked = self._picked()[1:]
        values = [
            _turns.correlation_of_squares(track[lag:] - track[: len(track) - lag], turns[lag:] - turns[: len(turns) - lag])
            for lag in picked
        ]
        return self.lags()[picked], np.array(values)

    def non_gaussian(self) -> tuple[Numbers, Numbers]:
        """α₂ = d⟨r⁴⟩/((d + 2)⟨r²⟩²) - 1 of the displacements: 0 for free flight and for diffusion, above it where bodies differ.

        The first lag is one frame.
        """
        track = self._track()
        lags, found = self._at_lags(lambda lag: _displacements.non_gaussian(track, lag))
        return lags[1:], found[1:]

    def non_gaussian_turning(self) -> tuple[Numbers, Numbers]:
        """⟨Δθ⁴⟩/(3⟨Δθ²⟩²) - 1 of the angles of rotation in a plane; the first lag is one frame."""
        track = self._angles()[:, :, None]
        lags, found = self._at_lags(lambda lag: _displacements.non_gaussian(track, lag))
        return lags[1:], found[1:]

    def van_hove(self, time: float, r_max: float, bins: int = 60) -> tuple[Numbers, Numbers]:
        """Distances and the self part of the van Hove function G_s(r, t), (B,) each.

        G_s is the density of displacements per area or volume: its integral over the plane or space is 1.

        Parameters
        ----------
        time
            The lag; that of the nearest frame is taken
        r_max
            The largest displacement
        """
        edges = np.linspace(0.0, r_max, bins + 1)
        return 0.5 * (edges[1:] + edges[:-1]), _displacements.van_hove(self._track(), self._frames_in(time), edges)

    def intermediate(self, wave_number: float) -> tuple[Numbers, Numbers]:
        """The self-intermediate scattering function F_s(k, t) = ⟨exp(i k·Δr)⟩, averaged over the directions of k.

        Diffusion has exp(-k² D t), free flight exp(-k² kT t²/(2m)). `relaxation_time` fits its decay.
        """
        track = self._track()
        return self._at_lags(lambda lag: _displacements.intermediate(track, lag, wave_number))

    def staying(self, distance: float, *, origins: int = 50) -> tuple[Numbers, Numbers]:
        """The part of bodies that have never been farther than a distance from where they were, against the time since then.

        Bodies that leave and come back count as gone. Times between frames are not seen, so that frames must be close
        compared with the time that bodies stay.

        Parameters
        ----------
        distance
            The radius of the cage, for example the displacement at which the local slope is least
        origins
            Frames from which displacements are counted, evenly spaced over the first half of the run
        """
        found = _displacements.staying(self._track(), distance, origins)
        return self.lags()[: len(found)], found

    def escape_time(self, distance: float, *, origins: int = 50) -> float:
        """The time after which the part of `staying` bodies falls to 1/e, between frames along a straight line.

        Not a number if the run is too short for it.
        """
        times, part = self.staying(distance, origins=origins)
        below = np.flatnonzero(part < np.exp(-1.0))
        if below.size == 0:
            return float("nan")
        after = int(below[0])
        return float(np.interp(-np.exp(-1.0), -part[after - 1 : after + 1], times[after - 1 : after + 1]))

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
            raise ValueError("bodies in space have no angle; take orientation_in_space, or axis")
        return self.angles_rad

    def _orientations(self) -> Numbers:
        if self.angles_rad is not None:
            raise ValueError("bodies in a plane turn by an angle; take orientation, or turning")
        if self.orientations is None:
            raise ValueError("this motion has no orientations; give quaternions, (F, N, 4)")
        return self.orientations

    def _turned(self) -> Numbers:
        """Turns since the first frame, through full turns, (F, N, 3); in a plane (F, N, 1)."""
        return _turns.followed(self._orientations()) if self.angles_rad is None else self.angles_rad[..., None]

    def _frames(self) -> Numbers:
        """Rotations from the frames of the bodies to that of the box, (F, N, d, d)."""
        return _turns.matrices(self._orientations()) if self.angles_rad is None else _turns.angle_matrices(self.angles_rad)

    def _picked(self) -> NDArray[np.int64]:
        """0, and numbers of frames that are evenly spaced in their logarithm."""
        return np.concatenate([np.zeros(1, dtype=np.int64), _spaced(len(self.times) - 1, 60)])

    def _track(self) -> Numbers:
        """Places without the drift of the centre of mass, (F, N, d)."""
        places = self.positions[:, :, : 2 if self.box[2] == 0 else 3]
        return np.asarray(places - places.mean(axis=1, keepdims=True))

    def _frames_in(self, time: float) -> int:
        lags = self.lags()
        lag = int(np.argmin(np.abs(lags - time)))
        if lag == 0:
            step = f"the time between frames is {lags[1]:g} and their last {lags[-1]:g}" if len(lags) > 1 else "there is one frame"
            raise ValueError(f"no frames are {time:g} apart; {step}")
        return lag

    def _at_lags(self, of: Callable[[int], Any]) -> tuple[Numbers, Numbers]:
        """A correlation at 0, where it is 1, and at lags spaced evenly in their logarithm."""
        picked = _spaced(len(self.times) - 1, 60)
        values = np.array([1.0, *(float(of(int(lag))) for lag in picked)])
        return self.lags()[[0, *picked]], values

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
    picked = _spaced(min(max((2 * len(times)) // 3, 2), len(times) - 1), points)
    t, value = np.log(times[picked]), np.log(values[picked])
    slope = np.diff(value) / np.diff(t)
    return np.exp(0.5 * (t[1:] + t[:-1])), slope


def _spaced(last: int, points: int) -> NDArray[np.int64]:
    """Numbers of frames from 1 to the last, evenly spaced in their logarithm."""
    picked = np.unique(np.geomspace(1, max(last, 1), points).astype(np.int64))
    return picked[picked <= last]


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
    "orientation_in_space": "C_l(t) of orientations",
    "non_gaussian": "non-Gaussian parameter",
    "non_gaussian_turning": "non-Gaussian parameter of angles",
    "turning_in_space": "mean squared turn (rad²)",
    "coupling": "⟨Δr²Δφ²⟩/(⟨Δr²⟩⟨Δφ²⟩) - 1",
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

    def curve(self, quantity: str | Callable[[Motion], tuple[Numbers, Numbers]]) -> tuple[Numbers, Numbers, Numbers]:
        """Lags, means and standard errors (NaN for one run) of a quantity.

        Parameters
        ----------
        quantity
            `displacement`, `slope`, `turning`, `orientation`, `orientation_in_space`, `non_gaussian`, `non_gaussian_turning`,
            `turning_in_space`, `coupling`, `velocity`, `spinning`, or a function of a motion that gives lags and values

        Examples
        --------
        >>> squares.curve(lambda motion: motion.intermediate(6.0))     # doctest: +SKIP
        """
        found = [self._of(motion, quantity) for motion in self.motions]
        return found[0][0], *_mean_and_error(np.array([values for _, values in found]))

    def _of(self, motion: Motion, quantity: str | Callable[[Motion], tuple[Numbers, Numbers]]) -> tuple[Numbers, Numbers]:
        if callable(quantity):
            return quantity(motion)
        match quantity:
            case "displacement":
                return motion.displacement()
            case "slope":
                return local_slope(*motion.displacement())
            case "turning":
                return motion.turning()
            case "orientation":
                return motion.orientation(self.symmetry)
            case "orientation_in_space":
                return motion.orientation_in_space()
            case "non_gaussian":
                return motion.non_gaussian()
            case "non_gaussian_turning":
                return motion.non_gaussian_turning()
            case "turning_in_space":
                return motion.turning_in_space()
            case "coupling":
                return motion.coupling()
            case "velocity":
                return motion.velocity()
            case "spinning":
                return motion.spinning()
            case _:
                unknown("quantity", quantity, _CURVES)

    def relaxation_times(self) -> dict[str, tuple[float, float]]:
        """Of the velocities, of the angular momenta and of the orientations (`orientation`, or `orientation_in_space`).

        Mean and standard error over the runs; not a number where a run is too short for the correlation to fall to 1/e.
        """
        quantities = ["velocity", "spinning"]
        if all(motion.angles_rad is not None for motion in self.motions):
            quantities.append("orientation")
        elif all(motion.orientations is not None for motion in self.motions):
            quantities.append("orientation_in_space")
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
        if quantity in ("displacement", "turning", "turning_in_space"):
            ax.set_yscale("log")
        ax.set_xlabel("time")
        ax.set_ylabel(_CURVES[quantity])
        return ax


def _mean_and_error(values: Numbers) -> tuple[Any, Any]:
    mean = values.mean(axis=0)
    if len(values) < 2:
        return mean, np.full_like(mean, np.nan)
    return mean, values.std(axis=0, ddof=1) / np.sqrt(len(values))
