"""A tilted box written by hpmc, opened by the Python package gsd; neighbours found by freud in it."""

import freud
import gsd.hoomd
import numpy as np


def edges(box):
    """The edges of a box of GSD, as columns."""
    lx, ly, lz, xy, xz, yz = np.asarray(box, dtype=float)
    return np.array([[lx, xy * ly, xz * lz], [0, ly, yz * lz], [0, 0, lz]])


def test_a_tilted_box_opens_in_gsd(tmp_path, protomer):
    """Balls of diameter 1 in a box that changes its shape: they are in it, and no two overlap across its faces."""
    (tmp_path / "point.txt").write_text("0 0 0\n")
    (tmp_path / "cell.txt").write_text("cell 1 1 1 60 60 60\nsite 0 0 0\n")
    result = protomer(
        "hpmc", "run", "--shape", tmp_path / "point.txt", "--rounding", 0.5, "--start", tmp_path / "cell.txt",
        "--bodies", 125, "--packing-fraction", 0.6, "--pressure", 20, "--triclinic", "--equilibration", 200,
        "--sweeps", 800, "--trajectory-every", 100, "-o", tmp_path / "run", "--json",
    )  # fmt: skip
    with gsd.hoomd.open(str(tmp_path / "run" / "trajectory.gsd")) as trajectory:
        assert len(trajectory) == 11
        last = trajectory[-1].configuration.box
        assert np.allclose(last, [*result["box_edges"], *result["box_tilt_factors"]], rtol=1e-6)
        assert np.all(np.abs(last[3:]) > 0.1)
        for frame in trajectory:
            frame.validate()
            box = frame.configuration.box
            parts = np.linalg.solve(edges(box), frame.particles.position.T.astype(float)).T
            assert np.abs(parts).max() < 0.5 + 1e-5
            packing = 125 * np.pi / 6 / np.prod(box[:3])
            assert 0.5 < packing < 0.74
            distances = nearest(box, frame.particles.position)
            assert 0.9999 < distances.min() and distances.max() < 1.4
        # Without its tilt the box is another one.
        assert nearest([*last[:3], 0, 0, 0], frame.particles.position).min() < 0.99


def nearest(box, positions):
    """The distance from each place to the next."""
    found = freud.locality.AABBQuery(freud.box.Box(*box), positions)
    return found.query(positions, {"num_neighbors": 1, "exclude_ii": True}).toNeighborList().distances
