"""The equations of the documentation can be drawn by a browser (docs/equations.py)."""

import importlib.util
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from mkdocs.exceptions import PluginError

ROOT = Path(__file__).resolve().parents[2]
PAGES = [path.relative_to(ROOT).as_posix() for path in sorted((ROOT / "docs").rglob("*.md"))]
SPECIFICATION = importlib.util.spec_from_file_location("equations", ROOT / "docs" / "equations.py")
equations = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(equations)


def drawn(page):
    """The `math` elements of a page, and how many equations its text has."""
    text = (ROOT / page).read_text()
    html = equations.typeset(text, page)
    assert not re.search(r"^\$\$$", html, re.MULTILINE)
    return re.findall(r"<math.*?</math>", html, re.DOTALL), len(re.findall(r"^\$\$$", text, re.MULTILINE)) / 2


@pytest.mark.parametrize("page", PAGES)
def test_every_equation_of_a_page_is_mathml(page):
    elements, equations_of_page = drawn(page)
    assert len(elements) == equations_of_page
    for element in elements:
        assert "\\" not in element and "$" not in element
        for part in ElementTree.fromstring(element).iter():
            assert len(part) == equations.PARTS.get(equations.kind(part), len(part))


def test_the_methods_have_equations():
    methods = [page for page in PAGES if page.startswith("docs/methods/")]
    assert sum(len(drawn(page)[0]) for page in methods) > 40


@pytest.mark.parametrize(
    "formula, reason",
    [
        (r"a = \mistake b", r"does not have \\mistake"),
        (r"\frac{1}", "part of mfrac is missing"),
        (r"\frac{1}{2", "braces are not closed"),
        (r"a & = b", "cannot read it"),
        (r"a_", "cannot read it|part of msub is missing"),
    ],
)
def test_an_error_names_page_and_formula(formula, reason):
    with pytest.raises(PluginError, match=f"^page.md: .*{reason}") as error:
        equations.typeset(f"Text.\n\n$$\n{formula}\n$$\n", "page.md")
    assert str(error.value).endswith(formula)


def test_spaces_and_limits_are_those_of_tex():
    html = equations.mathml(r"-|a| = \left[ \sum_k \cos \gamma_k \right] - b")
    assert html.count('form="prefix">−') == 1 and html.count("<mo>−</mo>") == 1
    assert html.count('<mo stretchy="false" lspace="0em" rspace="0em">|</mo>') == 2
    assert "<munder><mo>∑</mo><mi>k</mi></munder>" in html
    assert re.search("<mspace[^>]*/><mi>cos</mi><mspace[^>]*/><msub><mi>γ</mi>", html)
    assert re.search("<mn>4</mn><mspace[^>]*/><msup><mi>sin</mi><mn>2</mn></msup><mo", equations.mathml(r"4 \sin^2(x)"))


def test_marks_stand_alone_and_in_pairs():
    with pytest.raises(PluginError, match="page.md: .*not closed.*a = b"):
        equations.typeset("$$\na = b\n", "page.md")
    with pytest.raises(PluginError, match="page.md: .*line of its own.*c = d"):
        equations.typeset("Here $$c = d$$.\n", "page.md")


def test_code_is_left_alone():
    page = "The mark `$$`.\n\n```\n$$\n\\frac\n$$\n```\n"
    assert equations.typeset(page, "page.md") == page
