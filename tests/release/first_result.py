"""Runs the Python code of the README with an installed package, and its command on what came out."""

import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TOOLS = ["cargo", "rustc", "cc", "gcc", "clang", "ld", "make"]


def main():
    """Runs the code in a folder of its own that holds a link to the data."""
    root = Path(sys.argv[1])
    present = [tool for tool in TOOLS if shutil.which(tool)]
    assert not present, f"{present} are on the path"
    [block] = re.findall(r"^```python\n(.*?)^```", (root / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("data").symlink_to(root / "data")
        names = {}
        exec(compile(block, "README.md", "exec"), names)
        sweep = names["sweep"]
        # What the README says of it: the ring holds at 30 mM, and falls apart at 300 mM.
        assert sweep.native_contacts[0] > 0.9 > sweep.native_contacts[1]
        assert sweep.r_g_angstrom[0] < sweep.r_g_angstrom[1]
        site = Path(names["pm"].__file__)
        assert site.is_relative_to(sys.prefix), f"{site} is not the installed package"
        for words in (["--version"], ["inspect", "ring.json"], ["completions", "bash"]):
            run = subprocess.run(["protomer", *words], capture_output=True, text=True)
            assert run.returncode == 0 and run.stdout, run.stderr
        os.chdir("/")
    print(f"CPython {platform.python_version()}: the first result of the README in {time.monotonic() - start:.0f} s")


if __name__ == "__main__":
    main()
