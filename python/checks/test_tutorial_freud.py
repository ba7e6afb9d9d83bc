"""The tutorial for simulators, followed to the letter: its commands, and its analysis with gsd and freud."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "tutorial" / "soft-matter-simulator.md"


def blocks(kind):
    return re.findall(rf"^```{kind}\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, protomer):
    """A folder in which the commands of the page have run."""
    folder = tmp_path_factory.mktemp("tutorial")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    commands = [line[2:] for block in blocks("console.*?") for line in block.splitlines() if line.startswith("$ ")]
    assert commands
    for command in commands:
        subprocess.run(["sh", "-c", command], cwd=folder, env=os.environ | {"PATH": path}, check=True, capture_output=True)
    return folder


def require_equal_output(found, expected):
    assert found.splitlines() == expected.splitlines()


def test_the_analysis_prints_what_the_page_shows(folder):
    analysis, _ = blocks("python")
    (expected,) = blocks("text")
    found = subprocess.run([sys.executable, "-c", analysis], cwd=folder, check=True, capture_output=True, text=True).stdout
    require_equal_output(found, expected)
    assert (folder / "rdf.svg").stat().st_size > 0
    # The comparison must notice another gap of contacts.
    wrong = analysis.replace("GAP = 5.0", "GAP = 4.0")
    assert wrong != analysis
    other = subprocess.run([sys.executable, "-c", wrong], cwd=folder, check=True, capture_output=True, text=True).stdout
    with pytest.raises(AssertionError):
        require_equal_output(other, expected)


def test_python_reports_the_run_of_the_command_line(folder):
    _, report = blocks("python")
    found = subprocess.run([sys.executable, "-c", report], cwd=folder, check=True, capture_output=True, text=True).stdout
    log = next(folder.glob("charged/*/replica_0/log.csv")).read_text().splitlines()
    column = log[0].split(",").index("energy_kT")
    energies = [float(row.split(",")[column]) for row in log[1:]]
    assert float(found) == pytest.approx(sum(energies) / len(energies))
