"""pKa values of BPTI against PROPKA 3, which finds them by empirical rules instead of the Poisson-Boltzmann equation.

The two methods differ, so most groups must agree to 1.5 units and not all; tests/validation/measured_pka.py compares both
with measured values.
"""

import math
import sys

import gemmi
import pytest

from conftest import ROOT

pytest.importorskip("propka.run", reason="propka is not installed; pip install 'propka>=3.5'")
sys.path.insert(0, str(ROOT / "tests" / "validation"))
import measured_pka  # noqa: E402

UNITS = 1.5
LEAST_SHARE = 0.9


@pytest.fixture(scope="module")
def inhibitor(tmp_path_factory):
    """BPTI as a PDB file with one conformation and heavy atoms only: PROPKA reads no mmCIF and averages conformations."""
    structure = gemmi.read_structure(str(ROOT / "data" / "structures" / "5pti.cif.gz"))
    structure.setup_entities()
    structure.remove_hydrogens()
    structure.remove_ligands_and_waters()
    structure.remove_alternative_conformations()
    path = tmp_path_factory.mktemp("titration") / "bpti.pdb"
    structure.write_pdb(str(path))
    return path


def require_agreement(ours, theirs):
    """The same groups, and most pKa values within 1.5 units."""
    assert set(ours) == set(theirs)
    near = [abs(ours[group] - theirs[group]) < UNITS for group in ours]
    assert sum(near) >= LEAST_SHARE * len(near)


def test_most_pka_values_are_near_those_of_propka(protomer, inhibitor):
    theirs = measured_pka.propka_values(inhibitor)
    answer = protomer("titrate", inhibitor, "--ph", 7, "--salt", "100mM", "--json")
    ours = {group: values["protomer"] for group, values in measured_pka.titrated(answer).items()}
    for group in ours:
        print(*group, f"{ours[group]:.2f} here, {theirs.get(group, math.nan):.2f} PROPKA")
    # Two Asp, two Glu, four Tyr, four Lys, six Arg and both ends; all cysteines are in disulfides.
    assert len(ours) == 20
    require_agreement(ours, theirs)
    # The comparison must notice pKb for pKa, kT for units of pKa, values of the group before, and a missing group.
    groups, values = list(ours), list(ours.values())
    wrong = [
        {group: 14.0 - pka for group, pka in ours.items()},
        {group: math.log(10) * pka for group, pka in ours.items()},
        dict(zip(groups, values[-1:] + values[:-1])),
        dict(list(ours.items())[1:]),
    ]
    for broken in wrong:
        with pytest.raises(AssertionError):
            require_agreement(broken, theirs)
