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
    with pytest.raises(ValueError, match="at most 2.887"):
        gas.mean_force(reach=3.0)


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
