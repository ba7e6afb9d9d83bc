"""A trajectory written by simulate, opened and verified by the Python package gsd."""

import subprocess
import sys
from pathlib import Path

import gsd.hoomd
import numpy as np
import pytest

from conftest import write_assembly, write_sphere_body

CHECK = Path(__file__).with_name("check_gsd.py")


def require_equal_frame(frame, charge, box, scale=1.0):
    """Three charges (e), the box (Å), and the observable of the log, which follows from the positions (Å)."""
    assert frame.particles.N == 3 and np.allclose(frame.particles.charge, charge)
    assert np.allclose(frame.configuration.box[:3], box)
    positions = scale * frame.particles.position.astype(float)
    pairs = positions[:, None] - positions[None]
    pairs -= box * np.round(pairs / box)
    r_g = np.sqrt((pairs**2).sum() / 2) / 3
    assert abs(float(frame.log["r_g_angstrom"][0]) - r_g) < 1e-3


def test_trajectory_opens_in_gsd(tmp_path, protomer):
    write_sphere_body(tmp_path, protomer, "a", 8.0, 3.0)
    placements = [("a", (x, 0, 0), (1, 0, 0, 0)) for x in (-20, 0, 20)]
    write_assembly(tmp_path / "assembly.json", ["a"], placements, box=200)
    protomer(
        "simulate", tmp_path / "assembly.json", "--salt", "100mM", "--sweeps", 50, "--equilibration", 10,
        "--trajectory-every", 10, "-o", tmp_path / "run", parse=False,
    )
    path = next((tmp_path / "run").rglob("trajectory.gsd"))
    subprocess.run([sys.executable, CHECK, path], check=True)
    with gsd.hoomd.open(str(path)) as trajectory:
        assert len(trajectory) == 5
        frame = trajectory[-1]
        require_equal_frame(frame, 3.0, 200.0)
        # The comparison must notice a flipped charge, and nm for Å in the box and in the positions.
        for wrong in ((-3.0, 200.0, 1.0), (3.0, 20.0, 1.0), (3.0, 200.0, 0.1)):
            with pytest.raises(AssertionError):
                require_equal_frame(frame, *wrong)


def test_the_schema_is_checked(tmp_path):
    """A body outside of the box, a quaternion without unit length, steps that fall: each is refused."""
    good = dict(position=[[0, 0, 0], [3, 0, 0]], orientation=[[1, 0, 0, 0]] * 2, steps=(0, 10))
    wrong = {"position": [[0, 0, 0], [30, 0, 0]]}, {"orientation": [[2, 0, 0, 0]] * 2}, {"steps": (10, 0)}
    for number, case in enumerate([good, *(good | change for change in wrong)]):
        path = tmp_path / f"{number}.gsd"
        with gsd.hoomd.open(str(path), "w") as trajectory:
            for step in case["steps"]:
                frame = gsd.hoomd.Frame()
                frame.configuration.step, frame.configuration.box = step, [20, 20, 20, 0, 0, 0]
                frame.particles.N, frame.particles.types, frame.particles.type_shapes = 2, ["a"], [{}]
                frame.particles.position, frame.particles.orientation = case["position"], case["orientation"]
                trajectory.append(frame)
        outcome = subprocess.run([sys.executable, CHECK, path], capture_output=True, text=True)
        assert (outcome.returncode == 0) == (number == 0), outcome.stderr
