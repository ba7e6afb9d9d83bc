"""A trajectory written by simulate, opened and verified by the Python package gsd."""

import json
import subprocess
import sys
from pathlib import Path

import gsd.hoomd
import numpy as np

from conftest import sphere_mesh_off

CHECK = Path(__file__).with_name("check_gsd.py")


def test_trajectory_opens_in_gsd(tmp_path, protomer):
    (tmp_path / "sphere.off").write_text(sphere_mesh_off(8.0))
    (tmp_path / "charge.xyzq").write_text("0 0 0 3.0\n")
    protomer("body", "--mesh", tmp_path / "sphere.off", "--charges", tmp_path / "charge.xyzq", "-o", tmp_path / "a.body", parse=False)
    placements = [
        {"body": "a", "position_angstrom": [x, 0, 0], "orientation_wxyz": [1, 0, 0, 0]} for x in (-20, 0, 20)
    ]
    assembly = {"box_angstrom": [200] * 3, "bodies": [{"name": "a", "file": "a.body"}], "placements": placements}
    (tmp_path / "assembly.json").write_text(json.dumps(assembly))
    protomer(
        "simulate", tmp_path / "assembly.json", "--salt", "100mM", "--sweeps", 50, "--equilibration", 10,
        "--trajectory-every", 10, "-o", tmp_path / "run", parse=False,
    )
    path = next((tmp_path / "run").rglob("trajectory.gsd"))
    subprocess.run([sys.executable, CHECK, path], check=True)
    with gsd.hoomd.open(str(path)) as trajectory:
        assert len(trajectory) == 5
        frame = trajectory[-1]
        assert frame.particles.N == 3 and np.allclose(frame.particles.charge, 3.0)
        assert np.allclose(frame.configuration.box[:3], 200)
        # The observable of the log follows from the positions.
        positions = frame.particles.position.astype(float)
        pairs = positions[:, None] - positions[None]
        pairs -= 200 * np.round(pairs / 200)
        r_g = np.sqrt((pairs**2).sum() / 2) / 3
        assert abs(float(frame.log["r_g_angstrom"][0]) - r_g) < 1e-3
