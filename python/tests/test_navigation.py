"""The site has every page that its lists link (docs/navigation.py)."""

import importlib.util
from pathlib import Path

import pytest
from mkdocs.exceptions import PluginError

ROOT = Path(__file__).resolve().parents[2]
SPECIFICATION = importlib.util.spec_from_file_location("navigation", ROOT / "docs" / "navigation.py")
navigation = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(navigation)


@pytest.mark.parametrize("kind", ["guide", "methods", "validation"])
def test_a_list_has_every_page_of_its_kind(kind):
    listed = navigation.pages(f"docs/{kind}.md#")
    assert sorted(listed) == sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs" / kind).glob("*.md"))


def test_a_list_is_replaced_by_its_pages_in_order():
    nav = ["a.md", {"Learning": ["docs/guide.md#Learning", {"Home": "README.md"}]}]
    learning = [f"docs/guide/{page}.md" for page in ("voxelize", "train", "predict")]
    assert navigation.expanded(nav) == ["a.md", {"Learning": [*learning, {"Home": "README.md"}]}]


def test_an_entry_without_pages_says_what_to_write():
    with pytest.raises(PluginError, match="beginning of a heading of docs/guide.md"):
        navigation.pages("docs/guide.md#Cooking")
    with pytest.raises(PluginError, match="names no page"):
        navigation.pages("docs/gide.md#Proteins")
