"""Order among bodies against perfect crystals, the ideal gas and a file that was written."""

from __future__ import annotations

import numpy as np
import pytest

import protomer as pm
from protomer.structure import MeanForce, Structure, rotations_of

freud = pytest.importorskip("freud")

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64)
FCC = np.array([[0, 0, 0], [0, 2, 2], [2, 0, 2], [2, 2, 0]], dtype=np.float64) / 4


def structure(points: np.ndarray, edges: np.ndarray) -> Structure:
    """One frame of a box with right angles; points are wrapped into it."""
    wrapped = points - edges * np.round(points / edges)
    orientations = np.tile(IDENTITY, (1, len(points), 1))
    return Structure(wrapped[None], orientations, np.array([[*edges, 0.0, 0.0, 0.0]]))


def crystal(cell: np.ndarray, sites: np.ndarray, times: int) -> Structure:
    """Copies of a unit cell with these edges and fractional sites."""
    corners = np.array(np.meshgrid(*[range(times)] * 3)).reshape(3, -1).T
    points = (corners[:, None] + sites[None]).reshape(-1, 3) * cell
    return structure(points, times * cell)


def cubic_diamond(times: int) -> Structure:
    # The bond has a length of sqrt(3).
    return crystal(np.full(3, 4.0), np.concatenate([FCC, FCC + 0.25]), times)


def hexagonal_diamond(times: int) -> Structure:
    # Two hexagonal layers of wurtzite, in an orthorhombic cell.
    cell = np.array([1.0, np.sqrt(3.0), np.sqrt(8.0 / 3.0)])
    hexagonal = np.array([[0, 0, 0], [0.5, 0.5, 0], [0, 1 / 3, 0.5], [0.5, 5 / 6, 0.5]])
    return crystal(cell, np.concatenate([hexagonal, hexagonal + [0, 0, 3 / 8]]), times)


def test_the_two_diamonds_are_told_apart() -> None:
    cubic = cubic_diamond(3).diamond()
    assert cubic.cubic.all() and not cubic.hexagonal.any()
    assert len(cubic.contacts) == 2 * 216
    assert np.allclose(cubic.conformation, -1.0, atol=1e-4)
    hexagonal = hexagonal_diamond(4).diamond()
    assert hexagonal.hexagonal.all() and not hexagonal.cubic.any()
    assert np.isclose((hexagonal.conformation > 0.99).mean(), 0.25)


def test_a_shaken_diamond_is_still_one_and_a_gas_is_none() -> None:
    rng = np.random.default_rng(4)
    perfect = cubic_diamond(3)
    shaken = structure(perfect.positions[0] + rng.normal(scale=0.1, size=(216, 3)), perfect.boxes[0, :3])
    assert shaken.diamond().cubic.mean() > 0.9
    gas = structure(rng.uniform(-6.0, 6.0, size=(500, 3)), np.full(3, 12.0)).diamond()
    assert gas.cubic.mean() < 0.01 and gas.hexagonal.mean() < 0.01


def test_layers_of_cubic_diamond_repeat_after_three_and_of_hexagonal_after_two() -> None:
    for found, axis, period in [
        (cubic_diamond(4), np.array([1.0, 1.0, 1.0]) / np.sqrt(3.0), 3),
        (hexagonal_diamond(5), np.array([0.0, 0.0, 1.0]), 2),
    ]:
        bond = np.linalg.norm(found._four_nearest(0)[1][0, 0])
        correlation = found.autocorrelation(up=axis, spacing=0.09 * bond, width=0.085 * bond, reach=4.1 * bond)
        centre = len(correlation.lateral) // 2
        assert correlation.layer(0.0)[centre, centre] == pytest.approx(1.0)
        # Layers are 4/3 of a bond apart; a body stands above another where the stacking repeats.
        above = [correlation.layer(4 / 3 * bond * number)[centre, centre] for number in range(1, period + 1)]
        assert above[-1] > 0.3
        assert max(above[:-1]) < 0.05


def test_a_layer_has_six_neighbours() -> None:
    correlation = cubic_diamond(4).autocorrelation(up=[1, 1, 1], spacing=0.15, width=0.15, reach=4.0)
    x, y = np.meshgrid(correlation.lateral, correlation.lateral, indexing="ij")
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    ring = np.abs(radius - np.sqrt(8.0)) < 0.3
    weight = correlation.layer(0.0)[ring]
    folds = [abs((weight * np.exp(1j * fold * angle[ring])).sum()) / weight.sum() for fold in range(1, 7)]
    assert folds[5] > 0.8
    assert max(folds[:5]) < 0.1


def test_the_contact_axis_of_a_diamond_is_one_of_its_four() -> None:
    axis = cubic_diamond(3).contact_axis()
    assert np.allclose(np.abs(axis), 1 / np.sqrt(3.0), atol=1e-3)


@pytest.mark.parametrize(("along", "fold"), [([1, 1, 1], 6), ([0, 0, 1], 4)])
def test_diffraction_has_the_symmetry_of_the_axis(along: list[int], fold: int) -> None:
    k, pattern = cubic_diamond(4).diffraction(along=along, k_max=6.0)
    x, y = np.meshgrid(k, k, indexing="ij")
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    assert pattern.max() == pytest.approx(512.0) and pattern[128, 128] == pytest.approx(512.0)
    # {220}: six across (111), four across (100), at 2π√8/4.
    ring = np.abs(radius - 2 * np.pi * np.sqrt(8.0) / 4) < 0.2
    assert pattern[ring].max() > 500.0
    folds = [abs((pattern[ring] * np.exp(1j * n * angle[ring])).sum()) / pattern[ring].sum() for n in range(1, 7)]
    assert folds[fold - 1] > 0.8
    # Four have no six-fold part and six no four-fold part.
    assert folds[9 - fold] < 0.2


def test_an_ideal_gas_has_no_structure() -> None:
    rng = np.random.default_rng(7)
    frames, count, edge = 20, 400, 10.0
    turns = rng.normal(size=(frames, count, 4))
    gas = Structure(
        rng.uniform(-edge / 2, edge / 2, size=(frames, count, 3)),
        turns / np.linalg.norm(turns, axis=2, keepdims=True),
        np.tile([edge, edge, edge, 0.0, 0.0, 0.0], (frames, 1)),
        TETRAHEDRON,
    )
    r, g = gas.radial_distribution(r_max=4.0, bins=10)
    assert np.allclose(g[2:], 1.0, atol=0.03) and r[-1] == pytest.approx(3.8)
    potential = gas.mean_force(reach=2.8, bins=9)
    assert np.abs(potential.values_kt).max() < 0.3
    assert abs(potential.values_kt.mean()) < 0.01
    with pytest.raises(ValueError, match=r"faces are 10 apart; the reach must be below 2\.887"):
        gas.mean_force(reach=3.0)
    with pytest.raises(ValueError, match="for bodies in a plane"):
        gas.mean_torque(reach=2.0)


def in_a_plane(frames: list[np.ndarray], angles: list[np.ndarray], edge: float, corners: int | None = None) -> Structure:
    """Bodies in a square box: points (N, 2) and angles (N,) of each frame, regular polygons where corners are given."""
    points = np.array([np.column_stack([frame, np.zeros(len(frame))]) for frame in frames])
    half = 0.5 * np.array(angles)
    zeros = np.zeros_like(half)
    around = None
    if corners is not None:
        angle = 2.0 * np.pi / corners * np.arange(corners)
        around = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(corners)])
    boxes = np.tile([edge, edge, 0.0, 0.0, 0.0, 0.0], (len(frames), 1))
    return Structure(points, np.stack([np.cos(half), zeros, zeros, np.sin(half)], axis=-1), boxes, around)


def test_an_ideal_gas_in_a_plane_has_no_structure() -> None:
    rng = np.random.default_rng(8)
    frames = [rng.uniform(-5.0, 5.0, size=(300, 2)) for _ in range(20)]
    gas = in_a_plane(frames, [rng.uniform(-9.0, 9.0, size=300) for _ in frames], 10.0, 4)
    force = gas.mean_force(reach=3.5, bins=7)
    torque = gas.mean_torque(reach=3.5, bins=7, angles=4)
    # About 3500 pairs are in a bin of the force, four times as many with the symmetry, and a quarter of these in one of the torque.
    assert force.values_kt.shape == (7, 7) and np.abs(force.values_kt).max() < 0.1
    assert torque.values_kt.shape == (7, 7, 4) and np.abs(torque.values_kt).max() < 0.15
    assert abs(torque.values_kt.mean()) < 0.01
    assert torque.angles_rad[-1] == pytest.approx(np.pi / 2 * 7 / 8)
    for wrong in (lambda: gas.mean_force(3.6), lambda: gas.mean_torque(3.6)):
        with pytest.raises(ValueError, match=r"faces are 10 apart; the reach must be below 3\.536"):
            wrong()
    # In a box that leans by 45 degrees the faces are nearer to each other than the edges are long.
    leaning = Structure(gas.positions, gas.orientations, np.tile([10.0, 10.0, 0.0, 1.0, 0.0, 0.0], (20, 1)))
    with pytest.raises(ValueError, match=r"faces are 7\.07107 apart; the reach must be below 2\.5"):
        leaning.mean_force(2.6)


def test_disks_have_minus_the_logarithm_of_the_radial_distribution() -> None:
    """Hard disks, whose bodies all point somewhere else: the potential is isotropic and that of g(r)."""
    rng = np.random.default_rng(9)
    edge, count = 10.0, 40
    points = np.empty((0, 2))
    frames, angles = [], []
    for _ in range(600):
        points = np.empty((0, 2))
        while len(points) < count:
            trial = rng.uniform(-edge / 2, edge / 2, size=2)
            way = points - trial
            way -= edge * np.round(way / edge)
            if not np.any(np.sum(way**2, axis=1) < 1.0):
                points = np.vstack([points, trial])
        frames.append(points)
        angles.append(rng.uniform(-np.pi, np.pi, size=count))
    disks = in_a_plane(frames, angles, edge)
    r, g = disks.radial_distribution(r_max=3.4, bins=34)
    force = disks.mean_force(reach=2.4, bins=49)
    x, y = np.meshgrid(force.coordinates, force.coordinates, indexing="ij")
    radius, density = np.hypot(x, y), np.exp(-force.values_kt)
    assert np.all(density[radius < 0.92] == 0.0)
    for low in (1.2, 1.5, 1.8, 2.1):
        ring = (radius >= low) & (radius < low + 0.3)
        inside = (r >= low) & (r < low + 0.3)
        assert density[ring].mean() == pytest.approx((g[inside] * r[inside]).sum() / r[inside].sum(), rel=0.02)


def squares_meet(x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Whether squares of edge 1 at these places and angles meet one at the origin: each has no separating edge."""
    meet = np.ones(np.shape(x), dtype=bool)
    reach = 0.5 * (1.0 + np.abs(np.cos(angle)) + np.abs(np.sin(angle)))
    for turn in (0.0, np.pi / 2, angle, angle + np.pi / 2):
        meet &= np.abs(x * np.cos(turn) + y * np.sin(turn)) < reach
    return meet


def test_two_squares_have_no_density_where_they_overlap_and_one_density_elsewhere() -> None:
    """Two hard squares alone in a box: every place and angle without overlap is as likely as any other."""
    rng = np.random.default_rng(10)
    edge, count = 5.0, 200_000
    way = rng.uniform(-edge / 2, edge / 2, size=(count, 2))
    first, other = rng.uniform(-np.pi, np.pi, size=(2, count))
    cosine, sine = np.cos(first), np.sin(first)
    x, y = way[:, 0] * cosine + way[:, 1] * sine, way[:, 1] * cosine - way[:, 0] * sine
    free = ~squares_meet(x, y, other - first)
    kept = np.flatnonzero(free)[:5000]
    # Many pairs far from each other, as frames of two bodies.
    frames = [np.array([[0.0, 0.0], place]) for place in way[kept]]
    squares = in_a_plane(frames, list(np.column_stack([first[kept], other[kept]])), edge, 4)
    # The squares of `in_a_plane` have corners on the axes, those of `squares_meet` edges: their frames differ by an eighth of a turn,
    # and so do both bodies, whose angle with each other is the same.
    torque = squares.mean_torque(reach=1.7, bins=17, angles=8)
    assert np.array_equal(np.isinf(torque.values_kt[8, 8]), np.ones(8, dtype=bool))
    half_bin, half_angle = 0.1, np.pi / 32
    offsets = np.linspace(-1.0, 1.0, 9)
    for i, x0 in enumerate(torque.coordinates):
        for j, y0 in enumerate(torque.coordinates):
            for k, angle0 in enumerate(torque.angles_rad):
                dx, dy, da = np.meshgrid(half_bin * offsets, half_bin * offsets, half_angle * offsets, indexing="ij")
                blocked = squares_meet(x0 + dx, y0 + dy, angle0 + da)
                if blocked.all():
                    assert np.isinf(torque.values_kt[i, j, k])
    # One pair in a box of 25, less the part that is excluded on average, compared with an ideal gas of two.
    excluded = 1.0 - free.mean()
    far = np.hypot(*np.meshgrid(torque.coordinates, torque.coordinates)) > 1.6
    density = np.exp(-torque.values_kt[far])
    # About 1700 pairs are there: an error of 2.4 %.
    assert density.mean() == pytest.approx(0.5 / (1.0 - excluded), rel=0.075)
    assert excluded * edge**2 == pytest.approx(2.0 + 8.0 / np.pi, rel=0.01)
    # With angles averaged over it is the potential of mean force, by freud.
    force = squares.mean_force(reach=1.7, bins=17)
    # A few of about 5000 · 2 · 4 places are on the other side of an edge between bins in single precision.
    both = [np.exp(-values) for values in (torque.mean_force().values_kt, force.values_kt)]
    assert np.mean(np.isclose(*both, rtol=1e-4)) > 0.9
    np.testing.assert_allclose(*both, atol=0.15)
    angles, values = torque.against_angle([1.0, 0.0])
    assert len(angles) == 8 and np.array_equal(values, torque.values_kt[13, 8])


def test_contacts_of_polygons_are_wells_in_the_frame_of_the_body() -> None:
    """Squares of a perfect lattice that all lean by the same angle have neighbours along their edges."""
    rng = np.random.default_rng(11)
    rows, columns = np.meshgrid(np.arange(8.0), np.arange(8.0))
    points = np.column_stack([rows.ravel(), columns.ravel()]) - 4.0
    lean = 0.3
    frames = [points + rng.normal(scale=0.05, size=points.shape) for _ in range(20)]
    leaning = in_a_plane(frames, [np.full(64, lean) for _ in frames], 8.0, 4)
    force = leaning.mean_force(reach=1.2, bins=25)
    # The neighbour along x of the box is at -0.3 rad in the frame of a body, and by the symmetry a quarter of a turn on.
    for quarter in range(4):
        angle = quarter * np.pi / 2 - lean
        distance, depth = force.well([np.cos(angle), np.sin(angle)])
        assert distance == pytest.approx(1.0, abs=0.1) and depth < -2.0
        distances, values = force.along([np.cos(angle + 2 * lean), np.sin(angle + 2 * lean)])
        assert np.all(np.isinf(values[distances < 1.2]))


def test_contacts_are_wells_in_the_frame_of_the_body() -> None:
    # Bodies of both sublattices look at their neighbours with the corners of their tetrahedra.
    perfect = cubic_diamond(4)
    rng = np.random.default_rng(5)
    first = np.isclose(np.mod(perfect.positions[0, :, 0] + 100.0, 2.0), 0.0)
    quarter = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    orientations = np.where(first[:, None], IDENTITY, quarter)[None]
    shaken = perfect.positions + rng.normal(scale=0.1, size=perfect.positions.shape)
    potential = Structure(shaken, orientations, perfect.boxes, TETRAHEDRON).mean_force(reach=2.4, bins=25)
    for corner in TETRAHEDRON:
        distance, depth = potential.well(corner)
        assert distance == pytest.approx(np.sqrt(3.0), abs=0.2) and depth < -2.0
        assert not np.isfinite(potential.well(-corner)[1]) or potential.well(-corner)[1] > depth + 2.0


def test_rotations_of_solids() -> None:
    assert len(rotations_of(TETRAHEDRON)) == 12
    octahedron = np.concatenate([np.eye(3), -np.eye(3)])
    assert len(rotations_of(octahedron)) == 24
    prism = np.array([[1, 0, 2], [-0.5, 0.75**0.5, 2], [-0.5, -(0.75**0.5), 2]])
    assert len(rotations_of(np.concatenate([prism, prism * [1, 1, -1]]))) == 6


def test_a_run_is_read_with_its_shape(tmp_path) -> None:
    run = tmp_path / "cubes"
    answer = {"shape": "cube", "start": "simple-cubic", "bodies": 27, "packing_fraction": 0.6}
    pm.hpmc.run(**answer, equilibration=10, sweeps=100, trajectory_every=50, output=run)
    cubes = Structure.read(run)
    # Frames at 0, 50 and 100 sweeps, of which the first is of the equilibration.
    assert cubes.positions.shape == (2, 27, 3)
    assert Structure.read(run, skip=0).positions.shape == (3, 27, 3)
    assert len(rotations_of(cubes.vertices)) == 24
    assert cubes.steinhardt(4, 6).mean() > 0.6  # 0.7638 in a perfect lattice
    with pytest.raises(ValueError, match="skip fewer"):
        Structure.read(run, skip=100)
    with pytest.raises(FileNotFoundError):
        Structure.read(tmp_path / "nothing")
    with pytest.raises(pm.ParseError, match="log.csv cannot be read as a GSD trajectory"):
        Structure.read(run / "log.csv")


def test_a_body_of_pieces_is_read_with_its_corners(tmp_path) -> None:
    # A bar with a cube on each of two sides: pieces share corners, which are there once.
    pieces = []
    bars = [((-1.5, 0, 0), (1.5, 1, 1)), ((-0.5, 1, 0), (0.5, 2, 1)), ((-0.5, -1, 0), (0.5, 0, 1))]
    for number, (low, high) in enumerate(bars):
        corners = np.array(np.meshgrid(*zip(low, high))).reshape(3, 8).T
        np.savetxt(tmp_path / f"{number}.txt", corners)
        pieces.append(str(tmp_path / f"{number}.txt"))
    answer = {"shape": "+".join(pieces), "bodies": 60, "packing_fraction": 0.05}
    run = pm.hpmc.run(**answer, equilibration=50, sweeps=50, trajectory_every=50, output=tmp_path / "crosses")
    assert run["acceptance"] > 0.1
    crosses = Structure.read(tmp_path / "crosses")
    assert crosses.vertices.shape == (24, 3)
    assert len(rotations_of(crosses.vertices)) == 8
    assert pm.report(tmp_path / "crosses", output=tmp_path / "crosses.html")["sections"].count("Bodies") == 1


def test_plots_are_drawn() -> None:
    pytest.importorskip("matplotlib").use("Agg")
    correlation = cubic_diamond(3).autocorrelation(spacing=0.4, width=0.4, reach=2.0)
    assert correlation.plot(height=1.0).get_xlabel() == "Δx"
    values = np.full((5, 5, 5), np.inf)
    values[3, 2, 2] = -1.0
    ax = MeanForce(np.linspace(-2.0, 2.0, 5), values).plot(directions={"x": [1, 0, 0]})
    assert ax.get_ylabel() == "potential of mean force (kT)"
