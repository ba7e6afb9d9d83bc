"""Displacements, correlations and bond-orientational order against exact limits."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import protomer as pm
from protomer import _turns
from protomer.dynamics import Motion, Seeds, free_flight_displacement, local_slope, relaxation_time

freud = pytest.importorskip("freud")


def motion(times: np.ndarray, positions: np.ndarray, **more: np.ndarray) -> Motion:
    shape = positions.shape
    fields = {
        "angles_rad": np.zeros(shape[:2]),
        "velocities": np.zeros(shape),
        "spins": np.zeros(shape),
        "box": np.array([10.0, 10.0, 0.0]),
    }
    return Motion(times=times, positions=positions, **{**fields, **more})


def free_flight(seed: int, mass: float, moment: float, kt: float) -> Motion:
    """Bodies that never meet, with the velocities of a temperature."""
    rng = np.random.default_rng(seed)
    count, times = 20000, np.array([0.0, 0.1, 0.2])
    velocity = rng.normal(size=(count, 3)) * np.sqrt(kt / mass) * [1.0, 1.0, 0.0]
    turning = rng.normal(size=count) * np.sqrt(kt / moment)
    zeros = np.zeros((count, 2))
    return motion(
        times,
        times[:, None, None] * velocity,
        angles_rad=times[:, None] * turning,
        velocities=np.repeat(velocity[None], 3, axis=0),
        spins=np.repeat(np.column_stack([zeros, moment * turning])[None], 3, axis=0),
    )


def test_free_flight_has_its_exact_limits() -> None:
    # Rows of the reference: T = 0.5, m = 2, I = 0.3 at t = 0.2; twenty thousand bodies leave about 1 %.
    flight = free_flight(1, 2.0, 0.3, 0.5)
    t, displacement = flight.displacement()
    assert t[2] == 0.2
    assert abs(displacement[2] / 0.02 - 1.0) < 0.04
    assert abs(flight.turning()[1][2] / (0.2**2 * 0.5 / 0.3) - 1.0) < 0.04
    for symmetry, expected in ((1, 0.9672161), (3, 0.7408182), (4, 0.5866462), (6, 0.3011943)):
        assert abs(flight.orientation(symmetry)[1][2] - expected) < 0.02
    assert np.allclose(flight.velocity()[1], 1.0)
    assert np.allclose(flight.spinning()[1], 1.0)
    assert free_flight_displacement(np.array([0.2]), 2.0, 0.5)[0] == pytest.approx(0.02)


def test_correlations_are_the_means_over_all_origins() -> None:
    """Fourier transforms compared with plain sums."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=(37, 5, 3)).cumsum(axis=0)
    walk = motion(np.linspace(0.0, 3.6, 37), values, velocities=values, spins=2.0 * values)
    means = [np.mean((values[lag:] * values[: 37 - lag]).sum(axis=-1)) for lag in range(37)]
    for correlation in (walk.velocity()[1], walk.spinning()[1]):
        np.testing.assert_allclose(correlation, np.array(means) / means[0], rtol=1e-12, atol=1e-12)
    angles = values[..., 0]
    turned = motion(np.linspace(0.0, 3.6, 37), values, angles_rad=angles)
    means = [np.mean(np.cos(4.0 * (angles[lag:] - angles[: 37 - lag]))) for lag in range(37)]
    np.testing.assert_allclose(turned.orientation(4)[1], means, rtol=1e-12, atol=1e-12)


def test_langevin_velocities_relax_with_their_friction() -> None:
    t = np.linspace(0.0, 10.0, 1001)
    assert relaxation_time(t, np.exp(-2.0 * t)) == pytest.approx(0.5)
    assert np.isnan(relaxation_time(t, np.ones_like(t)))
    # 2 kT/(m ξ²) d (ξt - 1 + exp(-ξt)): ballistic first, diffusive in the end.
    displacement = t - 0.5 * (1.0 - np.exp(-2.0 * t))
    assert displacement[100] * 2.0 == pytest.approx(1.1353352832366128)
    middle, slope = local_slope(t, 2.0 * displacement)
    assert slope[0] > 1.9
    assert slope[-1] < 1.1
    assert middle[0] < middle[-1]


def gaussian_walk(seed: int, frames: int, count: int, dimension: int, step: float = 0.1) -> Motion:
    """Brownian motion with D = step²/2 per frame; a third coordinate of 0 in a plane."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(frames, count, 3)) * step
    steps[..., dimension:] = 0.0
    box = np.full(3, 10.0) * (np.arange(3) < dimension)
    return motion(np.arange(frames) * 0.5, steps.cumsum(axis=0), box=box)


def quaternions(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Of rotations by an angle (...) about unit vectors (..., 3)."""
    return np.concatenate([np.cos(0.5 * angle)[..., None], np.sin(0.5 * angle)[..., None] * axis], axis=-1)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w = a[..., 0] * b[..., 0] - np.sum(a[..., 1:] * b[..., 1:], axis=-1)
    v = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([w[..., None], v], axis=-1)


def turning_in_space(steps: np.ndarray, start: np.ndarray, **more: np.ndarray) -> Motion:
    """Bodies that turn from frame to frame by rotation vectors (F - 1, N, 3) in their own frames, from quaternions (N, 4)."""
    angle = np.linalg.norm(steps, axis=-1)
    turns = quaternions(steps / angle[..., None], angle)
    found = [start]
    for turn in turns:
        found.append(product(found[-1], turn))
    zeros = np.zeros((len(found), len(start), 3))
    return motion(
        0.1 * np.arange(len(found)), zeros, angles_rad=None, box=np.full(3, 10.0), orientations=np.array(found), **more
    )


def anywhere(rng: np.random.Generator, count: int) -> np.ndarray:
    found = rng.normal(size=(count, 4))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


ICOSAHEDRON = np.array(
    [
        np.roll([0.0, a, b * 0.5 * (1 + 5**0.5)], shift)
        for shift in range(3)
        for a in (-1.0, 1.0)
        for b in (-1.0, 1.0)
    ]
)
SOLIDS = {
    "tetrahedron": (np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64), 3),
    "cube": (np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), dtype=np.float64).reshape(3, 8).T, 4),
    "icosahedron": (ICOSAHEDRON, 6),
}


@pytest.mark.parametrize("solid", [None, *SOLIDS])
def test_brownian_rotation_forgets_by_exponentials(solid: str | None) -> None:
    """exp(-l(l + 1) D t) for the least degree of each symmetry, and for others that it allows."""
    rng = np.random.default_rng(12)
    frames, count, width = 40, 2000, 0.06
    vertices, least = SOLIDS[solid] if solid else (None, 1)
    brownian = turning_in_space(width * rng.normal(size=(frames - 1, count, 3)), anywhere(rng, count), vertices=vertices)
    # One step shrinks degree l by the mean of χ_l/(2l + 1), which is exp(-l(l + 1) width²/2) up to the fourth order.
    for degree in [None, *({1: [2], 3: [4], 4: [6], 6: []}[least])]:
        power = least if degree is None else degree
        t, found = brownian.orientation_in_space(degree)
        expected = np.exp(-power * (power + 1) * 0.5 * width**2 * t / 0.1)
        assert found[0] == 1.0 and len(t) == len(found)
        assert np.abs(found - expected).max() < 0.02
    t, found = brownian.orientation_in_space()
    rate = least * (least + 1) * 0.5 * width**2 / 0.1
    if rate * t[-1] > 1.5:
        assert relaxation_time(t, found) == pytest.approx(1.0 / rate, rel=0.05)
    for degree in (1, 2):
        t, along = brownian.axis([0.0, 0.6, 0.8], degree)
        assert np.abs(along - np.exp(-degree * (degree + 1) * 0.5 * width**2 * t / 0.1)).max() < 0.03


def test_free_rotors_in_space_have_their_exact_correlation() -> None:
    """(2l + 1)⁻¹ Σ_m (1 - m²s²t²) exp(-m²s²t²/2) of balls with moment of inertia I, s² = kT/I, for every symmetry."""
    rng = np.random.default_rng(13)
    count, frames, width = 8000, 20, 0.18
    spin = width * rng.normal(size=(count, 3))
    vertices = SOLIDS["tetrahedron"][0]
    free = turning_in_space(np.repeat(spin[None], frames - 1, axis=0), anywhere(rng, count), vertices=vertices)
    for degree, symmetry in ((1, [[1.0, 0.0, 0.0, 0.0]]), (2, [[1.0, 0.0, 0.0, 0.0]]), (3, None), (4, None)):
        t, found = free.orientation_in_space(degree, symmetry=symmetry)
        m = np.arange(-degree, degree + 1)[:, None]
        square = (m * width * t / 0.1) ** 2
        np.testing.assert_allclose(found, np.mean((1.0 - square) * np.exp(-0.5 * square), axis=0), atol=0.02)


def test_a_rotation_of_the_symmetry_is_not_seen() -> None:
    rng = np.random.default_rng(14)
    vertices, degree = SOLIDS["cube"]
    start = anywhere(rng, 50)
    group = pm.structure.rotations_of(vertices)
    orientations = np.array([start, *(product(start, turn) for turn in group)])
    zeros = np.zeros((25, 50, 3))
    cubes = motion(np.arange(25.0), zeros, angles_rad=None, box=np.full(3, 9.0), orientations=orientations, vertices=vertices)
    assert np.allclose(cubes.orientation_in_space()[1], 1.0)
    assert np.abs(cubes.orientation_in_space(1, symmetry=[[1.0, 0.0, 0.0, 0.0]])[1][1:]).max() < 1.01
    with pytest.raises(ValueError, match=r"no function of degree 3 keeps its form under the 24 rotations .* 4, 6, 8"):
        cubes.orientation_in_space(3)
    with pytest.raises(ValueError, match="take orientation_in_space, or axis"):
        cubes.turning()
    flat = motion(np.arange(3.0), np.zeros((3, 5, 3)))
    with pytest.raises(ValueError, match="turn by an angle"):
        flat.orientation_in_space()
    # A quarter turn about z carries x to y.
    quarter = np.array([[[1.0, 0.0, 0.0, 0.0]], [[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]]])
    turned = motion(np.arange(2.0), np.zeros((2, 1, 3)), angles_rad=None, box=np.full(3, 9.0), orientations=quarter)
    assert turned.axis([1, 0, 0], 2)[1][1] == pytest.approx(-0.5)
    assert turned.axis([0, 0, 2], 1)[1][1] == pytest.approx(1.0)
    assert turned.axis([1, 0, 1], 1)[1][1] == pytest.approx(0.5)


def tumbling(seed: int, frames: int, count: int, *, diffusion: np.ndarray, turning: float, pitch: float = 0.0) -> Motion:
    """Brownian motion with D along each axis of the bodies and D_r about all of them, per frame; a screw along z has a pitch."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(frames - 1, count, 3)) * np.sqrt(2.0 * turning)
    tumble = turning_in_space(turns, anywhere(rng, count))
    steps = rng.normal(size=(frames - 1, count, 3)) * np.sqrt(2.0 * diffusion)
    steps[..., 2] += pitch * turns[..., 2]
    in_box = np.einsum("fnab,fnb->fna", _turns.matrices(tumble.orientations[:-1]), steps)
    places = np.concatenate([np.zeros((1, count, 3)), in_box.cumsum(axis=0)])
    return motion(
        np.arange(frames) * 1.0, places, angles_rad=None, box=np.full(3, 10.0), orientations=tumble.orientations
    )


def test_free_flight_moves_and_turns_as_it_began() -> None:
    """A velocity v and a spin ω about an axis u that stays: R(0)ᵀv t, a turn ω t through any number of full turns."""
    velocity, axis, rate = np.array([0.3, -0.2, 0.5]), np.array([2.0, 1.0, -2.0]) / 3.0, 4.0
    times = np.linspace(0.0, 5.0, 101)
    # A second body with everything turned round keeps the centre of mass where it is.
    places = times[:, None, None] * np.array([velocity, -velocity])
    turns = quaternions(np.broadcast_to(axis, (101, 3)), rate * times)
    flight = motion(times, places, angles_rad=None, box=np.full(3, 10.0), orientations=np.stack([turns, turns], axis=1))
    t, turned = flight.turning_in_space()
    np.testing.assert_allclose(turned, (rate * t) ** 2, rtol=1e-9, atol=1e-12)
    assert turned[-1] > 300.0
    # The velocity in the frame of the body, averaged over the orientations at the origins of this lag.
    t, moved = flight.displacement_in_frame()
    frames = _turns.matrices(turns)
    for lag, found in zip(np.round(t / 0.05).astype(int), moved, strict=True):
        own = np.einsum("fba,b->fa", frames[: 101 - lag], velocity) * 0.05 * lag
        np.testing.assert_allclose(found, np.einsum("fa,fb->ab", own, own) / len(own), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(np.trace(moved, axis1=1, axis2=2), t**2 * (velocity @ velocity), rtol=1e-9, atol=1e-12)
    # One of the bodies moves against the other and turns with it, so that products of displacements and turns cancel ...
    assert np.abs(flight.displacement_with_turn()[1]).max() < 1e-9
    # ... and those of squares are the product of the squares.
    np.testing.assert_allclose(flight.coupling()[1], 0.0, atol=1e-9)


def test_an_anisotropic_body_diffuses_along_its_axes_until_it_has_turned() -> None:
    """⟨Δz²⟩ = 2 D_⊥ t + 2 (D_∥ - D_⊥)(t/3 + (1 - exp(-6 D_r t))/(9 D_r)) in the frame at the start (Perrin)."""
    across, along, turning = 0.01, 0.05, 0.004
    walk = tumbling(21, 200, 3000, diffusion=np.array([across, across, along]), turning=turning)
    t, found = walk.displacement_in_frame()
    left = (1.0 - np.exp(-6.0 * turning * t)) / (9.0 * turning)
    extra = 2.0 * (along - across)
    parallel = 2.0 * across * t + extra * (t / 3.0 + left)
    perpendicular = 2.0 * across * t + extra * (t / 3.0 - 0.5 * left)
    # 3000 bodies, at long lags a few independent origins: 4 %.
    short = t <= 100.0
    np.testing.assert_allclose(found[short, 2, 2], parallel[short], rtol=0.04)
    for axis in (0, 1):
        np.testing.assert_allclose(found[short, axis, axis], perpendicular[short], rtol=0.04)
    assert found[1, 2, 2] / found[1, 0, 0] == pytest.approx(5.0, rel=0.03)
    assert np.abs(found[short][:, 0, 1] / t[short].clip(1.0)).max() < 0.002
    assert walk.turning_in_space()[1][short][1:] / t[short][1:] == pytest.approx(6.0 * turning, rel=0.03)
    # Displacements and turns of one step are independent, but the far ones are along an axis that has not turned.
    assert abs(walk.coupling()[1][0]) < 0.01


def test_a_screw_moves_as_it_turns() -> None:
    pitch, turning = 0.5, 0.002
    walk = tumbling(22, 60, 4000, diffusion=np.full(3, 1e-4), turning=turning, pitch=pitch)
    t, found = walk.displacement_with_turn()
    assert found[1, 2, 2] == pytest.approx(pitch * 2.0 * turning, rel=0.02)
    rest = found[1].copy()
    rest[2, 2] = 0.0
    assert np.abs(rest).max() < 0.02 * found[1, 2, 2]
    # The displacement is pitch times one of three turns, ⟨x²(x² + y² + z²)⟩ = 5 of 3 with independent squares: 2/3 of its share.
    share = pitch**2 * 2.0 * turning / (pitch**2 * 2.0 * turning + 6e-4)
    assert walk.coupling()[1][0] == pytest.approx(2.0 / 3.0 * share, rel=0.05)
    other = tumbling(22, 60, 4000, diffusion=np.full(3, 1e-4), turning=turning, pitch=-pitch)
    assert other.displacement_with_turn()[1][1, 2, 2] == pytest.approx(-pitch * 2.0 * turning, rel=0.02)


def test_polygons_move_in_their_own_frames() -> None:
    """Bodies that fly along their first axis, and a turn that costs a displacement."""
    rng = np.random.default_rng(23)
    angles = rng.uniform(0.0, 2.0 * np.pi, size=4000)
    way = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(4000)])
    times = np.arange(3.0)
    turn = np.where(np.arange(4000) % 2 == 0, 0.0, 1.0)
    flight = motion(
        times, times[:, None, None] * (1.0 - turn)[:, None] * way, angles_rad=angles + times[:, None] * turn
    )
    t, moved = flight.displacement_in_frame()
    assert moved.shape == (3, 2, 2)
    assert moved[2, 0, 0] == pytest.approx(2.0, rel=0.02) and moved[2, 1, 1] < 0.01
    assert flight.displacement_with_turn()[1].shape == (3, 2, 1)
    assert flight.coupling()[1] == pytest.approx([-1.0, -1.0], abs=0.01)


def test_turns_are_followed_beyond_half_a_turn() -> None:
    axis = np.array([0.0, 0.6, 0.8])
    for angle in (0.0, 1e-9, 0.5, 3.0, 3.5):
        vector = _turns.rotation_vectors(quaternions(axis, np.array(angle)))
        shorter = angle if angle <= np.pi else angle - 2.0 * np.pi
        np.testing.assert_allclose(vector, shorter * axis, atol=1e-12)
    with pytest.raises(ValueError, match="turn by an angle"):
        motion(np.arange(3.0), np.zeros((3, 5, 3))).turning_in_space()


@pytest.mark.parametrize("dimension", [2, 3])
def test_gaussian_displacements_have_exact_statistics(dimension: int) -> None:
    """α₂ = 0, exp(-k² D t), and a Gaussian van Hove function."""
    step, frames = 0.1, 120
    walk = gaussian_walk(15, frames, 2500, dimension, step)
    lags, parameter = walk.non_gaussian()
    assert lags[0] == 0.5 and np.abs(parameter).max() < 0.06 and np.abs(parameter[:20]).max() < 0.01
    for wave_number in (0.5, 2.0, 6.0):
        t, found = walk.intermediate(wave_number)
        expected = np.exp(-(wave_number**2) * 0.5 * step**2 * t / 0.5)
        # 2500 displacements that overlap, at the longest lags: an error of 0.014.
        assert found[0] == 1.0 and np.abs(found - expected).max() < 0.045
    r, density = walk.van_hove(10.0, 3.0, bins=30)
    variance = step**2 * 20
    expected = np.exp(-0.5 * r**2 / variance) / (2.0 * np.pi * variance) ** (dimension / 2)
    np.testing.assert_allclose(density[:20], expected[:20], rtol=0.05, atol=0.02 * expected[0])
    measure = np.diff(np.linspace(0.0, 3.0, 31) ** dimension) * {2: np.pi, 3: 4 / 3 * np.pi}[dimension]
    assert (density * measure).sum() == pytest.approx(1.0, abs=1e-6)
    with pytest.raises(ValueError, match="no frames are 0.1 apart; the time between frames is 0.5"):
        walk.van_hove(0.1, 1.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_displacements_of_one_length_have_exact_statistics(dimension: int) -> None:
    """α₂ = d/(d + 2) - 1, and J0(kr) or sin(kr)/(kr)."""
    rng = np.random.default_rng(16)
    way = rng.normal(size=(2000, 3))
    way[:, dimension:] = 0.0
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    way = np.concatenate([way, -way])  # no drift
    box = np.full(3, 9.0) * (np.arange(3) < dimension)
    jump = motion(np.arange(2.0), np.array([0.0 * way, 0.75 * way]), box=box)
    assert jump.non_gaussian()[1][0] == pytest.approx(dimension / (dimension + 2) - 1.0)
    bessel = 0.5118276717  # J0(1.5)
    expected = bessel if dimension == 2 else np.sin(1.5) / 1.5
    assert jump.intermediate(2.0)[1][1] == pytest.approx(expected, abs=1e-6)
    _, density = jump.van_hove(1.0, 1.0, bins=10)
    assert np.count_nonzero(density) == 1


def test_slow_and_fast_bodies_are_not_gaussian() -> None:
    """Half of the bodies stay: ⟨r⁴⟩/⟨r²⟩² doubles, so that α₂ = 1; the same of angles."""
    walk = gaussian_walk(17, 50, 8000, 2)
    still = np.arange(8000) % 2 == 0
    places = np.where(still[None, :, None], 0.0, walk.positions)
    half = motion(walk.times, places, angles_rad=places[..., 0])
    assert np.allclose(half.non_gaussian()[1][:20], 1.0, atol=0.05)
    assert np.allclose(half.non_gaussian_turning()[1][:20], 1.0, atol=0.08)


def test_free_flight_leaves_a_cage_when_it_is_fast_enough() -> None:
    """1 - exp(-m a²/(2 kT t²)) have not left after t: bodies that are slower than a/t."""
    rng = np.random.default_rng(18)
    times = np.linspace(0.0, 4.0, 201)
    velocity = rng.normal(size=(10000, 3)) * [1.0, 1.0, 0.0]
    flight = motion(times, times[:, None, None] * velocity)
    t, part = flight.staying(0.5, origins=3)
    with np.errstate(divide="ignore"):
        expected = 1.0 - np.exp(-0.5 * (0.5 / t) ** 2)
    assert len(t) == 101 and np.abs(part - expected).max() < 0.015
    exact = 0.5 / np.sqrt(-2.0 * np.log(1.0 - np.exp(-1.0)))
    assert flight.escape_time(0.5) == pytest.approx(exact, rel=0.02)
    assert np.isnan(flight.escape_time(30.0))
    # Those that came back have left.
    there_and_back = motion(np.arange(4.0), np.array([0.0, 1.0, 0.0, 0.0])[:, None, None] * velocity[:2])
    assert there_and_back.staying(1e-6, origins=1)[1].tolist() == [1.0, 0.0, 0.0, 0.0]


def test_diffusion_leaves_a_cage_after_its_exact_mean_time() -> None:
    """∫S dt = a²/(2 d D) from the centre of a disk; a walk in steps sees a radius that is larger by 0.5826 of a step.

    The shift is that of Siegmund (Adv. Appl. Probab. 11, 701 (1979)), exact for steps that are small compared with the radius.
    """
    step, radius = 0.05, 1.0
    walk = gaussian_walk(19, 3001, 2000, 2, step)
    t, part = walk.staying(radius, origins=10)
    mean = 0.5 * (t[1] - t[0]) * (part[1:] + part[:-1]).sum()
    diffusion = 0.5 * step**2 / 0.5
    assert part[-1] < 0.02
    assert mean == pytest.approx((radius + 0.5826 * step) ** 2 / (4.0 * diffusion), rel=0.03)


def test_few_frames_are_enough_or_told() -> None:
    one = motion(np.array([0.0]), np.zeros((1, 5, 3)))
    assert [values.tolist() for values in one.intermediate(1.0)] == [[0.0], [1.0]]
    with pytest.raises(ValueError, match="there is one frame"):
        one.van_hove(1.0, 1.0)
    still = motion(np.arange(3.0), np.zeros((3, 5, 3)))
    assert np.isnan(still.non_gaussian()[1]).all()
    assert np.isnan(still.escape_time(1.0))


def lattice(kind: str, turn: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    side = 12
    rows, columns = np.meshgrid(np.arange(side), np.arange(side))
    if kind == "square":
        points, box = np.column_stack([rows.ravel(), columns.ravel()]).astype(float), [side, side]
    else:
        height = np.sqrt(3.0) / 2.0
        points = np.column_stack([(rows + 0.5 * (columns % 2)).ravel(), height * columns.ravel()])
        box = [side, height * side]
    return np.column_stack([points, np.zeros(len(points))]), np.array([*box, 0.0])


@pytest.mark.parametrize(
    ("kind", "k", "neighbours", "expected"),
    [("square", 4, 4, 1.0), ("square", 6, 4, 0.0), ("triangular", 6, 6, 1.0), ("triangular", 4, 6, 0.0)],
)
def test_perfect_lattices_have_their_order(kind: str, k: int, neighbours: int, expected: float) -> None:
    points, box = lattice(kind)
    still = motion(np.array([0.0]), points[None], box=box)
    assert np.allclose(np.abs(still.bond_order(k, neighbours)), expected, atol=1e-4)


@pytest.mark.parametrize(("neighbours", "mean"), [(3, 0.5248657), (4, 0.4497731), (6, 0.3656432)])
def test_an_ideal_gas_has_the_order_of_a_random_walk(neighbours: int, mean: float) -> None:
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.uniform(-50.0, 50.0, size=(20000, 2)), np.zeros(20000)])
    gas = motion(np.array([0.0]), points[None], box=np.array([100.0, 100.0, 0.0]))
    assert abs(np.abs(gas.bond_order(6, neighbours)).mean() - mean) < 0.01


def test_seeds_give_errors_and_figures() -> None:
    seeds = Seeds([free_flight(seed, 1.0, 0.1667, 1.0) for seed in (1, 2, 3)], symmetry=4)
    t, mean, error = seeds.curve("displacement")
    assert t.shape == mean.shape == error.shape == (3,)
    assert 0.0 < error[2] < 0.05 * mean[2]
    assert np.isnan(seeds.relaxation_times()["velocity"][0])
    pytest.importorskip("matplotlib").use("Agg")
    assert seeds.plot(quantity="turning").get_yscale() == "log"
    assert seeds.plot(quantity="velocity").get_xscale() == "log"
    assert seeds.plot(quantity="non_gaussian").get_ylabel() == "non-Gaussian parameter"
    t, mean, _ = seeds.curve(lambda flight: flight.intermediate(2.0))
    assert np.allclose(mean, np.exp(-2.0 * t**2), atol=0.01)
    for wrong in (lambda: seeds.plot(quantity="colour"), lambda: seeds.curve("colour")):
        with pytest.raises((ValueError, pm.ProtomerError)):
            wrong()


def test_a_run_without_a_trajectory_is_named(tmp_path) -> None:  # type: ignore[no-untyped-def]
    pytest.importorskip("gsd.hoomd")
    with pytest.raises(FileNotFoundError, match=r"trajectory\.gsd"):
        Motion.read(tmp_path)


def test_each_shape_of_a_mixture_is_a_word_of_its_own(tmp_path) -> None:  # type: ignore[no-untyped-def]
    pm.md.run(
        shape=["disk", "ellipse:2,1"],
        share=[3, 1],
        bodies=32,
        packing_fraction=0.2,
        steps=20,
        compress_steps=20,
        equilibrate_steps=0,
        output=tmp_path / "mixture",
    )
    settings = tomllib.loads((tmp_path / "mixture" / "run.toml").read_text())
    assert settings["shape"] == ["disk", "ellipse:2,1"]
    assert settings["share"] == [3.0, 1.0]


def test_a_run_in_space_has_orientations_and_a_shape(tmp_path) -> None:  # type: ignore[no-untyped-def]
    settings = {"bodies": 27, "packing_fraction": 0.2, "compress_steps": 50, "equilibrate_steps": 0, "trajectory_every": 5}
    pm.md.run(shape="cube", steps=100, output=tmp_path / "cubes", **settings)
    cubes = Motion.read(tmp_path / "cubes")
    assert cubes.vertices.shape == (8, 3) and cubes.orientations.shape == (len(cubes.times), 27, 4)
    t, found = cubes.orientation_in_space()
    assert found[0] == 1.0 and np.all(np.diff(found) < 0.0) and found[-1] > 0.9
    assert cubes.non_gaussian()[1].shape == (len(t) - 1,)
    assert "orientation_in_space" in Seeds([cubes]).relaxation_times()


def test_frames_that_are_not_there_are_told(tmp_path) -> None:
    settings = {"bodies": 16, "packing_fraction": 0.3, "equilibration": 10, "sweeps": 20, "trajectory_every": 10}
    pm.hpmc.run(shape="polygon:4", output=tmp_path / "squares", **settings)
    with pytest.raises(ValueError, match="skip fewer than these"):
        Motion.read(tmp_path / "squares", skip=50)
    with pytest.raises(FileNotFoundError):
        Motion.read(tmp_path / "nothing")
