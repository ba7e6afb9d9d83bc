"""B2 of residue beads against duello, which integrates over an angular grid: the same beads, charges and potential.

A fragment of eight residues with a net charge of +4, so that duello's grid can be refined in seconds;
tests/validation/duello_b2.py does the same for whole proteins.
"""

import os
import sys
from pathlib import Path

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests" / "validation"))
import duello_b2  # noqa: E402

BIN = Path(sys.executable).parent
pytestmark = pytest.mark.skipif(not (BIN / "duello").exists(), reason="duello is not installed; pip install 'duello>=0.7,<0.8'")

COARSE = duello_b2.Scan(least=3.0, most=80.0, step=1.0, divisions=1)
FINE = COARSE._replace(divisions=2)
# A structure with a pH of 4.5 at 293.15 K, for the values that duello states of lysozyme: 2CDS.
LYSOZYME = os.environ.get("PROTOMER_2CDS")
STATED = {0.1: 103_825.0, 0.5: -96_422.0}


@pytest.fixture(scope="module")
def fragment(tmp_path_factory, protomer):
    """Folder with the beads of residues 39 to 46 of BPTI."""
    folder = tmp_path_factory.mktemp("duello")
    pytest.importorskip("gemmi", reason="gemmi is not installed")
    beads = duello_b2.beads(ROOT / "data" / "structures" / "5pti.cif.gz")
    chosen = [bead for bead in beads if 39 <= bead[2] <= 46]
    assert "".join(name[0] for name, _, _ in chosen) == "AALAAAPL", "RAKRNNFK"
    duello_b2.write_inputs(chosen, folder)
    return folder


def require_equal(ours, error, fine, coarse):
    """Within three standard errors, and the step that duello's last refinement makes."""
    assert abs(ours - fine) < 3.0 * error + abs(fine - coarse)


def test_the_second_virial_coefficient_equals_duello(fragment):
    found = {}
    for salt in (0.1, 0.5):
        coarse, permittivity = duello_b2.theirs(fragment, salt, COARSE, short_range=20.0)
        fine, _ = duello_b2.theirs(fragment, salt, FINE, short_range=20.0)
        ours, error = duello_b2.ours(fragment, BIN / "protomer", salt, permittivity, relative_error=0.005)
        print(f"{salt} M: {ours:.1f} ± {error:.1f} Å³ here, {fine} and {coarse} Å³ duello")
        found[salt] = (ours, error, fine, coarse)
    for salt, values in found.items():
        require_equal(*values)
    # The comparison must notice the salt, and a tenth of the energy that makes the difference between the two.
    (ours, error, *theirs), (other, *_) = found[0.1], found[0.5]
    for wrong in (other, 0.9 * ours + 0.1 * other):
        with pytest.raises(AssertionError):
            require_equal(wrong, error, *theirs)


@pytest.mark.skipif(LYSOZYME is None, reason="PROTOMER_2CDS does not name 2CDS (https://files.rcsb.org/download/2CDS.pdb.gz)")
def test_our_integrator_finds_what_duello_states_for_lysozyme(tmp_path):
    duello_b2.convert(Path(LYSOZYME), 4.5, tmp_path)
    for salt, stated in STATED.items():
        ours, error = duello_b2.ours(tmp_path, BIN / "protomer", salt, 80.2, 293.15, relative_error=0.02)
        print(f"{salt} M: {ours:.0f} ± {error:.0f} Å³ here, {stated:.0f} Å³ stated")
        # Its grid of 42 directions is not refined and states no error; two tenths of the step between both salts.
        assert abs(ours - stated) < 3.0 * error + 0.2 * (STATED[0.1] - STATED[0.5])
