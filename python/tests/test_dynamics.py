"""Displacements, correlations and bond-orientational order against exact limits."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import protomer as pm
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


def test_frames_that_are_not_there_are_told(tmp_path) -> None:
    settings = {"bodies": 16, "packing_fraction": 0.3, "equilibration": 10, "sweeps": 20, "trajectory_every": 10}
    pm.hpmc.run(shape="polygon:4", output=tmp_path / "squares", **settings)
    with pytest.raises(ValueError, match="skip fewer than these"):
        Motion.read(tmp_path / "squares", skip=50)
    with pytest.raises(FileNotFoundError):
        Motion.read(tmp_path / "nothing")
