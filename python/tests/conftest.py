"""Small input for the tests: two variants of the bundled BPTI, and a ring of them."""

from pathlib import Path

import pytest

import protomer as pm

ROOT = Path(__file__).resolve().parents[2]
BPTI = ROOT / "data" / "structures" / "5pti.cif.gz"


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory):
    """Energy tables are kept from test to test, as a user's are from run to run, but not in the tester's own cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PROTOMER_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def bodies(tmp_path_factory):
    """Folder with plus.body and minus.body."""
    folder = tmp_path_factory.mktemp("bodies")
    pm.ingest(BPTI, output=folder, name="plus", mutate=["A:D3K", "A:E7K", "A:E49K", "A:D50K"])
    pm.ingest(BPTI, output=folder, name="minus", mutate=["A:R1E", "A:K15E", "A:R17E", "A:K26E", "A:R39E"])
    return folder


@pytest.fixture(scope="session")
def ring(bodies):
    """An assembly file: four bodies of alternating charge in a ring. In a smaller box many images would count."""
    path = bodies / "ring.json"
    pm.assemble.ring([bodies / "plus.body", bodies / "minus.body"], members=4, box=640.0, output=path)
    return path
