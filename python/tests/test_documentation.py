"""Runs the Python code of the documentation unchanged."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = ["README.md", "python/README.md", "docs/guide/python.md"]


@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed").use("Agg")
    pytest.importorskip("pandas", reason="pandas is not installed")
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.MULTILINE | re.DOTALL)
    assert blocks
    # The pages speak from the root of the project.
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    # What the pages say of it: an assembly that holds at 30 mM, and at 300 mM does not.
    sweep = names["sweep"]
    assert list(sweep.salt_molar) == [0.03, 0.3]
    assert sweep.native_contacts[0] > 0.9 > sweep.native_contacts[1]
    assert sweep.r_g_angstrom[0] < sweep.r_g_angstrom[1]
