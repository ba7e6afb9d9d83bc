"""Order among bodies: radial distribution, bond order, diamonds, layers, diffraction, potentials of mean force and torque.

`Structure.read` takes the trajectory of `hpmc run` or `md run`. What freud has is freud's (`pip install protomer[dynamics]`).
Lengths are in the unit of the run.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._frames import read_frames, vertices_of
from ._chart import new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Autocorrelation", "Diamonds", "MeanForce", "MeanTorque", "Structure", "rotations_of"]

Numbers = NDArray[np.float64]

# Mean cosines of three dihedral angles: -1 staggered, 1 eclipsed.
_CLEARLY = 0.5
# Bonds within this angle of a direction are counted as along it.
_ALONG = np.cos(np.radians(10.0))


@dataclass(frozen=True)
class Diamonds:
    """Bodies as parts of diamonds.

    In cubic diamond all four contacts of a body are staggered, seen along the contact; in hexagonal diamond one of them is
    eclipsed.

    Attributes
    ----------
    cubic, hexagonal
        Whether each body is in such a crystal, (N,)
    contacts
        Pairs that are among the four nearest of each other, (C, 2)
    conformation
        Mean of cos 3φ over the nine dihedral angles φ of each contact, (C,): -1 staggered, 1 eclipsed
    """

    cubic: NDArray[np.bool_]
    hexagonal: NDArray[np.bool_]
    contacts: NDArray[np.int64]
    conformation: Numbers


@dataclass(frozen=True)
class Autocorrelation:
    """C(Δx, Δy, Δz)/C(0) of Gaussians at the centres of bodies (eq. 2.3), not periodic.

    Attributes
    ----------
    lateral
        Δx and Δy of the grid, (K,)
    heights
        Δz, (H,), from 0
    values
        (K, K, H)
    """

    lateral: Numbers
    heights: Numbers
    values: Numbers

    def layer(self, height: float) -> Numbers:
        """The plane nearest to this Δz, (K, K)."""
        return np.asarray(self.values[:, :, int(np.argmin(np.abs(self.heights - height)))])

    def plot(self, ax: Axes | None = None, *, height: float = 0.0) -> Axes:
        """The plane nearest to this Δz."""
        ax = new_axes(ax)
        ax.pcolormesh(self.lateral, self.lateral, self.layer(height).T, shading="nearest")
        ax.set_aspect("equal")
        ax.set_xlabel("Δx")
        ax.set_ylabel("Δy")
        return ax


@dataclass(frozen=True)
class MeanForce:
    """The potential of mean force around a body: -ln of the density of others in its frame over that of an ideal gas, kT.

    It is not shifted: 0 is an ideal gas. Orientations of the others are averaged over (`mean_torque` keeps them).

    Attributes
    ----------
    coordinates
        Of the grid along each axis of the body, (K,)
    values_kt
        (K, K, K) in space, (K, K) in a plane; infinite where no body was seen
    """

    coordinates: Numbers
    values_kt: Numbers

    def along(self, direction: ArrayLike) -> tuple[Numbers, Numbers]:
        """Distances from the centre and the potential along a direction in the frame of the body, (3,), or (2,) in a plane."""
        unit = np.asarray(direction, dtype=np.float64)[: self.values_kt.ndim]
        unit = unit / np.linalg.norm(unit)
        step = self.coordinates[1] - self.coordinates[0]
        distances = np.arange(0.0, self.coordinates[-1], 0.5 * step)
        cells = np.rint((distances[:, None] * unit - self.coordinates[0]) / step).astype(int)
        return distances, np.asarray(self.values_kt[tuple(cells.T)])

    def well(self, direction: ArrayLike) -> tuple[float, float]:
        """Distance and depth (kT) of the least value along a direction."""
        distances, values = self.along(direction)
        least = int(np.argmin(values))
        return float(distances[least]), float(values[least])

    def plot(self, ax: Axes | None = None, *, directions: dict[str, ArrayLike]) -> Axes:
        """The potential along directions, by name."""
        ax = new_axes(ax)
        for name, direction in directions.items():
            distances, values = self.along(direction)
            seen = np.isfinite(values)
            ax.plot(distances[seen], values[seen], label=name, linewidth=1)
        ax.set_xlabel("distance")
        ax.set_ylabel("potential of mean force (kT)")
        ax.legend()
        return ax


@dataclass(frozen=True)
class MeanTorque:
    """The potential of mean force and torque of two bodies in a plane: of the place of the other one and of the angle between both.

    Attributes
    ----------
    coordinates
        Of the grid along each axis of the body, (K,)
    angles_rad
        Of the other body in the frame of the first, (A,); from 0 to 2π over the symmetry, periodic
    values_kt
        (K, K, A): -ln of the density over that of an ideal gas; infinite where no body was seen
    """

    coordinates: Numbers
    angles_rad: Numbers
    values_kt: Numbers

    def mean_force(self) -> MeanForce:
        """The potential with the angle averaged over."""
        with np.errstate(divide="ignore"):
            return MeanForce(self.coordinates, -np.log(np.mean(np.exp(-self.values_kt), axis=2)))

    def against_angle(self, point: ArrayLike) -> tuple[Numbers, Numbers]:
        """Angles and the potential of bodies whose centres are in the bin of a point in the frame of the body, (2,)."""
        step = self.coordinates[1] - self.coordinates[0]
        x, y = np.rint((np.asarray(point, dtype=np.float64)[:2] - self.coordinates[0]) / step).astype(int)
        return self.angles_rad, self.values_kt[x, y]


@dataclass(frozen=True)
class Structure:
    """Where bodies are, frame by frame.

    Attributes
    ----------
    positions
        Centres in the box, (F, N, 3)
    orientations
        Quaternions w, x, y, z, (F, N, 4)
    boxes
        Lx, Ly, Lz and tilt factors xy, xz, yz, (F, 6); in a plane Lz is 0
    vertices
        Of the shape, in the frame of a body, (V, 3); None where the trajectory has none, or several shapes
    """

    positions: Numbers
    orientations: Numbers
    boxes: Numbers
    vertices: Numbers | None = None

    @classmethod
    def read(cls, run: Path | str, *, skip: int | None = None) -> Structure:
        """Reads the trajectory of a run.

        Parameters
        ----------
        run
            The directory of `hpmc run` or `md run`, or its `trajectory.gsd`
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
        >>> crystal = pm.structure.Structure.read("tetrahedra")       # doctest: +SKIP
        >>> crystal.diamond().cubic.mean()                            # doctest: +SKIP
        """
        frames = read_frames(run, skip)

        def column(of: Any) -> Numbers:
            return np.array([of(frame) for frame in frames], dtype=np.float64)

        return cls(
            positions=column(lambda frame: frame.particles.position),
            orientations=column(lambda frame: frame.particles.orientation),
            boxes=column(lambda frame: _box_of(frame.configuration)),
            vertices=vertices_of(frames[0]),
        )

    def radial_distribution(self, r_max: float | None = None, bins: int = 100) -> tuple[Numbers, Numbers]:
        """Distances and g(r), (B,) each, over all frames (freud).

        Parameters
        ----------
        r_max
            Largest distance; half of the least edge without it
        """
        import freud

        edges = self.boxes[:, :3]
        r_max = r_max or 0.49 * float(edges[edges > 0].min())
        found = freud.density.RDF(bins=bins, r_max=r_max)
        for frame in range(len(self.positions)):
            found.compute(self._system(frame), reset=False)
        return np.asarray(found.bin_centers, dtype=np.float64), np.asarray(found.rdf, dtype=np.float64)

    def steinhardt(self, degree: int, neighbours: int, frame: int = -1) -> Numbers:
        """q_l of each body over its nearest neighbours, (N,) (freud): q6 of 12 neighbours is 0.575 in fcc, 0.485 in hcp."""
        import freud

        order = freud.order.Steinhardt(l=degree)
        order.compute(self._system(frame), neighbors={"num_neighbors": neighbours, "exclude_ii": True})
        return np.asarray(order.particle_order, dtype=np.float64)

    def diamond(self, frame: int = -1) -> Diamonds:
        """Which bodies are in cubic and which in hexagonal diamond."""
        nearest, bonds = self._four_nearest(frame)
        mutual = [(i, k) for i, row in enumerate(nearest) for k, j in enumerate(row) if i < j and i in nearest[j]]
        contacts = np.array([(i, nearest[i][k]) for i, k in mutual], dtype=np.int64).reshape(-1, 2)
        conformation = np.array([_conformation(nearest, bonds, i, k) for i, k in mutual])
        count = len(nearest)

        def ends_of(chosen: NDArray[np.bool_]) -> NDArray[np.int64]:
            return np.bincount(contacts[chosen].ravel(), minlength=count)

        staggered, eclipsed = ends_of(conformation < -_CLEARLY), ends_of(conformation > _CLEARLY)
        return Diamonds(
            cubic=staggered == 4,
            hexagonal=(staggered == 3) & (eclipsed == 1),
            contacts=contacts,
            conformation=conformation,
        )

    def contact_axis(self, frame: int = -1) -> Numbers:
        """The direction along which most bodies have one of their four nearest, (3,): a (111) axis of a diamond."""
        _, bonds = self._four_nearest(frame)
        units = bonds.reshape(-1, 3)
        units = units / np.linalg.norm(units, axis=1, keepdims=True)
        cosines = units @ units[:: max(1, len(units) // 500)].T
        best = int(np.argmax((np.abs(cosines) > _ALONG).sum(axis=0)))
        close = np.abs(cosines[:, best]) > _ALONG
        axis = (np.sign(cosines[close, best])[:, None] * units[close]).mean(axis=0)
        return np.asarray(axis / np.linalg.norm(axis))

    def autocorrelation(
        self, *, up: ArrayLike = (0.0, 0.0, 1.0), spacing: float, width: float, reach: float, frame: int = -1
    ) -> Autocorrelation:
        """How well the bodies fall on themselves when they are shifted (eq. 2.3; freud's Gaussians, an FFT padded with zeros).

        Parameters
        ----------
        up
            The direction that becomes z; `contact_axis` gives that of the layers of a diamond
        spacing
            Of the grid
        width
            Standard deviation of the Gaussians
        reach
            The largest shift
        """
        import freud

        points = self.positions[frame] @ _turn_onto_z(up).T
        extent = np.ptp(points, axis=0)
        # Shifts up to the reach must not meet images.
        cells = np.ceil((extent + reach + 8.0 * width) / spacing).astype(int)
        box = freud.box.Box(*(cells * spacing))
        centred = points - 0.5 * (points.max(axis=0) + points.min(axis=0))
        density = freud.density.GaussianDensity(tuple(int(n) for n in cells), r_max=4.0 * width, sigma=width)
        density.compute((box, centred.astype(np.float32)))
        spectrum = np.fft.rfftn(density.density)
        correlation = np.fft.irfftn(np.abs(spectrum) ** 2, s=tuple(cells), axes=(0, 1, 2))
        count = int(reach / spacing)
        shifts = np.arange(-count, count + 1)
        values = correlation[np.ix_(shifts % cells[0], shifts % cells[1], np.arange(count + 1))]
        return Autocorrelation(
            lateral=np.asarray(shifts * spacing, dtype=np.float64),
            heights=np.asarray(np.arange(count + 1) * spacing, dtype=np.float64),
            values=np.asarray(values / correlation[0, 0, 0], dtype=np.float64),
        )

    def diffraction(
        self, *, along: ArrayLike = (0.0, 0.0, 1.0), k_max: float, size: int = 257, frame: int = -1
    ) -> tuple[Numbers, Numbers]:
        """Wave numbers (S,) and |Σ exp(-i k·r)|²/N over wave vectors across a direction, (S, S).

        The bodies of the box scatter as one finite crystal. (The pattern of freud 3.4 is distorted where the view is not along an
        edge of the box.)

        Parameters
        ----------
        along
            The direction from which the crystal is seen
        k_max
            The largest wave number, 2π over a length
        size
            Points along each axis; an odd number has one at 0
        """
        across = self.positions[frame] @ _turn_onto_z(along).T
        k = np.linspace(-k_max, k_max, size)
        # The sum over bodies of a product of waves in x and in y is a product of matrices.
        waves = [np.exp(-1j * k[:, None] * across[None, :, axis]) for axis in (0, 1)]
        return k, np.abs(waves[0] @ waves[1].T) ** 2 / len(across)

    def mean_force(self, reach: float, bins: int = 61, *, symmetry: ArrayLike | None = None) -> MeanForce:
        """The potential of mean force around a body, in its frame, over all frames (freud).

        Parameters
        ----------
        reach
            Largest coordinate along each axis; √3 times it, in a plane √2 times, must be below half of the box
        bins
            Along each axis; an odd number has a bin at the centre
        symmetry
            Rotations of the shape, quaternions (S, 4); those of `vertices` without it

        Raises
        ------
        ValueError
            If the corners of the grid are beyond half of the box
        """
        import freud

        self._check_reach(reach)
        centres = np.linspace(-reach, reach, bins, endpoint=False) + reach / bins
        if self._flat():
            return MeanForce(coordinates=centres, values_kt=self._mean_force_in_a_plane(reach, bins, symmetry))
        equivalent = self._symmetry(symmetry).astype(np.float32)
        found = freud.pmft.PMFTXYZ(reach, reach, reach, bins)
        for frame in range(len(self.positions)):
            found.compute(
                self._system(frame), self.orientations[frame].astype(np.float32), equiv_orientations=equivalent, reset=False
            )
        return MeanForce(coordinates=centres, values_kt=np.asarray(found.pmft, dtype=np.float64))

    def mean_torque(
        self, reach: float, bins: int = 41, angles: int = 24, *, symmetry: ArrayLike | None = None
    ) -> MeanTorque:
        """The potential of mean force and torque of two bodies in a plane, over all frames.

        Parameters
        ----------
        reach
            Largest coordinate along each axis; √2 times it must be below half of the box
        bins
            Along each axis; an odd number has a bin at the centre
        angles
            Bins of the angle between both bodies, over 2π divided by the symmetry
        symmetry
            Rotations of the shape, quaternions (S, 4); those of `vertices` without it

        Raises
        ------
        ValueError
            If bodies are in space, or the corners of the grid are beyond half of the box
        """
        import freud

        if not self._flat():
            raise ValueError("mean_torque is for bodies in a plane; in space mean_force averages over orientations")
        self._check_reach(reach)
        turns = self._turns_in_a_plane(symmetry)
        period = 2.0 * np.pi / len(turns)
        edges = [np.linspace(-reach, reach, bins + 1)] * 2 + [np.linspace(0.0, period, angles + 1)]
        seen, expected = np.zeros((bins, bins, angles)), 0.0
        cell = (2.0 * reach / bins) ** 2 / angles
        for frame in range(len(self.positions)):
            box, points = self._system(frame)
            query = freud.locality.AABBQuery(box, points).query(points, {"r_max": np.sqrt(2.0) * reach, "exclude_ii": True})
            pairs = query.toNeighborList()
            first, other = np.asarray(pairs.query_point_indices), np.asarray(pairs.point_indices)
            way = np.asarray(box.wrap(points[other] - points[first]), dtype=np.float64)[:, :2]
            angle = _angle(self.orientations[frame])
            between = np.mod(angle[other] - angle[first], period)
            for turn in turns:
                cosine, sine = np.cos(angle[first] + turn), np.sin(angle[first] + turn)
                x, y = way[:, 0] * cosine + way[:, 1] * sine, way[:, 1] * cosine - way[:, 0] * sine
                seen += np.histogramdd((x, y, between), bins=edges)[0]
            expected += len(turns) * len(points) * len(points) / box.volume * cell
        with np.errstate(divide="ignore"):
            values = -np.log(seen / expected)
        middles = [0.5 * (edge[1:] + edge[:-1]) for edge in edges]
        return MeanTorque(coordinates=middles[0], angles_rad=middles[2], values_kt=values)

    def _mean_force_in_a_plane(self, reach: float, bins: int, symmetry: ArrayLike | None) -> Numbers:
        import freud

        found = freud.pmft.PMFTXY(reach, reach, bins)
        for frame in range(len(self.positions)):
            angle = _angle(self.orientations[frame])
            for turn in self._turns_in_a_plane(symmetry):
                found.compute(self._system(frame), (angle + turn).astype(np.float32), reset=False)
        return np.asarray(found.pmft, dtype=np.float64)

    def _flat(self) -> bool:
        return bool(self.boxes[0, 2] == 0)

    def _check_reach(self, reach: float) -> None:
        """The grid's corners must not meet images, which are nearer than half of the least distance between faces."""
        import freud

        room = np.inf
        for box in self.boxes:
            edges = freud.box.Box(*box, is2D=self._flat()).to_matrix()[: self._dimension(), : self._dimension()]
            room = min(room, float((1.0 / np.linalg.norm(np.linalg.inv(edges), axis=1)).min()))
        corner = np.sqrt(float(self._dimension()))
        if corner * reach >= 0.5 * room:
            raise ValueError(
                f"a grid with a reach of {reach:g} has corners beyond half of the box, whose faces are {room:g} apart; "
                f"the reach must be below {0.5 * room / corner:.4g}"
            )

    def _dimension(self) -> int:
        return 2 if self._flat() else 3

    def _symmetry(self, given: ArrayLike | None) -> Numbers:
        if given is not None:
            return np.asarray(given, dtype=np.float64)
        return np.array([[1.0, 0.0, 0.0, 0.0]]) if self.vertices is None else rotations_of(self.vertices)

    def _turns_in_a_plane(self, given: ArrayLike | None) -> Numbers:
        """Angles of the symmetries that leave a body in its plane without turning it over."""
        group = self._symmetry(given)
        kept = group[np.all(np.abs(group[:, 1:3]) < 1e-4, axis=1)]
        return _angle(kept)

    def _system(self, frame: int) -> tuple[Any, NDArray[np.float32]]:
        import freud

        box = self.boxes[frame]
        return freud.box.Box(*box, is2D=bool(box[2] == 0)), self.positions[frame].astype(np.float32)

    def _four_nearest(self, frame: int) -> tuple[NDArray[np.int64], Numbers]:
        """Indices of the four nearest bodies, (N, 4), and the way to each, (N, 4, 3)."""
        import freud

        box, points = self._system(frame)
        query = freud.locality.AABBQuery(box, points)
        found = query.query(points, {"num_neighbors": 4, "exclude_ii": True}).toNeighborList()
        nearest = np.asarray(found.point_indices, dtype=np.int64).reshape(-1, 4)
        ways = box.wrap(points[nearest].reshape(-1, 3) - np.repeat(points, 4, axis=0))
        return nearest, np.asarray(ways, dtype=np.float64).reshape(-1, 4, 3)


def rotations_of(vertices: ArrayLike) -> Numbers:
    """Rotations that map a shape onto itself, quaternions w, x, y, z, (S, 4).

    Examples
    --------
    >>> cube = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    >>> len(rotations_of(cube))
    24
    """
    points = np.asarray(vertices, dtype=np.float64)
    points = points - points.mean(axis=0)
    size = np.abs(points).max()
    # Two vertices that are not in line with the centre fix a rotation.
    first = points[int(np.argmax(np.linalg.norm(points, axis=1)))]
    across = np.linalg.norm(np.cross(first, points), axis=1)
    second = points[int(np.argmax(across))]
    home = _frame_of(first, second)
    found = []
    for a in points:
        for b in points:
            if abs(a @ a - first @ first) + abs(b @ b - second @ second) + abs(a @ b - first @ second) > 1e-6 * size**2:
                continue
            rotation = _frame_of(a, b) @ home.T
            gaps = np.linalg.norm((points @ rotation.T)[:, None] - points[None], axis=2)
            if gaps.min(axis=1).max() < 1e-5 * size:
                found.append(_quaternion(rotation))
    return np.array(found)


def _angle(quaternions: Numbers) -> Numbers:
    """Angles of rotations about z, (N,)."""
    return np.asarray(2.0 * np.arctan2(quaternions[:, 3], quaternions[:, 0]))


def _frame_of(a: Numbers, b: Numbers) -> Numbers:
    """An orthonormal frame, in columns, whose first axis is along a and whose second lies in the plane of a and b."""
    x = a / np.linalg.norm(a)
    z = np.cross(a, b)
    z = z / np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


def _quaternion(rotation: Numbers) -> Numbers:
    """Of a rotation matrix; the largest component is not negative."""
    # The eigenvector of the largest eigenvalue (Bar-Itzhack, J. Guid. Control Dyn. 23, 1085 (2000)).
    r = rotation
    matrix = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    vector = np.linalg.eigh(matrix)[1][:, -1]
    return np.asarray(vector * np.sign(vector[np.argmax(np.abs(vector))]))


def _turn_onto_z(direction: ArrayLike) -> Numbers:
    """A rotation matrix that turns the direction onto z."""
    z = np.asarray(direction, dtype=np.float64)
    z = z / np.linalg.norm(z)
    aside = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(aside, z)
    x = x / np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


def _conformation(nearest: NDArray[np.int64], bonds: Numbers, i: int, k: int) -> float:
    """Mean of cos 3φ over the dihedral angles of the contact of body i with its neighbour k."""
    j, axis = nearest[i][k], bonds[i][k]
    others = np.delete(bonds[i], k, axis=0)
    beyond = bonds[j][nearest[j] != i]
    frame = _turn_onto_z(axis)
    angles = [np.arctan2(*(ways @ frame.T)[:, 1::-1].T) for ways in (others, beyond)]
    return float(np.cos(3.0 * (angles[0][:, None] - angles[1][None])).mean())


def _box_of(configuration: Any) -> Numbers:
    box = np.array(configuration.box, dtype=np.float64)
    return np.where([True, True, configuration.dimensions == 3, True, True, True], box, 0.0)

