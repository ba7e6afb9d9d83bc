"""Bodies and assemblies where verbs take files.

An object that a verb takes as a file is written where the work is kept (`DIR/input`), once per content. So the command line
continues and reads what Python began, and the other way round.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, runtime_checkable

from ._protomer import ProtomerError

KEPT_IN_OUTPUT = frozenset({"simulate", "sweep", "pair"})
"""Verbs whose directory keeps its input, so that the same call continues it and others find the bodies."""
KEPT_BESIDE_OUTPUT = frozenset({"assemble", "candidates"})
"""Verbs that write files which name the bodies."""
LONGEST_FILE_NAME_BYTES = 200
"""Longest file name without its ending: file systems take 255 bytes with it."""


@runtime_checkable
class HasFile(Protocol):
    """What a verb takes as a file."""

    def _present_file(self) -> Path | None:
        """The file that holds this object already, unless it has changed since."""

    def _write_file(self, folder: Folder) -> Path:
        """Writes it into a folder."""


def file_name(name: str) -> str:
    """A name for a file: letters, digits and harmless signs, not too long, not hidden, never a path or a flag."""
    stem = "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in name).lstrip(".-")
    # The bytes of a letter that is cut through are dropped.
    return stem.encode()[:LONGEST_FILE_NAME_BYTES].decode(errors="ignore") or "unnamed"


class Folder:
    """A folder for objects, which holds each under its own name."""

    def __init__(self, path: Path, *, replace: bool) -> None:
        self.path = path
        self._replace = replace
        self._taken: dict[str, str] = {}

    def write(self, name: str, ending: str, content: bytes) -> Path:
        """Writes a file, or finds it there; another one of the same call under this name gets a number."""
        stem = file_name(name)
        digest = hashlib.sha256(content).hexdigest()
        number = 1
        while True:
            path = self.path / (f"{stem}{ending}" if number == 1 else f"{stem}_{number}{ending}")
            # Some file systems do not tell capital letters from small ones.
            if self._taken.setdefault(path.name.lower(), digest) == digest:
                break
            number += 1
        if not _holds(path, digest):
            if path.exists() and not self._replace:
                raise ProtomerError(
                    f"{path} holds something else than what is given now; choose another output, or call with force=True"
                )
            self.path.mkdir(parents=True, exist_ok=True)
            partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
            partial.write_bytes(content)
            os.replace(partial, path)
        return path


class Files:
    """The files of the objects among the arguments of a call; those that nobody needs later exist during the call."""

    def __init__(self, verb: Sequence[str], output: Any, *, replace: bool) -> None:
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._folder: Folder | None = None
        if output is not None and verb[0] in KEPT_IN_OUTPUT:
            self._folder = Folder(Path(output) / "input", replace=replace)
        elif output is not None and verb[0] in KEPT_BESIDE_OUTPUT:
            path = Path(output)
            stem = path.stem if path.suffix == ".json" else path.name
            self._folder = Folder(path.with_name(f"{stem}_input"), replace=replace)

    def named(self, value: Any) -> Any:
        """The value with files instead of objects, also within a list."""
        if isinstance(value, HasFile):
            return value._present_file() or value._write_file(self._place())
        if isinstance(value, (list, tuple)):
            return [self.named(item) for item in value]
        return value

    def _place(self) -> Folder:
        if self._folder is None:
            self._temporary = tempfile.TemporaryDirectory(prefix="protomer-")
            self._folder = Folder(Path(self._temporary.name), replace=False)
        return self._folder

    def __enter__(self) -> Files:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._temporary is not None:
            self._temporary.cleanup()


def digest_of(path: Path) -> str | None:
    """SHA-256 of a file; None if it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None


def _holds(path: Path, digest: str) -> bool:
    return digest_of(path) == digest
