"""Rigid bodies as arrays."""

from __future__ import annotations

import os
import tempfile
import warnings
from pathlib import Path as _FilePath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _protomer
from ._verbs import ingest as _ingest
from ._result import new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Body(_protomer.Body):
    """A rigid body in its own frame: a closed surface mesh with point charges; immutable.

    Arrays are in Å and e; `vertices_angstrom` is (N, 3), `triangles` (M, 3), `charge_positions_angstrom` (S, 3),
    `charges_e` (S,).
    """

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Body:
        """Reads a body file written by `protomer.ingest` or `protomer.body`."""
        return cls(_protomer.Body._read(path))

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
        """A body of a mesh (outward counter-clockwise) and point charges.

        Raises GeometryError for a mesh that bounds no solid.
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
    def from_structure(cls, path: str | os.PathLike[str], **settings: Any) -> Body:
        """Makes a body from a structure file (PDB, mmCIF, PQR); `settings` are the keywords of `protomer.ingest`."""
        with tempfile.TemporaryDirectory() as folder:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", message="some of the inputs failed")
                files = _ingest(path, output=folder, **settings).files
            for file in files:
                if file["error"]:
                    raise _protomer.ProtomerError(file["error"])
            if len(files) != 1:
                raise _protomer.ProtomerError(f"{path}: {len(files)} structures; use protomer.ingest for several")
            return cls.read(files[0]["body"])

    @classmethod
    def from_universe(cls, atoms: Any, **settings: Any) -> Body:
        """Makes a body from the present state of an MDAnalysis Universe or AtomGroup; `settings` as in `protomer.ingest`."""
        with tempfile.TemporaryDirectory() as folder:
            path = _FilePath(folder) / "universe.pdb"
            atoms.atoms.write(str(path))
            return cls.from_structure(path, **settings)

    def to_universe(self) -> Any:
        """The charge sites as an MDAnalysis Universe with names, residues, charges and radii; positions in Å."""
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
        """The surface as a trimesh.Trimesh, Å."""
        import trimesh

        return trimesh.Trimesh(self.vertices_angstrom, self.triangles, process=False)

    def plot(self, ax: Axes | None = None, *, axes: str = "xy") -> Axes:
        """Draws the charges, red for negative and blue for positive, viewed along the omitted axis."""
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
