"""Rigid bodies as arrays."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _protomer
from ._call import call
from ._errors import PartialError
from ._objects import Folder, digest_of
from ._chart import new_axes
from ._result import Result, missing

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Body(_protomer.Body):
    """A rigid body in its own frame: a closed surface mesh with point charges; immutable.

    Arrays are in Å and e; `vertices_angstrom` is (N, 3), `triangles` (M, 3), `charge_positions_angstrom` (S, 3),
    `charges_e` (S,). The verbs take a body where they take a body file.

    Examples
    --------
    >>> plus, minus = pm.Body.read("plus.body"), pm.Body.read("minus.body")    # doctest: +SKIP
    >>> pm.pair(plus, minus, salt_molar=[0.05, 0.1]).b2_angstrom3              # doctest: +SKIP
    """

    _file: tuple[Path, str] | None = None

    @classmethod
    def read(cls, path: Path | str) -> Body:
        """Reads a body file written by `protomer.ingest` or `protomer.body`.

        Parameters
        ----------
        path
            The file

        Returns
        -------
        Body

        Raises
        ------
        MissingFileError
            If there is no such file; also a `FileNotFoundError`
        ParseError
            If it is not a body file, or damaged

        Examples
        --------
        >>> pm.Body.read("bodies/plus.body").net_charge_e              # doctest: +SKIP
        """
        return cls._of_file(_protomer.Body._read(path), Path(path))

    @classmethod
    def _of_file(cls, native: _protomer.Body, path: Path) -> Body:
        body = cls(native)
        digest = digest_of(path)
        if digest is not None:
            body._file = (path.absolute(), digest)
        return body

    @property
    def path(self) -> Path | None:
        """The body file it was read from; None for a body that was made in Python."""
        return None if self._file is None else self._file[0]

    @classmethod
    def from_arrays(
        cls,
        *,
        vertices_angstrom: ArrayLike,
        triangles: ArrayLike,
        charge_positions_angstrom: ArrayLike | None = None,
        charges_e: ArrayLike | None = None,
        name: str = "body",
    ) -> Body:
        """A body of a mesh and point charges.

        Parameters
        ----------
        vertices_angstrom
            Vertices of a closed surface, Å, (N, 3)
        triangles
            Vertices of each triangle, counted from zero, counter-clockwise seen from outside, (M, 3)
        charge_positions_angstrom, charges_e
            Point charges, Å, (S, 3) and e, (S,); none if left out
        name
            Its name in assemblies and tables

        Returns
        -------
        Body

        Raises
        ------
        GeometryError
            For a mesh that bounds no solid
        ProtomerError
            For arrays that do not match

        Examples
        --------
        >>> corners = [[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]]
        >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
        >>> round(pm.Body.from_arrays(vertices_angstrom=corners, triangles=faces).volume_angstrom3, 6)
        4.5
        """
        positions = np.zeros((0, 3)) if charge_positions_angstrom is None else charge_positions_angstrom
        charges = np.zeros(0) if charges_e is None else charges_e
        return cls(
            _protomer.Body._from_arrays(
                name,
                np.ascontiguousarray(vertices_angstrom, dtype=np.float64),
                np.ascontiguousarray(triangles, dtype=np.uint32),
                np.ascontiguousarray(positions, dtype=np.float64),
                np.ascontiguousarray(charges, dtype=np.float64),
            )
        )

    @classmethod
    def from_structure(cls, path: Path | str, **settings: Any) -> Body:
        """Makes a body from a structure file without leaving files.

        Parameters
        ----------
        path
            PDB, mmCIF or PQR, each also gzipped
        **settings
            The keywords of `protomer.ingest`

        Returns
        -------
        Body

        Raises
        ------
        MissingFileError
            If there is no such file; also a `FileNotFoundError`
        ProtomerError
            If no body can be made of it

        Examples
        --------
        >>> pm.Body.from_structure("5pti.cif.gz", ph=7.4).volume_angstrom3     # doctest: +SKIP
        """
        if not Path(path).exists():
            raise missing(f"cannot read {path}: there is no such file", path)
        with tempfile.TemporaryDirectory() as folder:
            try:
                # Not by the function of the verb, whose module knows bodies.
                flags = {f"--{name.replace('_', '-')}": value for name, value in settings.items()}
                files: Sequence[Any] = call(Result, ["ingest"], [path], {"--output": folder, **flags}, None).files
            except PartialError as error:
                failed = [file["error"] for file in error.result.files if file["error"]]
                raise _protomer.ProtomerError(failed[0]) from None
            if len(files) != 1:
                raise _protomer.ProtomerError(f"{path}: {len(files)} structures; use protomer.ingest for several")
            return cls(_protomer.Body._read(files[0]["body"]))

    @classmethod
    def from_universe(cls, atoms: Any, *, name: str | None = None, **settings: Any) -> Body:
        """Makes a body from the present state of an MDAnalysis Universe or AtomGroup.

        Parameters
        ----------
        atoms
            A Universe or an AtomGroup
        name
            Its name in assemblies and tables; that of the file of the Universe if left out, or `universe` without one
        **settings
            The keywords of `protomer.ingest`

        Returns
        -------
        Body

        Raises
        ------
        ProtomerError
            If no body can be made of it

        Examples
        --------
        >>> universe = MDAnalysis.Universe("5pti.pdb")                 # doctest: +SKIP
        >>> pm.Body.from_universe(universe.select_atoms("protein"))    # doctest: +SKIP
        >>> pm.Body.from_universe(universe.select_atoms("segid B"), name="inhibitor")  # doctest: +SKIP
        """
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "universe.pdb"
            atoms.atoms.write(str(path))
            return cls.from_structure(path, name=name or _name_of(atoms), **settings)

    def _present_file(self) -> Path | None:
        if self._file is None:
            return None
        path, digest = self._file
        return path if digest_of(path) == digest else None

    def _write_file(self, folder: Folder) -> Path:
        with tempfile.TemporaryDirectory() as other:
            path = Path(other) / "written.body"
            self.write(path)
            return folder.write(self.name, ".body", path.read_bytes())

    def to_universe(self) -> Any:
        """The charge sites as an MDAnalysis Universe.

        Returns
        -------
        MDAnalysis.Universe
            With names, residues, charges and radii; positions in Å

        Raises
        ------
        ImportError
            Without MDAnalysis

        Examples
        --------
        >>> body.to_universe().select_atoms("resname LYS").charges.sum()       # doctest: +SKIP
        """
        import MDAnalysis

        count = len(self.charges_e)
        residues = self.residues or [("", 0, "", "UNK")]
        index = np.maximum(self.residue_indices, 0)
        chains = sorted({residue[0] for residue in residues})
        universe = MDAnalysis.Universe.empty(
            count,
            n_residues=len(residues),
            n_segments=len(chains),
            atom_resindex=index,
            residue_segindex=[chains.index(residue[0]) for residue in residues],
            trajectory=True,
        )
        universe.add_TopologyAttr("names", self.atom_names)
        universe.add_TopologyAttr("charges", self.charges_e)
        universe.add_TopologyAttr("radii", self.radii_angstrom)
        universe.add_TopologyAttr("resnames", [residue[3] for residue in residues])
        universe.add_TopologyAttr("resids", [residue[1] for residue in residues])
        universe.add_TopologyAttr("icodes", [residue[2] for residue in residues])
        universe.add_TopologyAttr("segids", chains)
        universe.add_TopologyAttr("chainIDs", [residues[place][0] for place in index])
        universe.atoms.positions = self.charge_positions_angstrom
        return universe

    def to_trimesh(self) -> Any:
        """The surface for trimesh.

        Returns
        -------
        trimesh.Trimesh
            Lengths in Å

        Raises
        ------
        ImportError
            Without trimesh

        Examples
        --------
        >>> body.to_trimesh().is_watertight                            # doctest: +SKIP
        True
        """
        import trimesh

        return trimesh.Trimesh(self.vertices_angstrom, self.triangles, process=False)

    def plot(self, ax: Axes | None = None, *, axes: str = "xy") -> Axes:
        """Draws the charges, red for negative and blue for positive, viewed along the omitted axis.

        Parameters
        ----------
        ax
            Axes of matplotlib; new ones if left out
        axes
            The two axes to see

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> body.plot(axes="xz")                                       # doctest: +SKIP
        """
        ax = new_axes(ax)
        first, second = ("xyz".index(letter) for letter in axes)
        positions, charges = self.charge_positions_angstrom, self.charges_e
        largest = float(np.abs(charges).max(initial=1e-9))
        vertices = self.vertices_angstrom
        ax.scatter(vertices[:, first], vertices[:, second], s=0.5, color="0.85")
        ax.scatter(positions[:, first], positions[:, second], c=charges, cmap="RdBu", vmin=-largest, vmax=largest, s=8)
        ax.set_aspect("equal")
        ax.set_xlabel(f"{axes[0]} (Å)")
        ax.set_ylabel(f"{axes[1]} (Å)")
        return ax

    def __repr__(self) -> str:
        return (
            f"Body({self.name!r}, {len(self.vertices_angstrom)} vertices, {len(self.charges_e)} charges, "
            f"{self.net_charge_e:+.2f} e, {self.volume_angstrom3:.0f} Å³)"
        )

    def _repr_html_(self) -> str:
        rows = {
            "charge": f"{self.net_charge_e:+.2f} e in {len(self.charges_e)} sites",
            "surface": f"{self.area_angstrom2:.0f} Å², {len(self.triangles)} triangles",
            "volume": f"{self.volume_angstrom3:.0f} Å³",
            "from": self.source,
        }
        cells = "".join(f"<tr><th style='text-align:left'>{key}</th><td>{value}</td></tr>" for key, value in rows.items())
        return f"<table><caption>Body {self.name}</caption>{cells}</table>"


def _name_of(atoms: Any) -> str:
    """The name of the file that a Universe was read from."""
    file = getattr(atoms.universe, "filename", None)
    stem = Path(file).name.removesuffix(".gz").rsplit(".", 1)[0] if isinstance(file, (str, Path)) else ""
    return stem or "universe"
