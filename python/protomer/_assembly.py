"""Assemblies and trajectories: the poses of bodies as arrays."""

from __future__ import annotations

import json
import operator
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _protomer
from ._body import Body
from ._errors import Named, unknown
from ._objects import Folder, digest_of

Floats = NDArray[np.float64]


class Frame(NamedTuple):
    """The poses of all bodies at one time.

    Attributes
    ----------
    sweep
        Sweeps of production done
    positions_angstrom
        Origins of the bodies, Å, (N, 3)
    orientations_wxyz
        Unit quaternions that turn the frame of a body into that of the assembly, scalar first, (N, 4)
    box_angstrom
        Edges of the periodic box, centred on the origin, Å, (3,); of open space, those of a cube around the bodies
    """

    sweep: int
    positions_angstrom: Floats
    orientations_wxyz: Floats
    box_angstrom: Floats


class Assembly:
    """Bodies and their poses: an assembly file as arrays. The verbs take it where they take such a file.

    Parameters
    ----------
    bodies
        The kinds of bodies by name, or a list of bodies, whose own names count
    names
        For each placed body the name of its kind; those of `bodies` in turn, if left out
    positions_angstrom
        Position of each body's origin, Å, (N, 3)
    orientations_wxyz
        Orientation of each body as a quaternion, scalar first, (N, 4), normalised here; none is turned if left out
    box_angstrom
        Edges of a periodic box centred on the origin, Å, (3,) or one number for a cube; open space if left out
    wall_radius_angstrom
        Radius of a spherical wall around the origin instead, Å

    Attributes
    ----------
    bodies
        The kinds of bodies by name
    names
        For each placed body the name of its kind, N of them
    positions_angstrom, orientations_wxyz
        The poses, (N, 3) in Å and (N, 4); they may be changed in place
    box_angstrom, wall_radius_angstrom
        The space, or None

    Raises
    ------
    KeyError
        For a name that no body has; it lists the names that exist
    ConfigError
        For arrays of other shapes, values that are not finite, and quaternions of length zero

    Examples
    --------
    >>> assembly = pm.Assembly.read("ring.json")                       # doctest: +SKIP
    >>> assembly.positions_angstrom[0] += [0.0, 0.0, 5.0]              # doctest: +SKIP
    >>> pm.inspect(assembly, salt="100mM").energy_kT                   # doctest: +SKIP
    >>> assembly.write("moved.json")                                   # doctest: +SKIP
    """

    def __init__(
        self,
        bodies: Mapping[str, Body] | Sequence[Body],
        names: Sequence[str] | None = None,
        *,
        positions_angstrom: ArrayLike,
        orientations_wxyz: ArrayLike | None = None,
        box_angstrom: ArrayLike | None = None,
        wall_radius_angstrom: float | None = None,
    ) -> None:
        by_name = bodies if isinstance(bodies, Mapping) else _by_name(bodies)
        self.bodies: Mapping[str, Body] = Named(by_name, what="body")
        self.positions_angstrom = _rows(positions_angstrom, 3, "positions_angstrom")
        count = len(self.positions_angstrom)
        if orientations_wxyz is None:
            orientations_wxyz = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        turns = _rows(orientations_wxyz, 4, "orientations_wxyz")
        lengths = np.linalg.norm(turns, axis=1)
        if np.any(lengths == 0.0):
            raise _protomer.ConfigError("a quaternion of orientations_wxyz has length zero; give unit quaternions")
        # Those of a file keep their last digits.
        unit = np.abs(lengths - 1.0) < 1e-9
        self.orientations_wxyz = np.where(unit[:, None], turns, turns / lengths[:, None])
        self.names: list[str] = list(names) if names is not None else [*self.bodies] * (count // max(1, len(self.bodies)))
        if not len(self.names) == count == len(turns):
            raise _protomer.ConfigError(
                f"there are {len(self.names)} names, {count} positions and {len(turns)} orientations; give one of each per body"
            )
        for name in self.names:
            self.bodies[name]
        box = None if box_angstrom is None else np.asarray(box_angstrom, dtype=np.float64)
        if box is not None and box.shape not in ((), (3,)):
            raise _protomer.ConfigError(f"box_angstrom has the shape {box.shape}; give three lengths, or one for a cube")
        self.box_angstrom: Floats | None = None if box is None else np.array(np.broadcast_to(box, 3))
        self.wall_radius_angstrom = wall_radius_angstrom
        self._file: tuple[Path, str] | None = None

    @classmethod
    def read(cls, path: Path | str) -> Assembly:
        """Reads an assembly file and the bodies that it names.

        Parameters
        ----------
        path
            The file, such as one of `pm.assemble.ring`

        Returns
        -------
        Assembly

        Raises
        ------
        MissingFileError
            If the file or that of a body does not exist; also a `FileNotFoundError`
        ParseError, ProtomerError
            If one of them cannot be understood

        Examples
        --------
        >>> pm.Assembly.read("ring.json").positions_angstrom.shape     # doctest: +SKIP
        (4, 3)
        """
        kinds, names, (positions, orientations), box, wall = _protomer.read_assembly(path)
        bodies = {name: Body._of_file(native, Path(file)) for name, file, native in kinds}
        assembly = cls(
            bodies,
            names,
            positions_angstrom=positions,
            orientations_wxyz=orientations,
            box_angstrom=box,
            wall_radius_angstrom=wall,
        )
        digest = digest_of(Path(path))
        if digest is not None:
            assembly._file = (Path(path).absolute(), assembly._fingerprint(digest))
        return assembly

    def write(self, path: Path | str, *, force: bool = False) -> Path:
        """Writes an assembly file. Bodies that are no files yet are written next to it, into `NAME_input`.

        Parameters
        ----------
        path
            The file to write, which ends in `.json`
        force
            Whether existing files with other content are replaced

        Returns
        -------
        Path
            The file

        Raises
        ------
        FileExistsError
            If it exists with other content, unless `force` is set

        Examples
        --------
        >>> assembly.write("moved.json")                               # doctest: +SKIP
        """
        file = Path(path)
        bodies = Folder(file.with_name(f"{file.stem}_input"), replace=force)
        content = self._content(bodies, file.parent)
        if file.exists() and file.read_bytes() != content and not force:
            raise FileExistsError(f"{file} already exists; choose another name, or overwrite it with force=True")
        file.write_bytes(content)
        return file

    def with_poses(self, positions_angstrom: ArrayLike, orientations_wxyz: ArrayLike) -> Assembly:
        """The same bodies in the same space at other poses.

        Parameters
        ----------
        positions_angstrom, orientations_wxyz
            The poses, (N, 3) in Å and (N, 4)

        Returns
        -------
        Assembly

        Raises
        ------
        ConfigError
            As for a new assembly

        Examples
        --------
        >>> frame = pm.SimulationResult.read("run").trajectory()[-1]                            # doctest: +SKIP
        >>> last = assembly.with_poses(frame.positions_angstrom, frame.orientations_wxyz)       # doctest: +SKIP
        """
        return Assembly(
            self.bodies,
            self.names,
            positions_angstrom=positions_angstrom,
            orientations_wxyz=orientations_wxyz,
            box_angstrom=self.box_angstrom,
            wall_radius_angstrom=self.wall_radius_angstrom,
        )

    @property
    def rotations(self) -> Floats:
        """The orientations as matrices, (N, 3, 3): a point r of a body is at rotations[n] @ r + positions_angstrom[n]."""
        w, x, y, z = np.moveaxis(self.orientations_wxyz, -1, 0)
        rows = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        return np.moveaxis(np.array(rows), -1, 0)

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        kinds = ", ".join(f"{self.names.count(name)} {name}" for name in self.bodies)
        if self.box_angstrom is not None:
            space = "box " + " × ".join(f"{length:g}" for length in self.box_angstrom) + " Å"
        elif self.wall_radius_angstrom is not None:
            space = f"wall of radius {self.wall_radius_angstrom:g} Å"
        else:
            space = "open space"
        return f"Assembly({kinds}; {space})"

    def _fingerprint(self, digest: str) -> str:
        """Changes with the file and with whatever of the assembly can change."""
        state = [self.names, self.positions_angstrom.tolist(), self.orientations_wxyz.tolist(), [*self.bodies]]
        box = None if self.box_angstrom is None else self.box_angstrom.tolist()
        identities = [id(body) for body in self.bodies.values()]
        return json.dumps([digest, state, box, self.wall_radius_angstrom, identities])

    def _present_file(self) -> Path | None:
        if self._file is None:
            return None
        path, fingerprint = self._file
        digest = digest_of(path)
        if digest is None or self._fingerprint(digest) != fingerprint:
            return None
        is_whole = all(body._present_file() is not None for body in self.bodies.values())
        return path if is_whole else None

    def _write_file(self, folder: Folder) -> Path:
        return folder.write("assembly", ".json", self._content(folder, folder.path))

    def _content(self, bodies: Folder, parent: Path) -> bytes:
        """The text of the file, in the folder `parent`."""
        entries = []
        for name, body in self.bodies.items():
            file = body._present_file() or body._write_file(bodies)
            entries.append({"name": name, "file": Path(os.path.relpath(file, parent)).as_posix()})
        placements = [
            {"body": name, "position_angstrom": position, "orientation_wxyz": turn}
            for name, position, turn in zip(self.names, self.positions_angstrom.tolist(), self.orientations_wxyz.tolist())
        ]
        fields: dict[str, Any] = {"box_angstrom": None if self.box_angstrom is None else self.box_angstrom.tolist()}
        if self.wall_radius_angstrom is not None:
            fields["wall_radius_angstrom"] = self.wall_radius_angstrom
        fields |= {"bodies": entries, "placements": placements}
        return (json.dumps(fields, indent=2) + "\n").encode()


class Trajectory(_protomer.Trajectory):
    """The poses of a simulation, read frame by frame: a sequence of `Frame`.

    Parameters
    ----------
    path
        A file `trajectory.gsd`; results name theirs (`SweepResult.trajectories`)

    Attributes
    ----------
    path
        The file
    names
        For each body the name of its kind, N of them

    Raises
    ------
    MissingFileError
        If there is no such file; also a `FileNotFoundError`
    ParseError
        If it is not a trajectory of rigid bodies

    Examples
    --------
    >>> trajectory = pm.SimulationResult.read("run").trajectory()      # doctest: +SKIP
    >>> trajectory[-1].positions_angstrom                              # doctest: +SKIP
    >>> trajectory.positions_angstrom.shape                            # doctest: +SKIP
    (20, 4, 3)
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path).absolute()
        self.names: list[str] = self._names()

    def __len__(self) -> int:
        return self._frames()

    @overload
    def __getitem__(self, frame: int) -> Frame: ...

    @overload
    def __getitem__(self, frame: slice) -> list[Frame]: ...

    def __getitem__(self, frame: int | slice) -> Frame | list[Frame]:
        if isinstance(frame, slice):
            return [self[number] for number in range(*frame.indices(len(self)))]
        number = operator.index(frame)
        if not -len(self) <= number < len(self):
            raise IndexError(f"{self.path} has no frame {number}, only {len(self)} of them")
        sweep, box, (positions, orientations) = self._frame(number % len(self))
        return Frame(sweep, positions, orientations, np.array(box))

    def __iter__(self) -> Iterator[Frame]:
        return (self[number] for number in range(len(self)))

    @property
    def sweeps(self) -> NDArray[np.int64]:
        """Sweeps done at each frame, (F,)."""
        return np.array([frame.sweep for frame in self], dtype=np.int64)

    @property
    def positions_angstrom(self) -> Floats:
        """Origins of the bodies in all frames, Å, (F, N, 3)."""
        return np.array([frame.positions_angstrom for frame in self]).reshape(len(self), len(self.names), 3)

    @property
    def orientations_wxyz(self) -> Floats:
        """Orientations of the bodies in all frames, scalar first, (F, N, 4)."""
        return np.array([frame.orientations_wxyz for frame in self]).reshape(len(self), len(self.names), 4)

    def __repr__(self) -> str:
        return f"Trajectory({str(self.path)!r}, {len(self)} frames of {len(self.names)} bodies)"


def _rows(values: ArrayLike, columns: int, name: str) -> Floats:
    rows = np.array(values, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != columns or not len(rows):
        raise _protomer.ConfigError(f"{name} has the shape {rows.shape}; give (N, {columns}) with a row for each body")
    if not np.all(np.isfinite(rows)):
        raise _protomer.ConfigError(f"{name} contains values that are not finite; remove them")
    return rows


def _by_name(bodies: Sequence[Body]) -> dict[str, Body]:
    by_name: dict[str, Body] = {}
    for body in bodies:
        if body.name in by_name:
            raise _protomer.ConfigError(f"two bodies are named {body.name!r}; give a dictionary with names of your own")
        by_name[body.name] = body
    return by_name


def nearest(known: Sequence[float], asked: float, what: str) -> int:
    """The place of a number in a list: the same to one part in a million, or the only one that rounds to the
    decimals of `asked` in thousandths, as tables show salts in mmol/L; KeyError with the numbers that exist."""
    for place, value in enumerate(known):
        if abs(value - asked) <= 1e-6 * max(abs(value), 1e-6):
            return place
    rounding = [place for place, value in enumerate(known) if _rounds_to(1e3 * value, 1e3 * asked)]
    if len({known[place] for place in rounding}) == 1:
        return rounding[0]
    unknown(what, asked, known)


def _rounds_to(value: float, asked: float) -> bool:
    """Whether a number rounds to another at the decimals of that."""
    slack = 1e-9 * abs(asked)
    decimals = next((number for number in range(6) if abs(round(asked, number) - asked) <= slack), 6)
    return abs(value - asked) <= 0.5 * 10.0**-decimals + slack
