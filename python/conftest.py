"""What the tests of the package and the checks against other programs share."""

import os

import pytest


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory):
    """Energy tables are kept from test to test, as a user's are from run to run, but not in the tester's own cache."""
    with pytest.MonkeyPatch.context() as patch:
        # test.sh has one for all tests.
        folder = os.environ.get("PROTOMER_TEST_CACHE_DIR") or str(tmp_path_factory.mktemp("cache"))
        patch.setenv("PROTOMER_CACHE_DIR", folder)
        yield
