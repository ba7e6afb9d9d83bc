"""Equations of the pages as MathML, which browsers draw without scripts and without the network.

A hook of MkDocs (`hooks` in mkdocs.yml). An equation is LaTeX between two lines that hold `$$` alone. GitHub draws it as
it is.
"""

import re
from xml.etree import ElementTree

from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError

MARK = "$$"
FENCE = re.compile(r" {0,3}(`{3,}|~{3,})")
CODE = re.compile(r"(`+).*?\1")
NAMESPACE = "http://www.w3.org/1998/Math/MathML"
# Elements of MathML with a fixed number of parts. latex2mathml leaves parts out where LaTeX would complain.
PARTS = {"mfrac": 2, "msub": 2, "msup": 2, "munder": 2, "mover": 2, "msubsup": 3, "munderover": 3}
ROWS = ("math", "mrow", "mtd", "msqrt", "mstyle")
LIMITS = {"msub": "munder", "msubsup": "munderover"}
ElementTree.register_namespace("", NAMESPACE)


class EquationError(ValueError):
    """LaTeX that cannot be converted; the message says why."""


def mathml(formula: str) -> str:
    """The `math` element of a formula in LaTeX. Raises EquationError."""
    if formula.count("{") != formula.count("}"):
        raise EquationError("its braces are not closed")
    try:
        root = ElementTree.fromstring(convert(formula, display="block"))
    except Exception as error:  # latex2mathml has a dozen of its own, and lets those of Python through
        raise EquationError(f"latex2mathml cannot read it ({error or type(error).__name__})") from error
    for element in root.iter():
        if "\\" in (element.text or ""):
            raise EquationError(f"latex2mathml does not have {element.text}")
        if len(element) != PARTS.get(kind(element), len(element)):
            raise EquationError(f"a part of {kind(element)} is missing")
    for element in list(root.iter()):
        set_limits(element)
        if kind(element) in ROWS:
            set_spaces(element)
    return ElementTree.tostring(root, encoding="unicode")


def kind(element: ElementTree.Element) -> str:
    """Name of an element without its namespace."""
    return element.tag.rpartition("}")[2]


def set_limits(element: ElementTree.Element) -> None:
    """Puts the limits of a sum or a product below and above it, also between brackets."""
    if kind(element) in LIMITS and element[0].text in ("∑", "∏"):
        element.tag = f"{{{NAMESPACE}}}{LIMITS[kind(element)]}"


def set_spaces(row: ElementTree.Element) -> None:
    """Gives a row the spaces of TeX: none about bars and slashes and after signs, thin ones about a function."""
    before = None
    for element in list(row):
        if kind(element) == "mo" and element.text in ("|", "/"):
            element.set("lspace", "0em")
            element.set("rspace", "0em")
        elif kind(element) == "mo" and element.text in ("−", "+") and is_open(before):
            element.set("form", "prefix")
        elif is_word(before, element) or is_word(element, before):
            place = list(row).index(element)
            row.insert(place, ElementTree.Element(f"{{{NAMESPACE}}}mspace", width="0.167em"))
        before = element


def is_open(before: ElementTree.Element | None) -> bool:
    """Whether a sign after this element is that of a number, not a sum or a difference."""
    return before is None or (kind(before) == "mo" and before.text in ("(", "[", "=", ",", "<", "≤", "≥"))


def is_word(element: ElementTree.Element | None, neighbour: ElementTree.Element | None) -> bool:
    """Whether an element is the name of a function, such as cos or sin², next to a symbol."""
    if element is None or neighbour is None or kind(neighbour) in ("mo", "mspace"):
        return False
    name = element[0] if kind(element) in ("msub", "msup") else element
    return kind(name) == "mi" and len(name.text or "") > 1


def typeset(markdown: str, page: str) -> str:
    """The page with MathML in the place of its equations. Raises PluginError, which ends the build."""
    lines: list[str] = []
    formula: list[str] | None = None
    fence = ""
    for line in markdown.splitlines():
        mark = FENCE.match(line)
        if formula is not None and line.strip() == MARK:
            lines += ["", block("\n".join(formula), page), ""]
            formula = None
        elif formula is not None:
            formula.append(line)
        elif fence:
            fence = "" if line.strip().startswith(fence) else fence
            lines.append(line)
        elif mark:
            fence = mark[1]
            lines.append(line)
        elif line == MARK:
            formula = []
        elif MARK in CODE.sub("", line):
            raise PluginError(f"{page}: {MARK} must stand on a line of its own: {line.strip()}")
        else:
            lines.append(line)
    if formula is not None:
        raise PluginError(f"{page}: an equation is not closed by {MARK}: {' '.join(formula)[:200]}")
    return "\n".join(lines) + "\n"


def block(formula: str, page: str) -> str:
    """An equation as HTML, whose looks are in docs/equations.css."""
    try:
        return f'<div class="equation">{mathml(formula)}</div>'
    except EquationError as error:
        raise PluginError(f"{page}: an equation cannot be converted, since {error}: {formula}") from error


def on_page_markdown(markdown, page, **_):
    """Called by MkDocs for each page."""
    return typeset(markdown, page.file.src_uri)
