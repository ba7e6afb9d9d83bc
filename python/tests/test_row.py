"""The template for row: its command lines, made and run as row makes and runs them."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import protomer as pm

tomllib = pytest.importorskip("tomllib", reason="needs Python 3.11")

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = tomllib.loads((ROOT / "docs" / "cluster" / "workflow.toml").read_text())
ACTIONS = {action["name"]: action for action in WORKFLOW["action"]}


@pytest.fixture
def project(ring, tmp_path):
    """A folder with the input of both workflows, and two parts."""
    folder = tmp_path / "project"
    for part in [1, 2]:
        (folder / "workspace" / str(part)).mkdir(parents=True)
        value = folder / "workspace" / str(part) / WORKFLOW["workspace"]["value_file"]
        value.write_text(json.dumps({"part": part, "of": 2}))
    for file in [ring, ring.with_name("plus.body"), ring.with_name("minus.body")]:
        shutil.copy(file, folder)
    (folder / "ring.json").rename(folder / "assembly.json")
    settings = {"salt": "30mM,300mM", "replicas": 2, "sweeps": 20, "equilibration": 10, "seed": 7}
    pm.sweep(folder / "assembly.json", **settings, output=tmp_path / "local")
    shutil.copy(tmp_path / "local" / "run.toml", folder / "sweep.toml")
    rows = [f"{ROOT / 'data' / 'structures' / '5pti.cif.gz'},even,c{n},s{n}" for n in range(3)]
    (folder / "manifest.csv").write_text("\n".join(["file,label,cluster,name", *rows]) + "\n")
    return folder


def script(action, directories):
    """What row hands to bash: templates replaced, a command that fails ends the job."""
    command = ACTIONS[action]["command"].replace("{workspace_path}", "workspace")
    lines = [command.replace("{directories}", " ".join(path.name for path in directories))]
    if "{directory}" in command:
        values = {path: json.loads((path / "value.json").read_text()) for path in directories}
        named = {path: command.replace("{directory}", path.name) for path in directories}
        lines = [re.sub(r"{/(\w+)}", lambda key: str(values[path][key[1]]), line) for path, line in named.items()]  # noqa: B023
    return "\n".join(f"{line} || exit 2" for line in lines)


def submit(action, project):
    """Runs an action on the directories that are ready for it; says which have completed it."""
    every = sorted((project / "workspace").iterdir())
    group = ACTIONS[action].get("group", {})
    size = group.get("maximum_size", len(every))
    for previous in ACTIONS[action].get("previous_actions", []):
        assert completed(previous, every) == every
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for first in range(0, len(every), size):
        variables = {"PATH": path, "ACTION_NAME": action, "ACTION_WALLTIME_IN_MINUTES": "30"}
        job = {"cwd": project, "env": {**os.environ, **variables}, "capture_output": True, "text": True}
        run = subprocess.run(["bash", "-c", script(action, every[first : first + size])], **job, timeout=300)
        assert run.returncode == 0, run.stderr
    return completed(action, every)


def completed(action, directories):
    products = ACTIONS[action].get("products", [])
    return [path for path in directories if all((path / product).exists() for product in products)]


def test_only_what_row_replaces_stands_in_braces():
    for action in ACTIONS.values():
        assert ("{directory}" in action["command"]) != ("{directories}" in action["command"])
        in_braces = set(re.findall(r"{[^}]*}", action["command"]))
        assert in_braces <= {"{directory}", "{directories}", "{workspace_path}", "{/part}", "{/of}"}
        # row runs one process unless a launcher is named.
        assert "processes" not in {**WORKFLOW["default"]["action"]["resources"], **action.get("resources", {})}


def test_row_makes_the_local_sweep(project, tmp_path):
    assert len(submit("sweep", project)) == 2
    assert not (project / "sweep" / "sweep.csv").exists()
    submit("sweep-table", project)
    for file in ["sweep.csv", "sweep.json"]:
        assert (project / "sweep" / file).read_bytes() == (tmp_path / "local" / file).read_bytes()


def test_row_makes_the_local_set(project, monkeypatch):
    # The grids of the template are 8 times as large.
    command = ACTIONS["voxelize"]["command"]
    assert "--size 64 --spacing 1.0" in command
    small = {**ACTIONS["voxelize"], "command": command.replace("--size 64 --spacing 1.0", "--size 32 --spacing 1.5 --channels shape")}
    monkeypatch.setitem(ACTIONS, "voxelize", small)
    assert len(submit("voxelize", project)) == 2
    submit("merge", project)
    whole = {"manifest": project / "manifest.csv", "size": 32, "spacing": 1.5, "channels": "shape"}
    again = pm.voxelize(**whole, output=project / "set.zarr")
    assert (again.state, again.samples) == ("nothing-to-do", 3)
