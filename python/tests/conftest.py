"""Small input for the tests: two variants of the bundled BPTI, and a ring of them."""

import os
from pathlib import Path

import pytest

import protomer as pm

ROOT = Path(__file__).resolve().parents[2]
BPTI = ROOT / "data" / "structures" / "5pti.cif.gz"


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory):
    """Energy tables are kept from test to test, as a user's are from run to run, but not in the tester's own cache."""
    with pytest.MonkeyPatch.context() as patch:
        # test.sh has one for all tests.
        folder = os.environ.get("PROTOMER_TEST_CACHE_DIR") or str(tmp_path_factory.mktemp("cache"))
        patch.setenv("PROTOMER_CACHE_DIR", folder)
        yield


@pytest.fixture(scope="session")
def bodies(tmp_path_factory):
    """Folder with plus.body and minus.body. Few charges and a coarse surface make every energy cheap."""
    folder = tmp_path_factory.mktemp("bodies")
    cheap = {"charges": "formal", "density": 0.5}
    pm.ingest(BPTI, output=folder, name="plus", mutate=["A:D3K", "A:E7K", "A:E49K", "A:D50K"], **cheap)
    pm.ingest(BPTI, output=folder, name="minus", mutate=["A:R1E", "A:K15E", "A:R17E", "A:K26E", "A:R39E"], **cheap)
    return folder


@pytest.fixture(scope="session")
def ring(bodies):
    """An assembly file: four bodies of alternating charge in a ring. In a smaller box many images would count."""
    path = bodies / "ring.json"
    pm.assemble.ring([bodies / "plus.body", bodies / "minus.body"], members=4, box=640.0, output=path)
    return path


@pytest.fixture(scope="session")
def pebbles(tmp_path_factory):
    """Two body files of three atoms each, of opposite charge: pairs of them take little time."""
    folder = tmp_path_factory.mktemp("pebbles")
    for name, sign in [("plus", 1), ("minus", -1)]:
        atoms = [(0, 0, 0, 4 * sign, 6), (5, 0, 0, sign, 4), (0, 6, 0, sign, 3)]
        lines = [f"ATOM {n} Q ION 1 {x} {y} {z} {charge} {radius}" for n, (x, y, z, charge, radius) in enumerate(atoms, 1)]
        (folder / f"{name}.pqr").write_text("\n".join(lines) + "\n")
        pm.ingest(folder / f"{name}.pqr", output=folder, density=0.4)
    return [folder / "plus.body", folder / "minus.body"]
