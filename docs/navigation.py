"""Entries of the site for the pages that a list links.

A hook of MkDocs (`hooks` in mkdocs.yml). An entry `docs/guide.md#Proteins` of its `nav` stands for all pages of docs/guide
that docs/guide.md links below headings that begin with "Proteins", in that order; `docs/methods.md#` stands for all that are linked
below any heading.
"""

import re
from pathlib import Path

from mkdocs.exceptions import PluginError

ROOT = Path(__file__).resolve().parents[1]
HEADING = re.compile(r"## (.*)")
LINK = re.compile(r"\]\(([\w-]+)/([\w-]+\.md)\)")


def pages(entry: str) -> list[str]:
    """The pages of an entry such as docs/guide.md#Proteins, each once. Raises PluginError if there are none."""
    name, _, beginning = entry.partition("#")
    path = ROOT / name
    if not path.is_file():
        raise PluginError(f"mkdocs.yml: {entry} names no page; write the path of a list, such as docs/guide.md#Proteins")
    found: dict[str, None] = {}
    is_listed = False
    for line in path.read_text(encoding="utf-8").splitlines():
        if heading := HEADING.match(line):
            is_listed = heading[1].startswith(beginning)
        elif is_listed:
            # A list may link other pages too.
            own = [page for folder, page in LINK.findall(line) if folder == path.stem]
            found |= dict.fromkeys(f"{name.removesuffix('.md')}/{page}" for page in own)
    if not found:
        raise PluginError(f"mkdocs.yml: {entry} stands for no page; write the beginning of a heading of {name}")
    return list(found)


def expanded(entries):
    """Entries of `nav`, with pages in the place of lists."""
    whole = []
    for entry in entries:
        if isinstance(entry, str) and "#" in entry:
            whole += pages(entry)
        elif isinstance(entry, dict):
            whole.append({title: expanded(below) if isinstance(below, list) else below for title, below in entry.items()})
        else:
            whole.append(entry)
    return whole


def on_config(config, **_):
    """Called by MkDocs once, before anything is built."""
    config.nav = expanded(config.nav)
    return config
