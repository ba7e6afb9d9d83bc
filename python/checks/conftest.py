"""What every check needs: the binary, and small bodies made on the spot."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def protomer():
    """Runs the binary; returns the JSON object it prints, or its text."""
    binary = ROOT / "target" / "release" / "protomer"
    if not binary.exists():
        pytest.fail(f"{binary} is missing; run: cargo build --release")

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
