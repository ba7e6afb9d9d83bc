"""Notebooks: in step with their sources, without outputs, and every one runs in its short form."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).resolve().parents[2] / "notebooks"
SOURCES = sorted(NOTEBOOKS.glob("*.py"))
SHORT = {"PROTOMER_FAST": "1", "MPLBACKEND": "Agg"}
# Each is made to take less than 30 s; the rest is for machines with much else to do.
LIMIT_S = 120


def cells_of_source(text):
    """The cells of a percent-format source as (kind, text), the header left out."""
    cells = []
    for part in text.split("\n# %%")[1:]:
        mark, _, body = part.partition("\n")
        kind = "markdown" if "[markdown]" in mark else "code"
        body = body.strip("\n")
        if kind == "markdown":
            body = "\n".join(line.removeprefix("#").removeprefix(" ") for line in body.splitlines())
        cells.append((kind, body))
    return cells


def cells_of_notebook(notebook):
    """The cells of a notebook as (kind, text)."""
    return [(cell["cell_type"], "".join(cell["source"])) for cell in notebook["cells"]]


def compare(source, notebook):
    """That both hold the same cells, and that nothing has been run in the notebook."""
    assert cells_of_notebook(notebook) == cells_of_source(source)
    for cell in notebook["cells"]:
        assert not cell.get("outputs") and cell.get("execution_count") is None, "strip its outputs"


def test_there_are_notebooks_and_each_has_its_source():
    assert len(SOURCES) >= 6
    assert [path.stem for path in SOURCES] == sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb"))


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.stem)
def test_a_notebook_is_its_source_without_outputs(source):
    text, notebook = source.read_text(), json.loads(source.with_suffix(".ipynb").read_text())
    compare(text, notebook)
    with pytest.raises(AssertionError):
        compare(text.replace("import protomer as pm", "import protomer"), notebook)
    last = next(cell for cell in reversed(notebook["cells"]) if cell["cell_type"] == "code")
    last["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "1"}]
    with pytest.raises(AssertionError, match="strip"):
        compare(text, notebook)


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.stem)
def test_a_notebook_runs_and_asserts(source):
    code = source.read_text()
    assert "\nassert " in code or "\n    assert " in code
    # Started within the project, but not at its root.
    run = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", source.name],
        cwd=NOTEBOOKS,
        env={**os.environ, **SHORT},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert run.returncode == 0, run.stderr


def test_a_notebook_runs_in_jupyter():
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed")
    notebook = nbformat.read(NOTEBOOKS / "emuda.ipynb", as_version=4)
    resources = {"metadata": {"path": str(NOTEBOOKS)}}
    nbclient.NotebookClient(notebook, timeout=LIMIT_S, kernel_name="python3", resources=resources).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    figures = [output for output in shown if "image/png" in output["data"]]
    assert len(figures) == 3 == len(shown), "a figure each, and no values that were not meant to be shown"
