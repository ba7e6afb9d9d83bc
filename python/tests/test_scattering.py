"""Scattering from Python: curves as arrays, against sums over poses read from the same trajectories."""

import numpy as np
import pytest

import protomer as pm


@pytest.fixture(scope="module")
def sweep(ring, tmp_path_factory):
    output = tmp_path_factory.mktemp("scattering") / "sweep"
    settings = {"sweeps": 60, "equilibration": 5, "trajectory_every": 10, "energy": "direct", "seed": 5}
    return pm.sweep(ring, salt_molar=[0.05, 0.3], replicas=2, **settings, output=output)


def test_curves_are_those_of_the_poses(sweep, tmp_path):
    # All wave vectors of the box up to the largest, without a choice among them.
    seen = pm.scattering(sweep.directory, q_max=0.03, q_points=3, directions=10_000, skip=0, output=tmp_path / "seen")
    assert pm.ScatteringResult.read(tmp_path / "seen") == seen
    np.testing.assert_array_equal(seen.salt_molar, [0.05, 0.3])
    number = np.array(np.meshgrid(*[np.arange(-4, 5)] * 3)).reshape(3, -1).T
    vectors = number * 2.0 * np.pi / 640.0
    lengths = np.linalg.norm(vectors, axis=1)
    edges = [0.0, 0.01, 0.02, 0.03]
    for row, salt in zip(seen.structure_factor, seen.salt_molar):
        frames = np.concatenate(
            [sweep.trajectory(salt_molar=salt, replica=replica).positions_angstrom for replica in range(2)]
        )
        found = []
        for low, high in zip(edges, edges[1:]):
            waves = vectors[(lengths > low) & (lengths <= high)]
            if len(waves):
                amplitude = np.exp(1j * np.einsum("fni,wi->fnw", frames, waves)).sum(axis=1)
                found.append((np.abs(amplitude) ** 2).mean() / 4)
        np.testing.assert_allclose(row, found, rtol=1e-6)
    # P(q) of Guinier, with the radius of gyration of the atoms.
    body = sweep.assembly().bodies["plus"]
    places = body.charge_positions_angstrom[body.residue_indices >= 0]
    r_g = np.sqrt(((places - places.mean(axis=0)) ** 2).sum(axis=1).mean())
    form = np.array(seen.kinds[0].form_factor)
    np.testing.assert_allclose(form, np.exp(-((seen.q_per_angstrom * r_g) ** 2) / 3), rtol=2e-3)


def test_one_particle_scatters_as_the_sum_over_its_atoms(ring):
    # In open space, by Debye's sum over all atoms of all bodies.
    ring = pm.Assembly.read(ring)
    free = pm.Assembly(
        ring.bodies, ring.names, positions_angstrom=ring.positions_angstrom, orientations_wxyz=ring.orientations_wxyz
    )
    seen = pm.scattering(free, q_max=0.2, q_points=4, directions=20_000)
    assert np.isnan(seen.salt_molar[0]) and np.all(np.isnan(seen.intensity_error))
    places, weights = [], []
    for name, rotation, position in zip(ring.names, ring.rotations, ring.positions_angstrom):
        body = ring.bodies[name]
        own = body.charge_positions_angstrom[body.residue_indices >= 0]
        places.append(own @ rotation.T + position)
        weights.append(np.full(len(own), body.volume_angstrom3 / len(own)))
    places, weights = np.concatenate(places), np.concatenate(weights)
    distances = np.linalg.norm(places[:, None] - places, axis=2)
    volumes = np.array([ring.bodies[name].volume_angstrom3 for name in ring.names])
    for q, intensity in zip(seen.q_per_angstrom, seen.intensity[0]):
        exact = weights @ np.sinc(q * distances / np.pi) @ weights / (volumes**2).sum()
        assert intensity == pytest.approx(exact, rel=1e-5)
    # Four that touch are larger than one, and smaller than a chain of four spheres.
    alone = seen.kinds[0].hydrodynamic_radius_angstrom
    assert seen.fraction_of_bodies[0].tolist() == [0, 0, 0, 1]
    assert 1.4 * alone < seen.hydrodynamic_radius_angstrom[0] < 2.2 * alone


def test_plots(sweep):
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    seen = pm.scattering(sweep.directory, q_points=10)
    axes = seen.plot()
    assert axes.get_yscale() == "log" and len(axes.containers) == 2
    assert seen.plot(quantity="structure_factor").get_ylabel() == "S(q) of the centres"
    assert seen.plot(quantity="clusters").get_xlabel() == "bodies in a cluster"
    with pytest.raises(KeyError, match="there are intensity, structure_factor"):
        seen.plot(quantity="speed")
