"""Shared fixtures: the binary, the bundled structures, and small generated bodies."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
STRUCTURES = sorted((ROOT / "data" / "structures").glob("*.gz"))


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory):
    """Energy tables are kept from test to test, as a user's are from run to run, but not in the tester's own cache."""
    with pytest.MonkeyPatch.context() as patch:
        # test.sh has one for all tests.
        folder = os.environ.get("PROTOMER_TEST_CACHE_DIR") or str(tmp_path_factory.mktemp("cache"))
        patch.setenv("PROTOMER_CACHE_DIR", folder)
        yield


@pytest.fixture(scope="session")
def protomer():
    """Runs the binary; returns the JSON object it prints, or its text."""
    binary = Path(sys.executable).parent / "protomer"
    if not binary.exists():
        pytest.fail(f"{binary} is missing; run: {sys.executable} -m pip install {ROOT / 'python'}")

    def run(*arguments, parse=True):
        command = [str(binary), *map(str, arguments)]
        process = subprocess.run(command, capture_output=True, text=True, timeout=600)
        assert process.returncode == 0, f"{' '.join(command)}\n{process.stderr}"
        return json.loads(process.stdout) if parse else process.stdout

    return run


def sphere_mesh_off(radius, bands=8):
    """A closed sphere as OFF text: poles and latitude bands, outward."""
    vertices, faces, around = [(0.0, 0.0, radius)], [], 2 * bands
    for band in range(1, bands):
        polar = np.pi * band / bands
        for step in range(around):
            azimuth = 2 * np.pi * step / around
            vertices.append(
                (radius * np.sin(polar) * np.cos(azimuth), radius * np.sin(polar) * np.sin(azimuth), radius * np.cos(polar))
            )
    vertices.append((0.0, 0.0, -radius))
    last = len(vertices) - 1
    row = lambda band, step: 1 + (band - 1) * around + step % around
    for step in range(around):
        faces.append((0, row(1, step), row(1, step + 1)))
        faces.append((last, row(bands - 1, step + 1), row(bands - 1, step)))
        for band in range(1, bands - 1):
            faces.append((row(band, step), row(band + 1, step), row(band + 1, step + 1)))
            faces.append((row(band, step), row(band + 1, step + 1), row(band, step + 1)))
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(map(repr, map(float, vertex))) for vertex in vertices]
    lines += ["3 " + " ".join(map(str, face)) for face in faces]
    return "\n".join(lines) + "\n"


def read_container(path):
    """Kind, header and arrays of a body file, by the reader that docs/reference/formats.md prints."""
    page = (ROOT / "docs" / "reference" / "formats.md").read_text()
    code = page.split("```python\n")[1].split("```")[0]
    namespace = {}
    exec(code, namespace)
    return namespace["read_container"](path)


def rotation_matrix(quaternion):
    """Of a unit quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def write_sphere_body(folder, protomer, name, radius, charge, bands=8):
    """A sphere of this radius (Å) with a charge (e) in its centre."""
    (folder / f"{name}.off").write_text(sphere_mesh_off(radius, bands))
    (folder / f"{name}.xyzq").write_text(f"0 0 0 {charge}\n")
    output = folder / f"{name}.body"
    protomer("body", "--mesh", folder / f"{name}.off", "--charges", folder / f"{name}.xyzq", "-o", output, parse=False)
    return output


def write_assembly(path, bodies, placements, box=None):
    """An assembly file: names of bodies (files NAME.body next to it), and (name, position, quaternion) of the placements."""
    content = {
        "box_angstrom": None if box is None else [box] * 3,
        "bodies": [{"name": name, "file": f"{name}.body"} for name in bodies],
        "placements": [
            {"body": name, "position_angstrom": list(map(float, at)), "orientation_wxyz": list(map(float, turn))}
            for name, at, turn in placements
        ],
    }
    path.write_text(json.dumps(content))
    return path


def write_row(path, protomer, count, charge, box, bands=8):
    """An assembly file of balls of 8 Å in a row, with charges (e) of alternating sign off their centres."""
    folder = path.parent
    (folder / "ball.off").write_text(sphere_mesh_off(8.0, bands))
    for name, sign in [("plus", 1), ("minus", -1)]:
        (folder / f"{name}.xyzq").write_text(f"3 0 0 {sign * charge}\n-3 0 0 1\n")
        protomer("body", "--mesh", folder / "ball.off", "--charges", folder / f"{name}.xyzq", "-o", folder / f"{name}.body", parse=False)
    placements = [(["plus", "minus"][k % 2], (18.0 * k, 0, 0), (1, 0, 0, 0)) for k in range(count)]
    return write_assembly(path, ["plus", "minus"], placements, box)
