"""The verbs of protomer as functions. Written by the program from its table of flags; do not edit:
UPDATE_REFERENCE=1 cargo test -p protomer-cli --test documentation
"""

# ruff: noqa: E501
from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ._call import call, salts
from .results import (
    BenchResult,
    CompareResult,
    FrameworkResult,
    HardBodySweepResult,
    LatticeResult,
    LatticeSweepResult,
    PairResult,
    PhaseDiagramResult,
    PotentialResult,
    PredictResult,
    Result,
    ScatteringResult,
    SimulationResult,
    SweepResult,
    TrainResult,
    TuneResult,
    VoxelizeResult,
)

if TYPE_CHECKING:
    from distributed import Client

    from ._assembly import Assembly
    from ._body import Body

__all__ = [
    "ingest",
    "fetch",
    "surface",
    "potential",
    "shape",
    "md",
    "hpmc",
    "free_energy",
    "phase_diagram",
    "body",
    "assemble",
    "candidates",
    "compare",
    "framework",
    "inspect",
    "binding",
    "pair",
    "simulate",
    "sweep",
    "residues",
    "reweight",
    "lattice",
    "report",
    "export",
    "scattering",
    "train",
    "predict",
    "tune",
    "voxelize",
    "merge",
    "bench",
]


def ingest(
    inputs: Path | str | Sequence[Path | str],
    *,
    output: Path | str,
    name: str | float | Sequence[str | float] | None = None,
    chain: str | float | Sequence[str | float] | None = None,
    model: int | str | None = None,
    assembly: str | float | Sequence[str | float] | None = None,
    altloc: str | float | Sequence[str | float] | None = None,
    keep_ligands: bool = False,
    keep_waters: bool = False,
    keep_hydrogens: bool = False,
    keep_nucleic_acids: bool = False,
    missing: Literal["keep", "skip", "fail"] | None = None,
    ph: float | str | None = None,
    charges: Literal["force-field", "formal", "none"] | None = None,
    mutate: str | float | Sequence[str | float] | None = None,
    density: float | str | None = None,
    lattice_spacing: float | str | None = None,
    probe: float | str | None = None,
    cavities: Literal["drop", "keep"] | None = None,
    interior_radius: float | str | None = None,
    offset: float | str | None = None,
    core: Literal["native", "surface"] | None = None,
    export: str | float | Sequence[str | float] | None = None,
    stream: bool = False,
    part: str | float | Sequence[str | float] | None = None,
    time_limit: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Turn structure files (PDB, mmCIF, PQR, each also gzipped) into bodies: surface mesh, charges, hydropathy.

    Parameters
    ----------
    inputs
        Structure files, folders that contain them, or lists of them (NAME.txt, one file a line)
    output
        Folder for the bodies
    name
        Name of the body, for a single file; that of the file if omitted
    chain
        Chains, by author name; all if omitted
    model
        Model number; the first if omitted
    assembly
        Number of the biological assembly; the deposited coordinates if omitted
    altloc
        Preferred alternate location; the highest occupancy if omitted
    keep_ligands
        Keep ligands, ions and sugars
    keep_waters
        Keep waters
    keep_hydrogens
        Keep hydrogens
    keep_nucleic_acids
        Keep nucleic acids
    missing
        Treatment of residues that lack heavy atoms [default: keep]
    ph
        pH of the protonation equilibria [default: 7.4]
    charges
        Model of the charges [default: force-field]
    mutate
        Point mutations, such as A:K45E,B:N12D; side chains are replaced in place
    density
        Mesh vertices per Å² [default: 1]
    lattice_spacing
        Spacing of the lattice on which the surface is first found, Å; a coarser one is faster and may close
        or open what is narrower [default: 0.3]
    probe
        Probe radius, Å [default: 1.4]
    cavities
        Treatment of cavities; if omitted, a body drops them and `surface` keeps them
    interior_radius
        A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors are never filled,
        because other bodies may be inside [default: 10]
    offset
        Move the surface inward by this much, Å; for a body with a native core, move that core instead, by 0.5
        if omitted
    core
        Hard core of the body; native for structures and surface for PQR files if omitted
    export
        Write the mesh and the charges in these formats as well
    stream
        For very many files: outcomes and warnings go to ingest.csv and warnings.csv in the output folder
        instead of the answer, memory is bounded, and the same command continues
    part
        With --stream: only a part of the files, such as 2/8, with tables of its own [default: 1/1]
    time_limit
        With --stream: stop after this many minutes; the same command continues
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it
    PartialError
        If some of the files failed; its attribute `result` holds the answer for all

    Examples
    --------
    >>> pm.ingest("5pti.cif.gz", output="bodies")  # doctest: +SKIP
    >>> pm.ingest("5pti.cif.gz", output="bodies", name="plus", ph=7, mutate="A:D3K,A:E7K")  # doctest: +SKIP
    """
    return call(
        Result,
        ["ingest"],
        [inputs],
        {
            "--output": output,
            "--name": name,
            "--chain": chain,
            "--model": model,
            "--assembly": assembly,
            "--altloc": altloc,
            "--keep-ligands": keep_ligands,
            "--keep-waters": keep_waters,
            "--keep-hydrogens": keep_hydrogens,
            "--keep-nucleic-acids": keep_nucleic_acids,
            "--missing": missing,
            "--ph": ph,
            "--charges": charges,
            "--mutate": mutate,
            "--density": density,
            "--lattice-spacing": lattice_spacing,
            "--probe": probe,
            "--cavities": cavities,
            "--interior-radius": interior_radius,
            "--offset": offset,
            "--core": core,
            "--export": export,
            "--stream": stream,
            "--part": part,
            "--time-limit": time_limit,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def fetch(
    entries: str | float | Sequence[str | float],
    *,
    output: Path | str | None = None,
    base: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Download entries (mmCIF, gzipped) from the RCSB Protein Data Bank. Nothing else in protomer uses the
    network.

    Parameters
    ----------
    entries
        Entries, such as 6MDR
    output
        Folder for the files [default: .]
    base
        Base address of the server; ENTRY.cif.gz is added [default: https://files.rcsb.org/download]
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.fetch("6MDR", output="structures")  # doctest: +SKIP
    >>> pm.fetch(["5PTI", "1BRS"])  # doctest: +SKIP
    """
    return call(
        Result,
        ["fetch"],
        [entries],
        {
            "--output": output,
            "--base": base,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def surface(
    input: Path | str | Body,
    *,
    output: Path | str | None = None,
    density: float | str | None = None,
    lattice_spacing: float | str | None = None,
    probe: float | str | None = None,
    cavities: Literal["drop", "keep"] | None = None,
    interior_radius: float | str | None = None,
    offset: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Compute the solvent-excluded surface of a structure, a PQR, a body, or an .xyzr file (x y z radius per
    line): mesh, exact area and volume. Cavities are kept by default.

    Parameters
    ----------
    input
        Structure, PQR, body or .xyzr file, optionally gzipped
    output
        Mesh file to write: .ply, .obj, .off or .stl
    density
        Mesh vertices per Å² [default: 1]
    lattice_spacing
        Spacing of the lattice on which the surface is first found, Å; a coarser one is faster and may close
        or open what is narrower [default: 0.3]
    probe
        Probe radius, Å [default: 1.4]
    cavities
        Treatment of cavities; if omitted, a body drops them and `surface` keeps them
    interior_radius
        A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors are never filled,
        because other bodies may be inside [default: 10]
    offset
        Move the surface inward by this much, Å; for a body with a native core, move that core instead, by 0.5
        if omitted
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.surface("5pti.cif.gz", output="bpti.ply")  # doctest: +SKIP
    >>> pm.surface("spheres.xyzr", probe=1.4, density=4)  # doctest: +SKIP
    """
    return call(
        Result,
        ["surface"],
        [input],
        {
            "--output": output,
            "--density": density,
            "--lattice-spacing": lattice_spacing,
            "--probe": probe,
            "--cavities": cavities,
            "--interior-radius": interior_radius,
            "--offset": offset,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def potential(
    input: Path | str | Body,
    *,
    salt: str | None = None,
    salt_molar: float | None = None,
    model: Literal["poisson-boltzmann", "debye-hueckel"] | None = None,
    spacing: float | str | None = None,
    margin: float | str | None = None,
    boundary: Literal["screened-atoms", "coarse-grid"] | None = None,
    temperature: float | str | None = None,
    inner_permittivity: float | str | None = None,
    outer_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    surface: Literal["solvent-excluded", "van-der-waals", "solvent-accessible"] | None = None,
    probe: float | str | None = None,
    points: Path | str | None = None,
    no_error_estimate: bool = False,
    output: Path | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> PotentialResult:
    """Solve the linearised Poisson-Boltzmann equation around a structure, PQR or body: potential in kT/e and
    solvation energy.

    Parameters
    ----------
    input
        Structure, PQR or body file, optionally gzipped
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M
    salt_molar
        The same as a number in mol/L, instead of `salt`
    model
        Model of the potential [default: poisson-boltzmann]
    spacing
        Grid spacing, Å [default: 0.5]
    margin
        Minimum distance between the atoms and the faces of the grid, Å [default: 10]
    boundary
        Potential on the faces of the grid [default: screened-atoms]
    temperature
        Temperature, K [default: 298.15]
    inner_permittivity
        Relative permittivity inside the surface [default: 2]
    outer_permittivity
        Relative permittivity of the solvent; that of water at the temperature if omitted
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    surface
        The dielectric boundary [default: solvent-excluded]
    probe
        Probe radius of the surface, Å [default: 1.4]
    points
        File of points (x y z per line, Å) at which to print the potential
    no_error_estimate
        Omit the second solution, which estimates the error of the energy
    output
        Volume file to write: .mrc for programs of electron microscopy, .ccp4 or .map for programs of
        crystallography (gemmi, Coot), .dx (OpenDX) or .npz (NumPy). ChimeraX and PyMOL open both kinds of map
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    PotentialResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.potential("5pti.cif.gz", salt="100mM", output="bpti.mrc")  # doctest: +SKIP
    >>> pm.potential("a.body", salt="0.15M", points="points.txt")  # doctest: +SKIP
    """
    return call(
        PotentialResult,
        ["potential"],
        [input],
        {
            "--salt": salts("potential", salt, salt_molar, required=True),
            "--model": model,
            "--spacing": spacing,
            "--margin": margin,
            "--boundary": boundary,
            "--temperature": temperature,
            "--inner-permittivity": inner_permittivity,
            "--outer-permittivity": outer_permittivity,
            "--ion-radius": ion_radius,
            "--surface": surface,
            "--probe": probe,
            "--points": points,
            "--no-error-estimate": no_error_estimate,
            "--output": output,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


class _Shape:
    """Measure a convex shape, rounded or not: volume, surface, integrated mean curvature and second virial
    coefficient, exactly. The shape is that of a file: the corners of a convex polygon (text with two
    columns), the convex hull of points in space (three columns), or a convex .off, .obj, .ply or .stl mesh;
    concave ones are refused. One point with a rounding is a disk or a ball. Or it has a name: tetrahedron,
    cube, octahedron, dodecahedron, icosahedron, truncated-octahedron, rhombic-dodecahedron (edges of length
    1), truncated-tetrahedron:T (T from 0, the tetrahedron with edges of length 1, to 1, the octahedron; 2/3
    is Archimedean), cuboid:A,B,C, prism:N,HEIGHT (edges of length 1), polygon:N (area 1), ellipse:A,B and
    ellipsoid:A,B,C (half axes).
    """

    def __call__(
        self,
        shape: str | float | Sequence[str | float] | None = None,
        *,
        rounding: float | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Measure a convex shape, rounded or not: volume, surface, integrated mean curvature and second virial
        coefficient, exactly. The shape is that of a file: the corners of a convex polygon (text with two
        columns), the convex hull of points in space (three columns), or a convex .off, .obj, .ply or .stl
        mesh; concave ones are refused. One point with a rounding is a disk or a ball. Or it has a name:
        tetrahedron, cube, octahedron, dodecahedron, icosahedron, truncated-octahedron, rhombic-dodecahedron
        (edges of length 1), truncated-tetrahedron:T (T from 0, the tetrahedron with edges of length 1, to 1,
        the octahedron; 2/3 is Archimedean), cuboid:A,B,C, prism:N,HEIGHT (edges of length 1), polygon:N (area
        1), ellipse:A,B and ellipsoid:A,B,C (half axes).

        Parameters
        ----------
        shape
            File with points, or the name of a shape
        rounding
            Radius of the ball, or disk, that rounds it (Minkowski sum) [default: 0]
        output
            Mesh file to write, without the rounding: .ply, .obj, .off or .stl
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.shape("cube", rounding=0.1)  # doctest: +SKIP
        >>> pm.shape("corners.txt", output="hull.ply")  # doctest: +SKIP
        """
        return call(
            Result,
            ["shape"],
            [shape],
            {
                "--rounding": rounding,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def contact(
        self,
        pairs: Path | str,
        *,
        potential: Literal["contact", "face-sum", "smooth"] | None = None,
        central: Literal["none", "conservative", "printed", "gradient"] | None = None,
        attraction: float | str | None = None,
        attraction_cut_off: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Print the repulsion of pairs of convex shapes: energy, force and torques of each pair. PAIRS is a JSON
        list of objects: `a` and `b` (file or name of a shape, as for `shape`), `position` (of the centroid of
        b; that of a is at the origin), `orientation_a` and `orientation_b` (an angle in radians for polygons,
        a quaternion w x y z for polyhedra; left out: not turned). The repulsion has the length 0.15 sigma,
        where sigma is the mean diameter of the balls about the centroids that fit in, and the energy 1 at
        that distance; energies are in units of epsilon.

        Parameters
        ----------
        pairs
            JSON file with the pairs
        potential
            Points of the bodies that repel each other [default: smooth]
        central
            Energy between the centroids, added to that of the points [default: none]
        attraction
            Strength of the attraction: 0 for the repulsion alone, 1 for Lennard-Jones [default: 0]
        attraction_cut_off
            Cut-off of the attraction, in units of its length; inf for none. It is switched off smoothly from
            0.8 of that on [default: 2.5]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["shape", "contact"],
            [pairs],
            {
                "--potential": potential,
                "--central": central,
                "--attraction": attraction,
                "--attraction-cut-off": attraction_cut_off,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def overlap_volume(
        self,
        pairs: Path | str,
        *,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Print the volume that two convex shapes, swept by a depletant, have in common, for each pair. PAIRS is
        a JSON list of objects: `a` and `b` (file or name of a shape, as for `shape`), `position` (of the
        centroid of b; that of a is at the origin), `orientation_a` and `orientation_b` (an angle in radians
        for polygons, a quaternion w x y z for polyhedra; left out: not turned), `depletant_radius`, and
        `rounding_a` and `rounding_b` (radius of the ball that rounds each shape). Penetrable depletants of
        number density n in the reservoir give the pair the energy -n kT times this volume.

        Parameters
        ----------
        pairs
            JSON file with the pairs
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["shape", "overlap-volume"],
            [pairs],
            {
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def virial(
        self,
        first: str | float | Sequence[str | float],
        second: str | float | Sequence[str | float] | None = None,
        *,
        rounding: float | str | None = None,
        second_rounding: float | str | None = None,
        triples: int | str | None = None,
        depletants: str | float | Sequence[str | float] | None = None,
        rays: int | str | None = None,
        seed: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Print virial coefficients of hard bodies: the second one of a shape, or of two different shapes,
        exactly; and if asked for, the third one, and the second one among depletants. Shapes are those of
        `shape`. A concave body is given by its convex pieces, joined by + as for `hpmc`; its coefficients are
        sampled with --triples.

        Parameters
        ----------
        first
            File or name of a shape
        second
            File or name of another shape, for B12; two bodies of the first if omitted
        rounding
            Radius of the ball, or disk, that rounds the first shape, or both if there is one [default: 0]
        second_rounding
            Radius of the ball, or disk, that rounds the second shape [default: 0]
        triples
            Sample the third virial coefficient by this many triples of bodies, such as 100000 [default: 0]
        depletants
            Penetrable hard spheres, or disks: radius and number density in the reservoir, such as 0.1:20;
            several with commas between them
        rays
            Rays along which the coefficient among depletants is integrated [default: 300]
        seed
            Seed of the random numbers [default: 1]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.shape.virial("cube", "tetrahedron")  # doctest: +SKIP
        >>> pm.shape.virial("cube", triples=100000, depletants="0.1:5")  # doctest: +SKIP
        """
        return call(
            Result,
            ["shape", "virial"],
            [first, second],
            {
                "--rounding": rounding,
                "--second-rounding": second_rounding,
                "--triples": triples,
                "--depletants": depletants,
                "--rays": rays,
                "--seed": seed,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def free_volume(
        self,
        shape: str | float | Sequence[str | float],
        *,
        packing_fraction: float | str | Sequence[float | str] | NDArray[np.float64],
        depletant_radius: float | str | Sequence[float | str] | NDArray[np.float64],
        rounding: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Print the part of space that is open to depletants in a fluid of hard convex bodies, by scaled
        particle theory. The theory is exact for points and to first order in the density, and an
        approximation for dense fluids. For crystals, see `hpmc free-volume`.

        Parameters
        ----------
        shape
            File or name of a shape in space, as for `shape`
        packing_fraction
            The part of space that the bodies fill; several with commas between them
        depletant_radius
            Radius of the depletants; several with commas between them
        rounding
            Radius of the ball that rounds it (Minkowski sum) [default: 0]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.shape.free_volume("cube", packing_fraction=0.3, depletant_radius=0.1)  # doctest: +SKIP
        >>> pm.shape.free_volume("ellipsoid:1,1,3", packing_fraction="0.1,0.2", depletant_radius=0.05)  # doctest: +SKIP
        """
        return call(
            Result,
            ["shape", "free-volume"],
            [shape],
            {
                "--packing-fraction": packing_fraction,
                "--depletant-radius": depletant_radius,
                "--rounding": rounding,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )


shape = _Shape()


class _Md:
    """Contact dynamics: convex bodies in motion, in two and three dimensions."""

    def run(
        self,
        config: Path | str | None = None,
        *,
        output: Path | str,
        shape: str | float | Sequence[str | float] | None = None,
        share: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        rounding: float | str | None = None,
        keep_size: bool = False,
        bodies: int | str | None = None,
        packing_fraction: float | str | None = None,
        potential: Literal["contact", "face-sum", "smooth"] | None = None,
        attraction: float | str | None = None,
        attraction_cut_off: float | str | None = None,
        central: Literal["none", "conservative"] | None = None,
        time_step: float | str | None = None,
        steps: int | str | None = None,
        ensemble: Literal["nve", "nvt", "npt", "langevin", "brownian"] | None = None,
        temperature: float | str | None = None,
        pressure: float | str | None = None,
        relaxation_time: float | str | None = None,
        friction: float | str | None = None,
        seed: int | str | None = None,
        compress_from: float | str | None = None,
        compress_steps: int | str | None = None,
        equilibrate_steps: int | str | None = None,
        preparation_time_step: float | str | None = None,
        log_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Follow convex bodies in motion, from a wide lattice through a slow compression. The same command
        continues a run. Bodies repel each other between the points that --potential names (energy epsilon at
        the distance sigma_c = 0.15 sigma; sigma is the mean diameter of the balls about the centroids that
        fit in). Units: epsilon, the length that gives a body area or volume one, density one. The packing
        fraction counts bodies with a layer of sigma_c/2.

        Parameters
        ----------
        config
            Configuration (TOML), such as the run.toml of another run; flags override it
        output
            Directory of the results
        shape
            File or name of the shape, as for `shape`; also disk, ball, ellipse:A,B or ellipsoid:A,B,C; convex
            parts of a concave body joined by +. Several times for a mixture [default: polygon:4]
        share
            Relative number of bodies of each shape: once for each --shape [default: equal numbers]
        rounding
            Radius by which the shapes are rounded, in the unit of their points, before they are scaled
            [default: 0]
        keep_size
            Keep the size of the shape instead of scaling it to area or volume one
        bodies
            Number of bodies [default: 1000]
        packing_fraction
            Part of the space that bodies with their layer fill [default: 0.5]
        potential
            Points of the bodies that repel each other [default: smooth]
        attraction
            Strength of the attraction: 0 for the repulsion alone, 1 for Lennard-Jones [default: 0]
        attraction_cut_off
            Cut-off of the attraction, in units of sigma_c (of sigma for the central term); it is switched off
            smoothly from 0.8 of that on [default: 2.5]
        central
            Energy between the centroids [default: none]
        time_step
            Time step [default: 0.0001]
        steps
            Run to this many steps after the preparation [default: 10000]
        ensemble
            Bath that keeps the temperature, and the pressure [default: nve]
        temperature
            kT at the start and of the bath, in units of epsilon [default: 1]
        pressure
            Pressure of npt, in units of epsilon per area or volume
        relaxation_time
            Relaxation time of the bath of nvt and npt [default: 0.5]
        friction
            Friction of langevin and brownian, an inverse time [default: 1]
        seed
            Seed of the random numbers [default: 1]
        compress_from
            Packing fraction of the lattice at the start [default: the densest without forces]
        compress_steps
            Steps of the compression [default: 10000]
        equilibrate_steps
            Steps with a bath after the compression [default: 8000]
        preparation_time_step
            Time step of compression and equilibration [default: 0.0005]
        log_every
            Steps between rows of the log [default: 100]
        trajectory_every
            Steps between frames of the trajectory; 0 for none [default: 1000]
        time_limit
            Stop (resumably, exit code 3) after this many minutes
        checkpoint_every
            Seconds between checkpoints: the most that a killed run loses [default: 20]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        StoppedError
            If the time was over before the end; the same call continues it

        Examples
        --------
        >>> pm.md.run(shape="polygon:4", packing_fraction=0.6, output="squares")  # doctest: +SKIP
        >>> pm.md.run(shape="octahedron", bodies=500, potential="smooth", ensemble="nvt", output="fluid")  # doctest: +SKIP
        """
        return call(
            Result,
            ["md", "run"],
            [config],
            {
                "--output": output,
                "--shape": shape,
                "--share": share,
                "--rounding": rounding,
                "--keep-size": keep_size,
                "--bodies": bodies,
                "--packing-fraction": packing_fraction,
                "--potential": potential,
                "--attraction": attraction,
                "--attraction-cut-off": attraction_cut_off,
                "--central": central,
                "--time-step": time_step,
                "--steps": steps,
                "--ensemble": ensemble,
                "--temperature": temperature,
                "--pressure": pressure,
                "--relaxation-time": relaxation_time,
                "--friction": friction,
                "--seed": seed,
                "--compress-from": compress_from,
                "--compress-steps": compress_steps,
                "--equilibrate-steps": equilibrate_steps,
                "--preparation-time-step": preparation_time_step,
                "--log-every": log_every,
                "--trajectory-every": trajectory_every,
                "--time-limit": time_limit,
                "--checkpoint-every": checkpoint_every,
                "--threads": threads,
                "--force": force,
            },
            progress,
            repeated=["--shape", "--share"],
        )


md = _Md()


class _Hpmc:
    """Hard convex bodies in a periodic box, with penetrable depletants."""

    def run(
        self,
        *,
        shape: str | float | Sequence[str | float],
        packing_fraction: float | str,
        output: Path | str,
        rounding: float | str | None = None,
        bodies: int | str | None = None,
        start: str | float | Sequence[str | float] | None = None,
        turn: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        gravity: float | str | None = None,
        depletants: str | float | Sequence[str | float] | None = None,
        equilibration: int | str | None = None,
        sweeps: int | str | None = None,
        sample_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        insertions: int | str | None = None,
        points: int | str | None = None,
        pressure: float | str | None = None,
        anisotropic: bool = False,
        triclinic: bool = False,
        box_moves: int | str | None = None,
        seed: int | str | None = None,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Run hard bodies in a periodic box. The same command continues the run; more sweeps extend it. Bodies
        are placed at random and compressed to the packing fraction, or stand on the sites of a crystal. In
        the equilibration the steps are tuned; then the pressure is measured by trial compressions, the free
        volume of the depletants by random points, and the chemical potential by insertion.

        Parameters
        ----------
        shape
            File with points, or the name of a shape, as for `shape`; rod:LENGTH for rods on a line. Several
            joined by + are the convex pieces of one body
        packing_fraction
            The part of the box that the bodies fill
        output
            Directory of the results
        rounding
            Radius of the ball, or disk, that rounds it (Minkowski sum) [default: 0]
        bodies
            Number of bodies [default: 216]
        start
            Initial arrangement of the bodies: fluid, the name of a crystal (simple-cubic, fcc, bcc, hcp,
            diamond, hexagonal-diamond; square, hexagonal; row), or the file of a unit cell [default: fluid]
        turn
            Turn every body of a crystal first: degrees in a plane, a quaternion W,X,Y,Z in space
        box
            Edges of the box of a fluid relative to each other, such as 1,1,4 [default: equal]
        gravity
            Weight of a body, kT per length (the inverse of the gravitational length), between hard walls at
            both ends of the last axis
        depletants
            Penetrable hard spheres, or disks, in equilibrium with a reservoir: radius and number density in
            the reservoir, several with commas between them. With density 0 only free volumes are measured
        equilibration
            Sweeps in which the steps are tuned and nothing is measured [default: 2000]
        sweeps
            Sweeps after the equilibration; a sweep is one trial move per body [default: 10000]
        sample_every
            Sweeps between measurements [default: 5]
        trajectory_every
            Sweeps between frames of the trajectory; 0 for none [default: 500]
        insertions
            Bodies inserted at random per measurement, for the chemical potential [default: 0]
        points
            Points per measurement, for free volumes [default: ten per body]
        pressure
            Constant pressure, kT per volume, at which the box changes; the packing fraction is that of the
            start
        anisotropic
            At constant pressure, change each edge of the box on its own; for crystals
        triclinic
            At constant pressure, change the lengths and the angles of the box; for crystals
        box_moves
            At constant pressure, trial changes of the box in a sweep [default: 4; 8 if triclinic]
        seed
            Seed of the random numbers [default: 1]
        time_limit
            Stop (resumably, exit code 3) after this many minutes
        checkpoint_every
            Seconds between checkpoints: the most that a killed run loses [default: 20]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        StoppedError
            If the time was over before the end; the same call continues it

        Examples
        --------
        >>> pm.hpmc.run(shape="cube", packing_fraction=0.3, output="cubes")  # doctest: +SKIP
        >>> pm.hpmc.run(shape="cube", packing_fraction=0.3, depletants="0.1:20", output="depleted")  # doctest: +SKIP
        """
        return call(
            Result,
            ["hpmc", "run"],
            [],
            {
                "--shape": shape,
                "--packing-fraction": packing_fraction,
                "--output": output,
                "--rounding": rounding,
                "--bodies": bodies,
                "--start": start,
                "--turn": turn,
                "--box": box,
                "--gravity": gravity,
                "--depletants": depletants,
                "--equilibration": equilibration,
                "--sweeps": sweeps,
                "--sample-every": sample_every,
                "--trajectory-every": trajectory_every,
                "--insertions": insertions,
                "--points": points,
                "--pressure": pressure,
                "--anisotropic": anisotropic,
                "--triclinic": triclinic,
                "--box-moves": box_moves,
                "--seed": seed,
                "--time-limit": time_limit,
                "--checkpoint-every": checkpoint_every,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def sweep(
        self,
        *,
        shape: str | float | Sequence[str | float],
        output: Path | str,
        rounding: float | str | None = None,
        bodies: int | str | None = None,
        start: str | float | Sequence[str | float] | None = None,
        turn: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        gravity: float | str | None = None,
        depletants: str | float | Sequence[str | float] | None = None,
        equilibration: int | str | None = None,
        sweeps: int | str | None = None,
        sample_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        insertions: int | str | None = None,
        points: int | str | None = None,
        packing_fractions: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        pressures: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        packing_fraction: float | str | None = None,
        anisotropic: bool = False,
        triclinic: bool = False,
        box_moves: int | str | None = None,
        seeds: int | str | None = None,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> HardBodySweepResult:
        """Run hard bodies at several packing fractions or pressures, once per seed, on all threads: the equation
        of state as a table and a figure. The same command continues a sweep; more sweeps, packing fractions,
        pressures and seeds extend it. Over packing fractions of a fluid, the excess free energy is integrated
        from no bodies.

        Parameters
        ----------
        shape
            File with points, or the name of a shape, as for `shape`; rod:LENGTH for rods on a line. Several
            joined by + are the convex pieces of one body
        output
            Directory of the results
        rounding
            Radius of the ball, or disk, that rounds it (Minkowski sum) [default: 0]
        bodies
            Number of bodies [default: 216]
        start
            Initial arrangement of the bodies: fluid, the name of a crystal (simple-cubic, fcc, bcc, hcp,
            diamond, hexagonal-diamond; square, hexagonal; row), or the file of a unit cell [default: fluid]
        turn
            Turn every body of a crystal first: degrees in a plane, a quaternion W,X,Y,Z in space
        box
            Edges of the box of a fluid relative to each other, such as 1,1,4 [default: equal]
        gravity
            Weight of a body, kT per length (the inverse of the gravitational length), between hard walls at
            both ends of the last axis
        depletants
            Penetrable hard spheres, or disks, in equilibrium with a reservoir: radius and number density in
            the reservoir, several with commas between them. With density 0 only free volumes are measured
        equilibration
            Sweeps in which the steps are tuned and nothing is measured [default: 2000]
        sweeps
            Sweeps after the equilibration; a sweep is one trial move per body [default: 10000]
        sample_every
            Sweeps between measurements [default: 5]
        trajectory_every
            Sweeps between frames of the trajectory; 0 for none [default: 500]
        insertions
            Bodies inserted at random per measurement, for the chemical potential [default: 0]
        points
            Points per measurement, for free volumes [default: ten per body]
        packing_fractions
            Packing fractions, with commas between them
        pressures
            Constant pressures, kT per volume, with commas between them
        packing_fraction
            With --pressures, the packing fraction of the start
        anisotropic
            With --pressures, change each edge of the box on its own; for crystals
        triclinic
            With --pressures, change the lengths and the angles of the box; for crystals
        box_moves
            At constant pressure, trial changes of the box in a sweep [default: 4; 8 if triclinic]
        seeds
            Runs at each condition: seeds 1, 2, ... [default: 1]
        time_limit
            Stop (resumably, exit code 3) after this many minutes
        checkpoint_every
            Seconds between checkpoints: the most that a killed run loses [default: 20]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        HardBodySweepResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        StoppedError
            If the time was over before the end; the same call continues it
        """
        return call(
            HardBodySweepResult,
            ["hpmc", "sweep"],
            [],
            {
                "--shape": shape,
                "--output": output,
                "--rounding": rounding,
                "--bodies": bodies,
                "--start": start,
                "--turn": turn,
                "--box": box,
                "--gravity": gravity,
                "--depletants": depletants,
                "--equilibration": equilibration,
                "--sweeps": sweeps,
                "--sample-every": sample_every,
                "--trajectory-every": trajectory_every,
                "--insertions": insertions,
                "--points": points,
                "--packing-fractions": packing_fractions,
                "--pressures": pressures,
                "--packing-fraction": packing_fraction,
                "--anisotropic": anisotropic,
                "--triclinic": triclinic,
                "--box-moves": box_moves,
                "--seeds": seeds,
                "--time-limit": time_limit,
                "--checkpoint-every": checkpoint_every,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def free_volume(
        self,
        *,
        shape: str | float | Sequence[str | float],
        crystal: str | float | Sequence[str | float],
        packing_fraction: float | str | Sequence[float | str] | NDArray[np.float64],
        depletant_radius: float | str | Sequence[float | str] | NDArray[np.float64],
        rounding: float | str | None = None,
        turn: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        lines: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Print the free volume of depletants in a perfect crystal whose bodies do not move. Lines through the
        unit cell are cut exactly by the bodies, each swept by a depletant; the error is that of grids of
        lines that are shifted against each other. For crystals that move, give `run` a start and depletants.

        Parameters
        ----------
        shape
            File with points, or the name of a shape, as for `shape`
        crystal
            Name of the crystal (simple-cubic, fcc, bcc, hcp, diamond, hexagonal-diamond), or the file of its
            unit cell
        packing_fraction
            The part of space that the bodies fill; several with commas between them
        depletant_radius
            Radius of the depletants; several with commas between them
        rounding
            Radius of the ball that rounds it (Minkowski sum) [default: 0]
        turn
            Turn every body first: a quaternion W,X,Y,Z
        lines
            Lines along the shortest edge of the unit cell [default: 100]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["hpmc", "free-volume"],
            [],
            {
                "--shape": shape,
                "--crystal": crystal,
                "--packing-fraction": packing_fraction,
                "--depletant-radius": depletant_radius,
                "--rounding": rounding,
                "--turn": turn,
                "--lines": lines,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )


hpmc = _Hpmc()


def free_energy(
    *,
    shape: str | float | Sequence[str | float],
    crystal: str | float | Sequence[str | float],
    packing_fraction: float | str,
    output: Path | str,
    rounding: float | str | None = None,
    turn: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    bodies: int | str | None = None,
    equilibration: int | str | None = None,
    sweeps: int | str | None = None,
    seed: int | str | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Compute the free energy of a crystal of hard bodies. The same command continues the run; more sweeps
    extend it. Springs hold the bodies and their orientations to the sites. With the strongest springs the
    free energy is exact; the difference to none is integrated over 21 strengths, and sweeps go to those whose
    errors count most (Frenkel and Ladd). The free energy is A/(N kT) at this number of bodies, for a thermal
    wavelength of one in the unit of the shape and an integral of one over all orientations. The excess is
    what it is more than that of an ideal gas of the same density, ln ρ - 1.

    Parameters
    ----------
    shape
        File with points, or the name of a shape, as for `shape`; rod:LENGTH for rods on a line. Several
        joined by + are the convex pieces of one body
    crystal
        Name of the crystal (simple-cubic, fcc, bcc, hcp, diamond, hexagonal-diamond; square, hexagonal; row),
        or the file of its unit cell
    packing_fraction
        The part of the box that the bodies fill
    output
        Directory of the results
    rounding
        Radius of the ball, or disk, that rounds it (Minkowski sum) [default: 0]
    turn
        Turn every body first: degrees in a plane, a quaternion W,X,Y,Z in space
    bodies
        Number of bodies [default: 216]
    equilibration
        Sweeps at each strength in which steps are tuned and nothing is measured [default: 2000]
    sweeps
        Sweeps after the equilibration, per strength on average [default: 20000]
    seed
        Seed of the random numbers [default: 1]
    time_limit
        Stop (resumably, exit code 3) after this many minutes
    checkpoint_every
        Seconds between checkpoints: the most that a killed run loses [default: 20]
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it

    Examples
    --------
    >>> pm.free_energy(shape="cube", crystal="simple-cubic", bodies=64, packing_fraction=0.6, output="cubes")  # doctest: +SKIP
    >>> pm.free_energy(shape="rod:1", crystal="row", bodies=32, packing_fraction=0.5, output="rods")  # doctest: +SKIP
    """
    return call(
        Result,
        ["free-energy"],
        [],
        {
            "--shape": shape,
            "--crystal": crystal,
            "--packing-fraction": packing_fraction,
            "--output": output,
            "--rounding": rounding,
            "--turn": turn,
            "--bodies": bodies,
            "--equilibration": equilibration,
            "--sweeps": sweeps,
            "--seed": seed,
            "--time-limit": time_limit,
            "--checkpoint-every": checkpoint_every,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def phase_diagram(
    *,
    size_ratio: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    reservoir: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    fluid: Path | str | None = None,
    crystal: Path | str | Sequence[Path | str] | None = None,
    free_energy: Path | str | Sequence[Path | str] | None = None,
    branch: Path | str | Sequence[Path | str] | None = None,
    output: Path | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> PhaseDiagramResult:
    """Print the phases that coexist: their packing fractions, pressure and chemical potential. With
    `--size-ratio` and `--reservoir`, hard spheres among penetrable depletants by free volume theory: the
    fluid of Carnahan and Starling, the cell model of the crystal, free volumes of scaled particle theory.
    With `--fluid`, `--crystal` and `--free-energy`, any bodies, by what `hpmc sweep` and `free-energy`
    measured, with errors; with `--reservoir` among the depletants whose free volumes were measured. With
    `--branch`, tables of free energies: two columns, a packing fraction (or density) and the free energy per
    volume, one file per phase. Pressures are in units of kT over the volume of a body, chemical potentials in
    kT; with tables both are in the units of the tables.

    Parameters
    ----------
    size_ratio
        Radius of the depletants over that of the spheres; several with commas between them
    reservoir
        Packing fraction of the depletants in the reservoir; several with commas between them
    fluid
        Directory of the `hpmc sweep` of a fluid over packing fractions
    crystal
        Directory of the `hpmc sweep` of a crystal; once per crystal, each with its --free-energy
    free_energy
        Directory of the `free-energy` of a crystal, in the order of the crystals
    branch
        Table of the free energy of a phase; once per phase
    output
        Figure to write, .svg or .png: packing fractions against the reservoir, with tie lines, critical and
        triple points; one size ratio per figure
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    PhaseDiagramResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.phase_diagram(size_ratio=0.5, reservoir="0.4,0.5,0.6")  # doctest: +SKIP
    >>> pm.phase_diagram(branch=["fluid.txt", "solid.txt"])  # doctest: +SKIP
    """
    return call(
        PhaseDiagramResult,
        ["phase-diagram"],
        [],
        {
            "--size-ratio": size_ratio,
            "--reservoir": reservoir,
            "--fluid": fluid,
            "--crystal": crystal,
            "--free-energy": free_energy,
            "--branch": branch,
            "--output": output,
            "--threads": threads,
            "--force": force,
        },
        progress,
        repeated=["--crystal", "--free-energy", "--branch"],
    )


def body(
    *,
    mesh: Path | str,
    output: Path | str,
    charges: Path | str | None = None,
    name: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Make a body from a mesh (PLY, OFF, OBJ, STL) and charges (PQR, or whitespace-separated x y z charge).
    Coordinates are kept: the body's origin is that of the files.

    Parameters
    ----------
    mesh
        Closed, outward mesh, Å
    output
        Body file to write
    charges
        Charges; if omitted, the body is hard and neutral
    name
        Name of the body; that of the output file if omitted
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.body(mesh="patchy.ply", charges="patchy.xyzq", output="patchy.body")  # doctest: +SKIP
    >>> pm.body(mesh="cube.off", output="cube.body")  # doctest: +SKIP
    """
    return call(
        Result,
        ["body"],
        [],
        {
            "--mesh": mesh,
            "--output": output,
            "--charges": charges,
            "--name": name,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


class _Assemble:
    """Build assemblies: from the chains of a structure, as a ring or a stack of two rings, or at random."""

    def structure(
        self,
        inputs: Path | str | Sequence[Path | str],
        *,
        output: Path | str,
        chain: str | float | Sequence[str | float] | None = None,
        model: int | str | None = None,
        assembly: str | float | Sequence[str | float] | None = None,
        altloc: str | float | Sequence[str | float] | None = None,
        keep_ligands: bool = False,
        keep_waters: bool = False,
        keep_hydrogens: bool = False,
        keep_nucleic_acids: bool = False,
        missing: Literal["keep", "skip", "fail"] | None = None,
        ph: float | str | None = None,
        charges: Literal["force-field", "formal", "none"] | None = None,
        mutate: str | float | Sequence[str | float] | None = None,
        density: float | str | None = None,
        lattice_spacing: float | str | None = None,
        probe: float | str | None = None,
        cavities: Literal["drop", "keep"] | None = None,
        interior_radius: float | str | None = None,
        offset: float | str | None = None,
        core: Literal["native", "surface"] | None = None,
        body: str | float | Sequence[str | float] | None = None,
        shapes: Literal["fitting", "shared"] | None = None,
        relax: bool = False,
        box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Decompose a structure: each chain becomes a body, or each of several files in one frame; identical
        ones become one body, and each copy a pose.

        Parameters
        ----------
        inputs
            Structure file, or several in one frame, such as a receptor and its ligand
        output
            Folder for the bodies and assembly.json
        chain
            Chains, by author name; all if omitted
        model
            Model number; the first if omitted
        assembly
            Number of the biological assembly; the deposited coordinates if omitted
        altloc
            Preferred alternate location; the highest occupancy if omitted
        keep_ligands
            Keep ligands, ions and sugars
        keep_waters
            Keep waters
        keep_hydrogens
            Keep hydrogens
        keep_nucleic_acids
            Keep nucleic acids
        missing
            Treatment of residues that lack heavy atoms [default: keep]
        ph
            pH of the protonation equilibria [default: 7.4]
        charges
            Model of the charges [default: force-field]
        mutate
            Point mutations, such as A:K45E,B:N12D; side chains are replaced in place
        density
            Mesh vertices per Å² [default: 1]
        lattice_spacing
            Spacing of the lattice on which the surface is first found, Å; a coarser one is faster and may
            close or open what is narrower [default: 0.3]
        probe
            Probe radius, Å [default: 1.4]
        cavities
            Treatment of cavities; if omitted, a body drops them and `surface` keeps them
        interior_radius
            A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors are never
            filled, because other bodies may be inside [default: 10]
        offset
            Move the surface inward by this much, Å; for a body with a native core, move that core instead, by
            0.5 if omitted
        core
            Hard core of the body; native for structures and surface for PQR files if omitted
        body
            Chains that make up one body, such as H,L; once for each body
        shapes
            The shapes of copies [default: fitting]
        relax
            Remove overlaps by the least displacements and rotations of the bodies
        box
            Edge of a cubic periodic box, or three edges, Å; open space if omitted
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.assemble.structure(["receptor.pdb", "ligand.pdb"], box=300, output="complex")  # doctest: +SKIP
        >>> pm.assemble.structure("6mdr.cif.gz", assembly=1, box=400, output="stack")  # doctest: +SKIP
        """
        return call(
            Result,
            ["assemble", "structure"],
            [inputs],
            {
                "--output": output,
                "--chain": chain,
                "--model": model,
                "--assembly": assembly,
                "--altloc": altloc,
                "--keep-ligands": keep_ligands,
                "--keep-waters": keep_waters,
                "--keep-hydrogens": keep_hydrogens,
                "--keep-nucleic-acids": keep_nucleic_acids,
                "--missing": missing,
                "--ph": ph,
                "--charges": charges,
                "--mutate": mutate,
                "--density": density,
                "--lattice-spacing": lattice_spacing,
                "--probe": probe,
                "--cavities": cavities,
                "--interior-radius": interior_radius,
                "--offset": offset,
                "--core": core,
                "--body": body,
                "--shapes": shapes,
                "--relax": relax,
                "--box": box,
                "--threads": threads,
                "--force": force,
            },
            progress,
            repeated=["--body"],
        )

    def ring(
        self,
        bodies: Path | str | Body | Sequence[Path | str | Body],
        *,
        members: int | str,
        output: Path | str,
        stack: int | str | None = None,
        directions: str | float | Sequence[str | float] | None = None,
        tilt: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        spin: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        gap: float | str | None = None,
        box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """A ring of bodies, or a stack of two rings, closed to contact. Bodies alternate around the ring.

        Parameters
        ----------
        bodies
            Body files, in the order in which they alternate
        members
            Bodies per ring
        output
            Assembly file to write
        stack
            Number of rings: one, or two stacked with dihedral symmetry [default: 1]
        directions
            Direction of each body of the pattern: u for up, d for down, such as ud; all up if omitted
        tilt
            Tilt of each body's axis about the outward direction, degrees, such as 0,40; upright if omitted
        spin
            Rotation of each body about its own axis, degrees
        gap
            Gap between neighbours in the ring, and between the rings, beyond contact, Å [default: 0.5]
        box
            Edge of a cubic periodic box, or three edges, Å; open space if omitted
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.assemble.ring(["a.body", "b.body"], members=4, box=320, output="ring.json")  # doctest: +SKIP
        >>> pm.assemble.ring(["a.body", "b.body"], members=8, stack=2, directions="ud", output="stack.json")  # doctest: +SKIP
        """
        return call(
            Result,
            ["assemble", "ring"],
            [bodies],
            {
                "--members": members,
                "--output": output,
                "--stack": stack,
                "--directions": directions,
                "--tilt": tilt,
                "--spin": spin,
                "--gap": gap,
                "--box": box,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def fluid(
        self,
        bodies: Path | str | Body | Sequence[Path | str | Body],
        *,
        counts: int | str | Sequence[int | str],
        output: Path | str,
        seed: int | str | None = None,
        box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Bodies at random positions and orientations in a periodic box, without overlaps.

        Parameters
        ----------
        bodies
            Body files
        counts
            Number of copies of each body, in the order of the files, such as 8,8
        output
            Assembly file to write
        seed
            Seed of the random numbers [default: 1]
        box
            Edge of a cubic periodic box, or three edges, Å; open space if omitted
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.assemble.fluid(["a.body", "b.body"], counts="8,8", box=500, output="fluid.json")  # doctest: +SKIP
        >>> pm.assemble.fluid("a.body", counts=20, box=400, seed=7, output="fluid.json")  # doctest: +SKIP
        """
        return call(
            Result,
            ["assemble", "fluid"],
            [bodies],
            {
                "--counts": counts,
                "--output": output,
                "--seed": seed,
                "--box": box,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )


assemble = _Assemble()


def candidates(
    bodies: Path | str | Body | Sequence[Path | str | Body],
    *,
    ring: int | str,
    stack: int | str | None = None,
    symmetry: Literal["none", "cyclic", "dihedral"] | None = None,
    gap: float | str | None = None,
    box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    output: Path | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Enumerate the distinct up/down arrangements of bodies in a ring or a stack of two rings, up to the
    symmetry of the stack, and write each as an assembly closed to contact.

    Parameters
    ----------
    bodies
        Body files, in the order in which they alternate
    ring
        Bodies per ring
    stack
        Number of rings: one or two [default: 1]
    symmetry
        Symmetry required of an arrangement [default: dihedral]
    gap
        Gap between neighbours in the ring, and between the rings, beyond contact, Å [default: 0.5]
    box
        Edge of a cubic periodic box, or three edges, Å; open space if omitted
    output
        Folder for the assemblies; if omitted, they are only counted
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.candidates(["a.body", "b.body"], ring=8, stack=2)  # doctest: +SKIP
    >>> pm.candidates(["a.body", "b.body"], ring=4, stack=2, box=320, output="candidates")  # doctest: +SKIP
    """
    return call(
        Result,
        ["candidates"],
        [bodies],
        {
            "--ring": ring,
            "--stack": stack,
            "--symmetry": symmetry,
            "--gap": gap,
            "--box": box,
            "--output": output,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def compare(
    sweeps: Path | str | Sequence[Path | str],
    *,
    output: Path | str,
    title: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> CompareResult:
    """Draw several finished sweeps in one figure; the legend names the directories.

    Parameters
    ----------
    sweeps
        Sweep directories
    output
        Figure to write: .png or .svg
    title
        Title of the figure [default: Stability against salt]
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    CompareResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.compare(["spin_0", "spin_90"], output="spins.svg")  # doctest: +SKIP
    >>> pm.compare("stability", title="Ring", output="ring.png")  # doctest: +SKIP
    """
    return call(
        CompareResult,
        ["compare"],
        [sweeps],
        {
            "--output": output,
            "--title": title,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


class _Framework:
    """Elastic constants, mechanisms and deformation of a periodic network of rods and hinges: from a builder, or
    custom, from a TOML file (--write gives an example).
    """

    def __call__(
        self,
        file: Path | str | None = None,
        *,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """Elastic constants, mechanisms and deformation of a periodic network of rods and hinges: from a
        builder, or custom, from a TOML file (--write gives an example).

        Parameters
        ----------
        file
            Network file (TOML), instead of a builder
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.framework("net.toml", load="y", stress="1GPa,2GPa", output="pulled")  # doctest: +SKIP
        """
        return call(
            FrameworkResult,
            ["framework"],
            [file],
            {
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def honeycomb(
        self,
        *,
        theta: float | str,
        kh: float | str,
        ks: float | str,
        h: float | str | None = None,
        l: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """Hexagonal honeycomb: ribs h along z, ribs l at the angle theta to them; re-entrant below 90 degrees.

        Parameters
        ----------
        theta
            Angle between the two kinds of ribs, degrees
        kh
            Stiffness of each hinge between an h and an l rib, kcal/mol/rad²
        ks
            Stiffness of each rib, kcal/mol/Å²
        h
            Length of the ribs along z, Å [default: 2A]
        l
            Length of the inclined ribs, Å [default: 1A]
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            FrameworkResult,
            ["framework", "honeycomb"],
            [],
            {
                "--theta": theta,
                "--kh": kh,
                "--ks": ks,
                "--h": h,
                "--l": l,
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def rotating_squares(
        self,
        *,
        angle: float | str,
        ks: float | str,
        kh: float | str,
        side: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """Squares that share corners and rotate alternately.

        Parameters
        ----------
        angle
            Rotation of each polygon from the open position, degrees
        ks
            Stiffness of the rods that make a polygon rigid, kcal/mol/Å²
        kh
            K_h: stiffness of the hinge between two polygons, one at every shared corner, as in the published
            formulas, kcal/mol/rad²
        side
            Side of a polygon, Å [default: 1A]
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            FrameworkResult,
            ["framework", "rotating-squares"],
            [],
            {
                "--angle": angle,
                "--ks": ks,
                "--kh": kh,
                "--side": side,
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def rotating_triangles(
        self,
        *,
        angle: float | str,
        ks: float | str,
        kh: float | str,
        side: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """Equilateral triangles that share corners and rotate alternately.

        Parameters
        ----------
        angle
            Rotation of each polygon from the open position, degrees
        ks
            Stiffness of the rods that make a polygon rigid, kcal/mol/Å²
        kh
            K_h: stiffness of the hinge between two polygons, one at every shared corner, as in the published
            formulas, kcal/mol/rad²
        side
            Side of a polygon, Å [default: 1A]
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            FrameworkResult,
            ["framework", "rotating-triangles"],
            [],
            {
                "--angle": angle,
                "--ks": ks,
                "--kh": kh,
                "--side": side,
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def arrowhead(
        self,
        *,
        outer: float | str,
        inner: float | str,
        ks: float | str,
        kh: float | str,
        width: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """Arrowheads: long ribs at the outer and short ribs at the inner angle to z.

        Parameters
        ----------
        outer
            Angle of the long ribs to z, degrees
        inner
            Angle of the short ribs to z, degrees
        ks
            Stiffness of each rib, kcal/mol/Å²
        kh
            Stiffness of each hinge, one between any two adjacent ribs at a node, kcal/mol/rad²
        width
            Extent of a cell along y, Å [default: 2A]
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            FrameworkResult,
            ["framework", "arrowhead"],
            [],
            {
                "--outer": outer,
                "--inner": inner,
                "--ks": ks,
                "--kh": kh,
                "--width": width,
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def rod_lattice(
        self,
        *,
        r0: float | str,
        angle: float | str,
        square_ks: float | str,
        ks: float | str,
        kh: float | str,
        l: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """The lattice of squares whose corners are joined by rods.

        Parameters
        ----------
        r0
            Length of the rods between squares, Å
        angle
            Rotation of each square, degrees; 45 is open
        square_ks
            Stiffness of the rods that make a square rigid, kcal/mol/Å²
        ks
            Stiffness of the rods between squares, kcal/mol/Å²
        kh
            Stiffness of each hinge, one between any two adjacent rods at a node, kcal/mol/rad²
        l
            Half-diagonal of a square, Å [default: 1A]
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            FrameworkResult,
            ["framework", "rod-lattice"],
            [],
            {
                "--r0": r0,
                "--angle": angle,
                "--square-ks": square_ks,
                "--ks": ks,
                "--kh": kh,
                "--l": l,
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def fcc(
        self,
        *,
        ks: float | str,
        edge: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """Face-centred cubic net of nearest-neighbour rods.

        Parameters
        ----------
        ks
            Stiffness of each rod, kcal/mol/Å²
        edge
            Edge of the cubic cell, Å [default: 1A]
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            FrameworkResult,
            ["framework", "fcc"],
            [],
            {
                "--ks": ks,
                "--edge": edge,
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def diamond(
        self,
        *,
        ks: float | str,
        kh: float | str,
        edge: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> FrameworkResult:
        """Diamond net of nearest-neighbour rods, hinged between all rods at a node.

        Parameters
        ----------
        ks
            Stiffness of each rod, kcal/mol/Å²
        kh
            Stiffness of each hinge, one between every two rods at a node, kcal/mol/rad²
        edge
            Edge of the cubic cell, Å [default: 1A]
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        FrameworkResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            FrameworkResult,
            ["framework", "diamond"],
            [],
            {
                "--ks": ks,
                "--kh": kh,
                "--edge": edge,
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def tables(
        self,
        *,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: str | float | Sequence[str | float] | None = None,
        stress: str | float | Sequence[str | float] | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Tables 2 to 4 of Grima et al., Mol. Simul. 31, 925 (2005), printed and recomputed.

        Parameters
        ----------
        na
            Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23]
        cells
            Cells along each cell vector, such as 2x2
        thickness
            Thickness of a two-dimensional network, along x [default: 1A, or that of the file]
        relax
            First minimise the energy over nodes and cell
        fixed_cell
            With --relax: keep the cell fixed
        load
            Axis along which to load the network: x, y or z
        stress
            Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive
        stress_kind
            Reference area of the stress [default: nominal]
        derivatives
            Report energy, forces and Hessian (with --json or -o)
        write
            Write the network as TOML
        output
            Folder for result.json, tables (CSV), the drawing and the figure
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["framework", "tables"],
            [],
            {
                "--na": na,
                "--cells": cells,
                "--thickness": thickness,
                "--relax": relax,
                "--fixed-cell": fixed_cell,
                "--load": load,
                "--stress": stress,
                "--stress-kind": stress_kind,
                "--derivatives": derivatives,
                "--write": write,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )


framework = _Framework()


def inspect(
    assembly: Path | str | Assembly,
    *,
    energy: Literal["direct", "certified", "calibrated", "approximate", "none"] | None = None,
    tolerance: float | str | None = None,
    contact_gap: float | str | None = None,
    model: Literal["natural-1", "solution-1", "thesis"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    salt: str | None = None,
    salt_molar: float | None = None,
    temperature: float | str | None = None,
    permittivity: float | str | None = None,
    bjerrum: float | str | None = None,
    debye: float | str | None = None,
    cutoff: float | str | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Inspect an assembly: overlaps, pair energies, radius of gyration.

    Parameters
    ----------
    assembly
        Assembly file
    energy
        Energy model [default: direct]
    tolerance
        Largest likely error of the energy of two bodies, kT, with --energy approximate [default: 0.001]
    contact_gap
        Surfaces closer than this are in contact, Å [default: 5]
    model
        Model of the interactions between the bodies; other flags change single terms of it [default: none;
        natural-1 for binding]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        Factor on the attraction of the scale [default: 1]
    desolvation
        Count what charges lose where other bodies displace solvent; with effective charges
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M
    salt_molar
        The same as a number in mol/L, instead of `salt`
    temperature
        Temperature, K [default: 298.15]
    permittivity
        Relative permittivity; that of water at the temperature if omitted
    bjerrum
        Bjerrum length (such as 7.0A), instead of temperature and permittivity
    debye
        Debye length (such as 9.6A), instead of a salt concentration
    cutoff
        Cut-off distance, for comparison with calculations that have one; energies are then summed directly.
        No cut-off if omitted
    interaction
        Effect on the charges of the low permittivity of the bodies, which salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    memory_limit
        Memory limit for all tables of energies by levels, such as 500MB [default: 4GB]
    no_cache
        Do not read or write the cache of tables of energies by levels and of effective charges. The cache
        folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
        holds at most 2 GB
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.inspect("ring.json")  # doctest: +SKIP
    >>> pm.inspect("ring.json", salt="100mM", interaction="effective")  # doctest: +SKIP
    """
    return call(
        Result,
        ["inspect"],
        [assembly],
        {
            "--energy": energy,
            "--tolerance": tolerance,
            "--contact-gap": contact_gap,
            "--model": model,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--salt": salts("inspect", salt, salt_molar),
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--interaction": interaction,
            "--inner-permittivity": inner_permittivity,
            "--ion-radius": ion_radius,
            "--memory-limit": memory_limit,
            "--no-cache": no_cache,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def binding(
    receptor: Path | str | Body,
    ligand: Path | str | Body | None = None,
    *,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    body: str | float | Sequence[str | float] | None = None,
    ph: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    temperature: float | str | None = None,
    no_kd: bool = False,
    seed: int | str | None = None,
    exchanges: bool = False,
    spacing: float | str | None = None,
    margin: float | str | None = None,
    inner_permittivity: float | str | None = None,
    outer_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    model: Literal["natural-1", "solution-1", "thesis"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    chain: str | float | Sequence[str | float] | None = None,
    assembly: str | float | Sequence[str | float] | None = None,
    altloc: str | float | Sequence[str | float] | None = None,
    keep_ligands: bool = False,
    keep_waters: bool = False,
    keep_hydrogens: bool = False,
    keep_nucleic_acids: bool = False,
    missing: Literal["keep", "skip", "fail"] | None = None,
    structure_model: int | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Solve the Poisson-Boltzmann equation for a complex and its two parts: the charge part of the binding free
    energy against salt and pH, its slope d ln K / d ln c, and the energy of the fast interaction.

    Parameters
    ----------
    receptor
        Receptor, or the whole complex: a structure, PQR or body file
    ligand
        Ligand in the same frame; without it the two bodies are chains of the first file
    salt
        Concentrations of a 1:1 salt: a list such as 50mM,150mM or a range such as 10mM..1M/5. Differences are
        from the first
    salt_molar
        The same as numbers in mol/L, instead of `salt`
    body
        Chains that make up one body, such as H,L; once for each body
    ph
        pH values at which structure files are charged, such as 6,7.4 [default: 7.4]
    temperature
        Temperature, K [default: 298.15]
    no_kd
        Leave out the integration of the dissociation constant over the poses around the given one
    seed
        Seed of the random numbers of the integration [default: 1]
    exchanges
        Find what each exchange of charge at the interface (heavy atoms within 5 Å of the partner) would
        change, at the first salt: two more solves for each residue
    spacing
        Spacing of the fine grid, Å; a second grid is 1.4 times coarser [default: 0.7]
    margin
        Minimum distance between the atoms and the faces of the fine grid, Å [default: 10]
    inner_permittivity
        Relative permittivity inside the bodies [default: 2]
    outer_permittivity
        Relative permittivity of the solvent; that of water at the temperature if omitted
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    model
        Model of the interactions between the bodies; other flags change single terms of it [default: none;
        natural-1 for binding]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        Factor on the attraction of the scale [default: 1]
    chain
        Chains, by author name; all if omitted
    assembly
        Number of the biological assembly; the deposited coordinates if omitted
    altloc
        Preferred alternate location; the highest occupancy if omitted
    keep_ligands
        Keep ligands, ions and sugars
    keep_waters
        Keep waters
    keep_hydrogens
        Keep hydrogens
    keep_nucleic_acids
        Keep nucleic acids
    missing
        Treatment of residues that lack heavy atoms [default: keep]
    structure_model
        Model number; the first if omitted
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.binding("receptor.pdb", "ligand.pdb", salt="50mM,150mM,500mM")  # doctest: +SKIP
    >>> pm.binding("complex.cif.gz", body=["H,L", "A"], salt="150mM,50mM", ph="6,7.4", exchanges=True)  # doctest: +SKIP
    """
    return call(
        Result,
        ["binding"],
        [receptor, ligand],
        {
            "--salt": salts("binding", salt, salt_molar, required=True),
            "--body": body,
            "--ph": ph,
            "--temperature": temperature,
            "--no-kd": no_kd,
            "--seed": seed,
            "--exchanges": exchanges,
            "--spacing": spacing,
            "--margin": margin,
            "--inner-permittivity": inner_permittivity,
            "--outer-permittivity": outer_permittivity,
            "--ion-radius": ion_radius,
            "--model": model,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--chain": chain,
            "--assembly": assembly,
            "--altloc": altloc,
            "--keep-ligands": keep_ligands,
            "--keep-waters": keep_waters,
            "--keep-hydrogens": keep_hydrogens,
            "--keep-nucleic-acids": keep_nucleic_acids,
            "--missing": missing,
            "--structure-model": structure_model,
            "--threads": threads,
            "--force": force,
        },
        progress,
        repeated=["--body"],
    )


def pair(
    first: Path | str | Body,
    second: Path | str | Body | None = None,
    *,
    output: Path | str | None = None,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    ph: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    interaction: Literal["hard", "bare", "effective", "response"] | None = None,
    model: Literal["natural-1", "solution-1", "thesis"] | None = None,
    relative_error: float | str | None = None,
    b22_error: float | str | None = None,
    most_directions: int | str | None = None,
    seed: int | str | None = None,
    contact_gap: float | str | None = None,
    shard: str | float | Sequence[str | float] | None = None,
    core: Literal["surface", "beads"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    temperature: float | str | None = None,
    permittivity: float | str | None = None,
    bjerrum: float | str | None = None,
    debye: float | str | None = None,
    cutoff: float | str | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> PairResult:
    """The thermodynamics of two bodies over a grid of salt and pH: second virial coefficient, potential of mean
    force, dissociation constant, bound poses. The same command continues work that was stopped.

    Parameters
    ----------
    first
        A body or a structure file
    second
        The other body or structure file; a second copy of the first if omitted
    output
        Directory of the results; nothing is kept if omitted
    salt
        Salt concentrations: a list such as 10mM,50mM,100mM or a range such as 10mM..1M/8
    salt_molar
        The same as numbers in mol/L, instead of `salt`
    ph
        pH values at which structure files are made into bodies, such as 4.5,7
    interaction
        Interaction of the bodies apart from their hard cores [default: bare]
    model
        Model of the interactions between the bodies; other flags change single terms of it [default: none;
        natural-1 for binding]
    relative_error
        The wanted standard error of B2, relative to the larger of its magnitude and its hard part [default:
        0.004]
    b22_error
        The wanted standard error of B22, mol mL/g², such as 3e-5; instead of a relative one
    most_directions
        Directions with energies that may be sampled for one condition [default: 65536]
    seed
        Seed of the random numbers [default: 1]
    contact_gap
        Bodies whose surfaces are closer than this are bound, Å [default: 5]
    shard
        Compute only a part of the conditions, such as 2/8, alongside other processes in the same directory;
        the command without this flag collects the parts [default: 1/1]
    core
        Hard cores of the bodies: their surfaces, or the cores of the beads of the contact term [default:
        surface]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        Factor on the attraction of the scale [default: 1]
    desolvation
        Count what charges lose where other bodies displace solvent; with effective charges
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    temperature
        Temperature, K [default: 298.15]
    permittivity
        Relative permittivity; that of water at the temperature if omitted
    bjerrum
        Bjerrum length (such as 7.0A), instead of temperature and permittivity
    debye
        Debye length (such as 9.6A), instead of a salt concentration
    cutoff
        Cut-off distance, for comparison with calculations that have one; energies are then summed directly.
        No cut-off if omitted
    time_limit
        Stop (resumably, exit code 3) after this many minutes
    checkpoint_every
        Seconds between checkpoints: the most that a killed run loses [default: 20]
    no_cache
        Do not read or write the cache of tables of energies by levels and of effective charges. The cache
        folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
        holds at most 2 GB
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    client
        A `distributed.Client`, the address of a Dask scheduler such as "tcp://host:8786", or "local" for
        workers on this machine. The workers must see all files and folders under the same paths
    parts
        Number of parts with a client [default: four per worker thread]
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    PairResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it

    Examples
    --------
    >>> pm.pair("4lzt.pdb.gz", salt="100mM,300mM", ph=4.5, interaction="effective", output="lysozyme")  # doctest: +SKIP
    >>> pm.pair("a.body", "b.body", salt="10mM..1M/8", output="association")  # doctest: +SKIP
    """
    return call(
        PairResult,
        ["pair"],
        [first, second],
        {
            "--output": output,
            "--salt": salts("pair", salt, salt_molar),
            "--ph": ph,
            "--interaction": interaction,
            "--model": model,
            "--relative-error": relative_error,
            "--b22-error": b22_error,
            "--most-directions": most_directions,
            "--seed": seed,
            "--contact-gap": contact_gap,
            "--shard": shard,
            "--core": core,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--inner-permittivity": inner_permittivity,
            "--ion-radius": ion_radius,
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--time-limit": time_limit,
            "--checkpoint-every": checkpoint_every,
            "--no-cache": no_cache,
            "--threads": threads,
            "--force": force,
        },
        progress,
        client=client,
        parts=parts,
    )


def simulate(
    assembly: Path | str | Assembly,
    *,
    output: Path | str,
    salt: str | None = None,
    salt_molar: float | None = None,
    temperature: float | str | None = None,
    permittivity: float | str | None = None,
    bjerrum: float | str | None = None,
    debye: float | str | None = None,
    cutoff: float | str | None = None,
    config: Path | str | None = None,
    sweeps: int | str | None = None,
    equilibration: int | str | None = None,
    cluster_moves: int | str | None = None,
    binding_moves: int | str | None = None,
    seed: int | str | None = None,
    contact_gap: float | str | None = None,
    log_every: int | str | None = None,
    trajectory_every: int | str | None = None,
    energy: Literal["direct", "certified", "calibrated", "approximate", "none"] | None = None,
    tolerance: float | str | None = None,
    model: Literal["natural-1", "solution-1", "thesis"] | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> SimulationResult:
    """Run one simulation of an assembly at one salt concentration. The same command continues it.

    Parameters
    ----------
    assembly
        Assembly file
    output
        Directory of the results
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M
    salt_molar
        The same as a number in mol/L, instead of `salt`
    temperature
        Temperature, K [default: 298.15]
    permittivity
        Relative permittivity; that of water at the temperature if omitted
    bjerrum
        Bjerrum length (such as 7.0A), instead of temperature and permittivity
    debye
        Debye length (such as 9.6A), instead of a salt concentration
    cutoff
        Cut-off distance, for comparison with calculations that have one; energies are then summed directly.
        No cut-off if omitted
    config
        Configuration (TOML), such as the run.toml of another run; flags override it
    sweeps
        Total number of production sweeps (each one trial move per body, plus the cluster moves) [default:
        2000]
    equilibration
        Sweeps before production, in which step sizes are tuned and then frozen [default: 500]
    cluster_moves
        Geometric cluster moves per sweep [default: 1]
    binding_moves
        Moves per sweep that form and dissolve contacts: bodies put beside others or far from them, turns
        about contacts, groups, swaps [default: 0]
    seed
        Seed of the random numbers [default: 1]
    contact_gap
        Surfaces closer than this are in contact, Å [default: 5]
    log_every
        Sweeps between rows of the log [default: 10]
    trajectory_every
        Sweeps between frames of the trajectory; 0 for none [default: 100]
    energy
        Energy model [default: the fastest that makes the decisions of the direct sum]
    tolerance
        Largest likely error of the energy of two bodies, kT, with --energy approximate [default: 0.001]
    model
        Model of the interactions between the bodies; other flags change single terms of it [default: none;
        natural-1 for binding]
    interaction
        Effect on the charges of the low permittivity of the bodies, which salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        Factor on the attraction of the scale [default: 1]
    desolvation
        Count what charges lose where other bodies displace solvent; with effective charges
    time_limit
        Stop (resumably, exit code 3) after this many minutes
    checkpoint_every
        Seconds between checkpoints: the most that a killed run loses [default: 20]
    memory_limit
        Memory limit for all tables of energies by levels, such as 500MB [default: 4GB]
    no_cache
        Do not read or write the cache of tables of energies by levels and of effective charges. The cache
        folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
        holds at most 2 GB
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    SimulationResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it

    Examples
    --------
    >>> pm.simulate("ring.json", salt="100mM", output="run")  # doctest: +SKIP
    >>> pm.simulate("ring.json", salt="0.1M", sweeps=5000, interaction="effective", output="run")  # doctest: +SKIP
    """
    return call(
        SimulationResult,
        ["simulate"],
        [assembly],
        {
            "--output": output,
            "--salt": salts("simulate", salt, salt_molar),
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--config": config,
            "--sweeps": sweeps,
            "--equilibration": equilibration,
            "--cluster-moves": cluster_moves,
            "--binding-moves": binding_moves,
            "--seed": seed,
            "--contact-gap": contact_gap,
            "--log-every": log_every,
            "--trajectory-every": trajectory_every,
            "--energy": energy,
            "--tolerance": tolerance,
            "--model": model,
            "--interaction": interaction,
            "--inner-permittivity": inner_permittivity,
            "--ion-radius": ion_radius,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--time-limit": time_limit,
            "--checkpoint-every": checkpoint_every,
            "--memory-limit": memory_limit,
            "--no-cache": no_cache,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def sweep(
    assembly: Path | str | Assembly,
    *,
    output: Path | str,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    replicas: int | str | None = None,
    exchange_every: int | str | None = None,
    starts: Literal["assembly", "fluid", "both"] | None = None,
    shard: str | float | Sequence[str | float] | None = None,
    config: Path | str | None = None,
    sweeps: int | str | None = None,
    equilibration: int | str | None = None,
    cluster_moves: int | str | None = None,
    binding_moves: int | str | None = None,
    seed: int | str | None = None,
    contact_gap: float | str | None = None,
    log_every: int | str | None = None,
    trajectory_every: int | str | None = None,
    energy: Literal["direct", "certified", "calibrated", "approximate", "none"] | None = None,
    tolerance: float | str | None = None,
    model: Literal["natural-1", "solution-1", "thesis"] | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    temperature: float | str | None = None,
    permittivity: float | str | None = None,
    bjerrum: float | str | None = None,
    debye: float | str | None = None,
    cutoff: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> SweepResult:
    """Simulate an assembly at several salt concentrations, several replicas each: radius of gyration and
    surviving contacts against salt. The same command continues a sweep that was stopped.

    Parameters
    ----------
    assembly
        Assembly file
    output
        Directory of the results
    salt
        Salt concentrations: a list such as 10mM,50mM,100mM or a range such as 10mM..300mM/8
    salt_molar
        The same as numbers in mol/L, instead of `salt`
    replicas
        Independent replicas per salt concentration
    exchange_every
        Sweeps between two exchanges of states between neighbouring salt concentrations; 0 for none [default:
        0]
    starts
        Starting states of the replicas [default: assembly]
    shard
        Run only a part of the simulations, such as 2/8, alongside other processes in the same directory; the
        command without this flag collects the parts [default: 1/1]
    config
        Configuration (TOML), such as the run.toml of another run; flags override it
    sweeps
        Total number of production sweeps (each one trial move per body, plus the cluster moves) [default:
        2000]
    equilibration
        Sweeps before production, in which step sizes are tuned and then frozen [default: 500]
    cluster_moves
        Geometric cluster moves per sweep [default: 1]
    binding_moves
        Moves per sweep that form and dissolve contacts: bodies put beside others or far from them, turns
        about contacts, groups, swaps [default: 0]
    seed
        Seed of the random numbers [default: 1]
    contact_gap
        Surfaces closer than this are in contact, Å [default: 5]
    log_every
        Sweeps between rows of the log [default: 10]
    trajectory_every
        Sweeps between frames of the trajectory; 0 for none [default: 100]
    energy
        Energy model [default: the fastest that makes the decisions of the direct sum]
    tolerance
        Largest likely error of the energy of two bodies, kT, with --energy approximate [default: 0.001]
    model
        Model of the interactions between the bodies; other flags change single terms of it [default: none;
        natural-1 for binding]
    interaction
        Effect on the charges of the low permittivity of the bodies, which salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        Factor on the attraction of the scale [default: 1]
    desolvation
        Count what charges lose where other bodies displace solvent; with effective charges
    time_limit
        Stop (resumably, exit code 3) after this many minutes
    checkpoint_every
        Seconds between checkpoints: the most that a killed run loses [default: 20]
    memory_limit
        Memory limit for all tables of energies by levels, such as 500MB [default: 4GB]
    no_cache
        Do not read or write the cache of tables of energies by levels and of effective charges. The cache
        folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
        holds at most 2 GB
    temperature
        Temperature, K [default: 298.15]
    permittivity
        Relative permittivity; that of water at the temperature if omitted
    bjerrum
        Bjerrum length (such as 7.0A), instead of temperature and permittivity
    debye
        Debye length (such as 9.6A), instead of a salt concentration
    cutoff
        Cut-off distance, for comparison with calculations that have one; energies are then summed directly.
        No cut-off if omitted
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    client
        A `distributed.Client`, the address of a Dask scheduler such as "tcp://host:8786", or "local" for
        workers on this machine. The workers must see all files and folders under the same paths
    parts
        Number of parts with a client [default: four per worker thread]
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    SweepResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it

    Examples
    --------
    >>> pm.sweep("ring.json", salt="10mM..300mM/8", replicas=4, output="stability")  # doctest: +SKIP
    >>> pm.sweep("ring.json", salt="10mM,50mM,250mM", starts="both", exchange_every=20, output="equilibrium")  # doctest: +SKIP
    """
    return call(
        SweepResult,
        ["sweep"],
        [assembly],
        {
            "--output": output,
            "--salt": salts("sweep", salt, salt_molar),
            "--replicas": replicas,
            "--exchange-every": exchange_every,
            "--starts": starts,
            "--shard": shard,
            "--config": config,
            "--sweeps": sweeps,
            "--equilibration": equilibration,
            "--cluster-moves": cluster_moves,
            "--binding-moves": binding_moves,
            "--seed": seed,
            "--contact-gap": contact_gap,
            "--log-every": log_every,
            "--trajectory-every": trajectory_every,
            "--energy": energy,
            "--tolerance": tolerance,
            "--model": model,
            "--interaction": interaction,
            "--inner-permittivity": inner_permittivity,
            "--ion-radius": ion_radius,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--time-limit": time_limit,
            "--checkpoint-every": checkpoint_every,
            "--memory-limit": memory_limit,
            "--no-cache": no_cache,
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--threads": threads,
            "--force": force,
        },
        progress,
        client=client,
        parts=parts,
    )


def residues(
    input: Path | str,
    *,
    output: Path | str | None = None,
    mutations: bool = False,
    include_touching: bool = False,
    touching: float | str | None = None,
    frames: int | str | None = None,
    script: Literal["chimerax", "pymol"] | None = None,
    assembly: Path | str | None = None,
    salt: str | None = None,
    salt_molar: float | None = None,
    temperature: float | str | None = None,
    permittivity: float | str | None = None,
    bjerrum: float | str | None = None,
    debye: float | str | None = None,
    cutoff: float | str | None = None,
    model: Literal["natural-1", "solution-1", "thesis"] | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Share out the energy of an assembly by residues and pairs of residues, averaged over the frames of a sweep
    or a simulation: which residues hold it together, which touch, and what single exchanges of charge would
    change. Where effective charges interact, energies are shared out by the plain charges of the bodies.
    Where runs from the assembly and from a fluid disagree, only frames count in which more than half of the
    contacts are left.

    Parameters
    ----------
    input
        Directory of a sweep or a simulation, or an assembly file
    output
        Folder of tables, maps and a structure coloured by energy [default: residues in the directory of a
        run; none for an assembly]
    mutations
        Scan exchanges of single charges on the surfaces as well, and the half salt they lead to
    include_touching
        With --mutations: also list exchanges of residues that touch another body. Their energy changes by
        more than their charge does, which the scan does not know
    touching
        Residues touch where heavy atoms of them are closer than this [default: 5A]
    frames
        Frames that are used for each salt concentration [default: 200]
    script
        Write a script that shows the structure, coloured by energy
    assembly
        Assembly file of a run, if it has moved
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M
    salt_molar
        The same as a number in mol/L, instead of `salt`
    temperature
        Temperature, K [default: 298.15]
    permittivity
        Relative permittivity; that of water at the temperature if omitted
    bjerrum
        Bjerrum length (such as 7.0A), instead of temperature and permittivity
    debye
        Debye length (such as 9.6A), instead of a salt concentration
    cutoff
        Cut-off distance, for comparison with calculations that have one; energies are then summed directly.
        No cut-off if omitted
    model
        Model of the interactions between the bodies; other flags change single terms of it [default: none;
        natural-1 for binding]
    interaction
        Effect on the charges of the low permittivity of the bodies, which salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        Factor on the attraction of the scale [default: 1]
    desolvation
        Count what charges lose where other bodies displace solvent; with effective charges
    no_cache
        Do not read or write the cache of tables of energies by levels and of effective charges. The cache
        folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
        holds at most 2 GB
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.residues("stability", salt="100mM", mutations=True)  # doctest: +SKIP
    >>> pm.residues("ring.json", salt="100mM", output="holds", script="pymol")  # doctest: +SKIP
    """
    return call(
        Result,
        ["residues"],
        [input],
        {
            "--output": output,
            "--mutations": mutations,
            "--include-touching": include_touching,
            "--touching": touching,
            "--frames": frames,
            "--script": script,
            "--assembly": assembly,
            "--salt": salts("residues", salt, salt_molar),
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--model": model,
            "--interaction": interaction,
            "--inner-permittivity": inner_permittivity,
            "--ion-radius": ion_radius,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--no-cache": no_cache,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def reweight(
    input: Path | str,
    *,
    output: Path | str | None = None,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    concentration: str | float | Sequence[str | float] | None = None,
    skip: float | str | None = None,
    most_frames: int | str | None = None,
    assembly: Path | str | Assembly | None = None,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Weight the frames of a sweep at all salts together into curves between the salts that were simulated, with
    errors, and at other concentrations of bodies by mass action: where half of the contacts are left.

    Parameters
    ----------
    input
        Directory of a sweep over several salt concentrations
    output
        Directory for tables (CSV), JSON and figure
    salt
        Salt concentrations of the curves: a list or a range such as 10mM..300mM/30 [default: those of the
        sweep and three between neighbours]
    salt_molar
        The same as numbers in mol/L, instead of `salt`
    concentration
        Concentrations of bodies, beside that of the sweep: a list such as 10uM,1mM
    skip
        Share of the frames at the beginning of each trajectory that is left out [default: 0.2]
    most_frames
        Frames of each trajectory that are used at most, evenly spread [default: 200]
    assembly
        Assembly file of the sweep, if it has moved
    memory_limit
        Memory limit for all tables of energies by levels, such as 500MB [default: 4GB]
    no_cache
        Do not read or write the cache of tables of energies by levels and of effective charges. The cache
        folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
        holds at most 2 GB
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.reweight("stability", output="curves")  # doctest: +SKIP
    >>> pm.reweight("stability", salt="50mM..200mM/20", concentration="1uM,100uM")  # doctest: +SKIP
    """
    return call(
        Result,
        ["reweight"],
        [input],
        {
            "--output": output,
            "--salt": salts("reweight", salt, salt_molar),
            "--concentration": concentration,
            "--skip": skip,
            "--most-frames": most_frames,
            "--assembly": assembly,
            "--memory-limit": memory_limit,
            "--no-cache": no_cache,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


class _Lattice:
    """Two-dimensional crystals of rigid squares whose corners are joined by rigid rods."""

    def __call__(
        self,
        *,
        from_: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Two-dimensional crystals of rigid squares whose corners are joined by rigid rods.

        Parameters
        ----------
        from_
            The square that stands for this body, as `square` prints it
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.lattice(from_="bodies/square.body")  # doctest: +SKIP
        """
        return call(
            Result,
            ["lattice"],
            [],
            {
                "--from": from_,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def run(
        self,
        config: Path | str | None = None,
        *,
        output: Path | str,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        ns: int | str | None = None,
        rows: int | str | None = None,
        columns: int | str | None = None,
        r0: float | str | None = None,
        kappa: float | str | None = None,
        edges: Literal["open", "periodic"] | None = None,
        start: str | float | Sequence[str | float] | None = None,
        angle_spread: float | str | None = None,
        velocities: Literal["checkerboard", "random", "rest", "thermal"] | None = None,
        speed: float | str | None = None,
        velocity_spread: float | str | None = None,
        time: float | str | None = None,
        steps: int | str | None = None,
        dt: str | float | Sequence[str | float] | None = None,
        no_collisions: bool = False,
        restitution: float | str | None = None,
        paper: bool = False,
        temperature: float | str | None = None,
        friction: float | str | None = None,
        seed: int | str | None = None,
        log_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> LatticeResult:
        """Run one lattice. The same command continues it.

        Parameters
        ----------
        config
            Configuration (TOML), such as the run.toml of another run; flags override it
        output
            Directory of the results
        time_limit
            Stop (resumably, exit code 3) after this many minutes
        checkpoint_every
            Seconds between checkpoints: the most that a killed run loses [default: 20]
        ns
            Squares along an edge: rows and columns at once
        rows
            Rows of squares [default: 10]
        columns
            Columns of squares [default: 10]
        r0
            Length of the rods; the half-diagonal of a square is 1 [default: 3/22]
        kappa
            κ of the potential that favours coherent motion of the squares [default: 0]
        edges
            Boundary condition [default: open]
        start
            Orientation at the start: open, closed, or an angle in radians [default: open]
        angle_spread
            Standard deviation of random angles added to the start, radians [default: 0]
        velocities
            Velocities at the start [default: checkerboard]
        speed
            Angular velocity of every square (checkerboard), or the largest drawn (random) [default: 1]
        velocity_spread
            Standard deviation of random numbers added to the angular velocities of a checkerboard start
            [default: 0]
        time
            Run to this time [default: 10]
        steps
            Run to this many steps instead
        dt
            Time step: auto, or a number [default: auto]
        no_collisions
            Let squares pass through each other
        restitution
            Coefficient of restitution: 1 is elastic [default: 1]
        paper
            Collide as the paper does, with one mean collision time per step
        temperature
            kT of a heat bath; needs --friction
        friction
            Friction, an inverse time [default: 0]
        seed
            Seed of the random numbers [default: 1]
        log_every
            Steps between rows of the log [default: 10]
        trajectory_every
            Steps between frames of the trajectory; 0 for none [default: 50]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        LatticeResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        StoppedError
            If the time was over before the end; the same call continues it

        Examples
        --------
        >>> pm.lattice.run(ns=10, r0=0.05, time=3, output="coherent")  # doctest: +SKIP
        >>> pm.lattice.run("square.toml", time=10, output="rhua")  # doctest: +SKIP
        """
        return call(
            LatticeResult,
            ["lattice", "run"],
            [config],
            {
                "--output": output,
                "--time-limit": time_limit,
                "--checkpoint-every": checkpoint_every,
                "--ns": ns,
                "--rows": rows,
                "--columns": columns,
                "--r0": r0,
                "--kappa": kappa,
                "--edges": edges,
                "--start": start,
                "--angle-spread": angle_spread,
                "--velocities": velocities,
                "--speed": speed,
                "--velocity-spread": velocity_spread,
                "--time": time,
                "--steps": steps,
                "--dt": dt,
                "--no-collisions": no_collisions,
                "--restitution": restitution,
                "--paper": paper,
                "--temperature": temperature,
                "--friction": friction,
                "--seed": seed,
                "--log-every": log_every,
                "--trajectory-every": trajectory_every,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def sweep(
        self,
        config: Path | str | None = None,
        *,
        output: Path | str,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        r0_list: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        kappa_list: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        seeds: int | str | None = None,
        lyapunov: bool = False,
        lyapunov_intervals: int | str | None = None,
        ns: int | str | None = None,
        rows: int | str | None = None,
        columns: int | str | None = None,
        r0: float | str | None = None,
        kappa: float | str | None = None,
        edges: Literal["open", "periodic"] | None = None,
        start: str | float | Sequence[str | float] | None = None,
        angle_spread: float | str | None = None,
        velocities: Literal["checkerboard", "random", "rest", "thermal"] | None = None,
        speed: float | str | None = None,
        velocity_spread: float | str | None = None,
        time: float | str | None = None,
        steps: int | str | None = None,
        dt: str | float | Sequence[str | float] | None = None,
        no_collisions: bool = False,
        restitution: float | str | None = None,
        paper: bool = False,
        temperature: float | str | None = None,
        friction: float | str | None = None,
        seed: int | str | None = None,
        log_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> LatticeSweepResult:
        """Run lattices of several rod lengths and κ, once per seed, on all threads, with tables and figures. The
        same command continues a sweep that was stopped.

        Parameters
        ----------
        config
            Configuration (TOML), such as the run.toml of another run; flags override it
        output
            Directory of the results
        time_limit
            Stop (resumably, exit code 3) after this many minutes
        checkpoint_every
            Seconds between checkpoints: the most that a killed run loses [default: 20]
        r0_list
            Rod lengths, separated by commas [default: the [sweep] of the configuration]
        kappa_list
            κ, separated by commas
        seeds
            Runs per rod length and κ: seeds 1, 2, ...
        lyapunov
            Measure the maximal Lyapunov exponent of every run
        lyapunov_intervals
            Intervals over which the exponent is averaged [default: 200]
        ns
            Squares along an edge: rows and columns at once
        rows
            Rows of squares [default: 10]
        columns
            Columns of squares [default: 10]
        r0
            Length of the rods; the half-diagonal of a square is 1 [default: 3/22]
        kappa
            κ of the potential that favours coherent motion of the squares [default: 0]
        edges
            Boundary condition [default: open]
        start
            Orientation at the start: open, closed, or an angle in radians [default: open]
        angle_spread
            Standard deviation of random angles added to the start, radians [default: 0]
        velocities
            Velocities at the start [default: checkerboard]
        speed
            Angular velocity of every square (checkerboard), or the largest drawn (random) [default: 1]
        velocity_spread
            Standard deviation of random numbers added to the angular velocities of a checkerboard start
            [default: 0]
        time
            Run to this time [default: 10]
        steps
            Run to this many steps instead
        dt
            Time step: auto, or a number [default: auto]
        no_collisions
            Let squares pass through each other
        restitution
            Coefficient of restitution: 1 is elastic [default: 1]
        paper
            Collide as the paper does, with one mean collision time per step
        temperature
            kT of a heat bath; needs --friction
        friction
            Friction, an inverse time [default: 0]
        seed
            Seed of the random numbers [default: 1]
        log_every
            Steps between rows of the log [default: 10]
        trajectory_every
            Steps between frames of the trajectory; 0 for none [default: 50]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        LatticeSweepResult
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        StoppedError
            If the time was over before the end; the same call continues it

        Examples
        --------
        >>> pm.lattice.sweep(ns=4, r0_list="0.05,0.5,1", kappa_list="0,10", seeds=3, output="sweep")  # doctest: +SKIP
        >>> pm.lattice.sweep(ns=2, r0_list="0.25,0.5", seeds=2, lyapunov=True, output="chaos")  # doctest: +SKIP
        """
        return call(
            LatticeSweepResult,
            ["lattice", "sweep"],
            [config],
            {
                "--output": output,
                "--time-limit": time_limit,
                "--checkpoint-every": checkpoint_every,
                "--r0-list": r0_list,
                "--kappa-list": kappa_list,
                "--seeds": seeds,
                "--lyapunov": lyapunov,
                "--lyapunov-intervals": lyapunov_intervals,
                "--ns": ns,
                "--rows": rows,
                "--columns": columns,
                "--r0": r0,
                "--kappa": kappa,
                "--edges": edges,
                "--start": start,
                "--angle-spread": angle_spread,
                "--velocities": velocities,
                "--speed": speed,
                "--velocity-spread": velocity_spread,
                "--time": time,
                "--steps": steps,
                "--dt": dt,
                "--no-collisions": no_collisions,
                "--restitution": restitution,
                "--paper": paper,
                "--temperature": temperature,
                "--friction": friction,
                "--seed": seed,
                "--log-every": log_every,
                "--trajectory-every": trajectory_every,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def animate(
        self,
        directory: Path | str,
        *,
        output: Path | str | None = None,
        frames: Path | str | None = None,
        most_frames: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Make a self-contained HTML page that plays a run in any browser.

        Parameters
        ----------
        directory
            Directory of a run
        output
            The page [default: lattice.html in the directory]
        frames
            Write the frames as SVG files into this directory as well
        most_frames
            Maximum number of frames, evenly spaced over the run [default: 1000]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class

        Examples
        --------
        >>> pm.lattice.animate("coherent")  # doctest: +SKIP
        >>> pm.lattice.animate("coherent", output="coherent.html", frames="frames")  # doctest: +SKIP
        """
        return call(
            Result,
            ["lattice", "animate"],
            [directory],
            {
                "--output": output,
                "--frames": frames,
                "--most-frames": most_frames,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def square(
        self,
        body: Path | str | Body,
        *,
        axis: Literal["auto", "x", "y", "z"] | None = None,
        size: Literal["corners", "outside", "area"] | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """The square that represents a body with a symmetry axis, as part of a configuration.

        Parameters
        ----------
        body
            Body file
        axis
            Axis of projection [default: auto]
        size
            Definition of the half-diagonal [default: corners]
        output
            Write the configuration to this file instead of stdout
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["lattice", "square"],
            [body],
            {
                "--axis": axis,
                "--size": size,
                "--output": output,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def replay(
        self,
        file: Path | str,
        *,
        dt: float | str | None = None,
        longest: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Integrate the state of a file (JSON: ns, r0, kappa, s0, v0, times): without collisions to the listed
        times, and up to the first contact and through it.

        Parameters
        ----------
        file
            The file
        dt
            Time step; reduced slightly to match the listed times [default: 0.001]
        longest
            Time limit of the search for a contact [default: 20]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["lattice", "replay"],
            [file],
            {
                "--dt": dt,
                "--longest": longest,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def respond(
        self,
        file: Path | str,
        *,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """The elastic impact at the contact state of a file (JSON: ns, r0, first_collision with s and v).

        Parameters
        ----------
        file
            The file
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["lattice", "respond"],
            [file],
            {
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def bench(
        self,
        *,
        ns: int | str | None = None,
        r0: float | str | None = None,
        steps: int | str | None = None,
        dt: str | float | Sequence[str | float] | None = None,
        no_collisions: bool = False,
        seed: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Measure steps per CPU-second of a square lattice from a half-open start with random angular
        velocities.

        Parameters
        ----------
        ns
            Squares along an edge [default: 10]
        r0
            Length of the rods [default: 0.13636363636363635]
        steps
            Steps [default: 1000]
        dt
            Time step: auto, or a number [default: auto]
        no_collisions
            Let squares pass through each other
        seed
            Seed of the random numbers [default: 1]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.

        Returns
        -------
        Result
            The fields that `--json` prints, as attributes

        Raises
        ------
        MissingFileError
            If a file or a folder does not exist; also a `FileNotFoundError`
        ParseError
            If a file cannot be understood
        ConfigError
            If an argument is invalid
        ProtomerError
            For any other error; all of them are of this class
        """
        return call(
            Result,
            ["lattice", "bench"],
            [],
            {
                "--ns": ns,
                "--r0": r0,
                "--steps": steps,
                "--dt": dt,
                "--no-collisions": no_collisions,
                "--seed": seed,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )


lattice = _Lattice()


def report(
    directory: Path | str,
    *,
    output: Path | str | None = None,
    assembly: Path | str | Assembly | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Make a self-contained HTML page of a directory of results: figures with their numbers, rotatable bodies,
    animated lattices. The page loads nothing.

    Parameters
    ----------
    directory
        Directory of a simulation, a sweep, a lattice run or sweep, a framework, a training or a search; or a
        set of voxels
    output
        The page [default: report.html in the directory; SET.zarr.report.html beside a set of voxels]
    assembly
        Assembly file of a sweep or simulation, if it has moved
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.report("stability")  # doctest: +SKIP
    >>> pm.report("coherent", output="coherent.html", force=True)  # doctest: +SKIP
    """
    return call(
        Result,
        ["report"],
        [directory],
        {
            "--output": output,
            "--assembly": assembly,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def export(
    input: Path | str | Assembly | Body,
    *,
    output: Path | str,
    frame: str | float | Sequence[str | float] | None = None,
    salt: str | None = None,
    salt_molar: float | None = None,
    replica: int | str | None = None,
    assembly: Path | str | Assembly | None = None,
    values: Literal["charge", "hydropathy"] | None = None,
    gather: bool = False,
    script: Literal["chimerax", "pymol"] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Write an assembly, or a frame of a simulation, as a PDB or mmCIF file with all atoms of the bodies, and a
    script for a viewer. Chains get new identifiers; a table in the file says which copy and chain each was.

    Parameters
    ----------
    input
        Assembly file, body file, or directory of a simulation or a sweep
    output
        Structure file to write: .pdb or .cif
    frame
        Frame of a simulation, counted from 0, or last [default: last]
    salt
        Salt concentration of a sweep, such as 100mM
    salt_molar
        The same as a number in mol/L, instead of `salt`
    replica
        Replica of a sweep, counted from 0 [default: 0]
    assembly
        Assembly file of a simulation, if it has moved
    values
        Contents of the B factors of the residues; zero if omitted
    gather
        Shift copies by box lengths, so that a cluster across the border of a periodic box is in one piece
    script
        Write a script that opens the file, shows surfaces and colours each copy
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.export("ring.json", output="ring.cif", script="chimerax")  # doctest: +SKIP
    >>> pm.export("stability", salt="300mM", frame="last", output="end.pdb")  # doctest: +SKIP
    """
    return call(
        Result,
        ["export"],
        [input],
        {
            "--output": output,
            "--frame": frame,
            "--salt": salts("export", salt, salt_molar),
            "--replica": replica,
            "--assembly": assembly,
            "--values": values,
            "--gather": gather,
            "--script": script,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def scattering(
    input: Path | str | Assembly,
    *,
    output: Path | str | None = None,
    salt: str | None = None,
    salt_molar: float | None = None,
    assembly: Path | str | Assembly | None = None,
    skip: float | str | None = None,
    most_frames: int | str | None = None,
    q_max: float | str | None = None,
    q_points: int | str | None = None,
    directions: int | str | None = None,
    light_q: float | str | None = None,
    hydration: float | str | None = None,
    contact_gap: float | str | None = None,
    seed: int | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> ScatteringResult:
    """Compute the scattering of light and X-rays by an assembly or by the trajectories of a run: cluster sizes,
    hydrodynamic radii as dynamic light scattering averages them, S(q) of the centres, P(q) of the bodies and
    I(q) of the whole.

    Parameters
    ----------
    input
        Assembly file, or directory of a simulation or a sweep
    output
        Directory for tables (CSV), JSON and figure
    salt
        Only this salt concentration of a sweep, such as 100mM
    salt_molar
        The same as a number in mol/L, instead of `salt`
    assembly
        Assembly file of a run, if it has moved
    skip
        Share of the frames at the beginning of each trajectory that is left out [default: 0.2]
    most_frames
        Frames of each trajectory that are measured at most, evenly spread [default: 100]
    q_max
        Largest wave number, Å⁻¹ [default: 0.3]
    q_points
        Number of wave numbers [default: 60]
    directions
        Directions of the wave vector for each wave number and frame, at most [default: 24]
    light_q
        Wave number of the dynamic light scattering, Å⁻¹ [default: 0.00264, red light at 173° in water]
    hydration
        Thickness of the water that moves with a body, Å [default: 1.1]
    contact_gap
        Surfaces closer than this are in contact, Å [default: that of the run, or 5]
    seed
        Seed of the random directions [default: 1]
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    ScatteringResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.scattering("stability", output="scattering")  # doctest: +SKIP
    >>> pm.scattering("ring.json", q_max=0.2)  # doctest: +SKIP
    """
    return call(
        ScatteringResult,
        ["scattering"],
        [input],
        {
            "--output": output,
            "--salt": salts("scattering", salt, salt_molar),
            "--assembly": assembly,
            "--skip": skip,
            "--most-frames": most_frames,
            "--q-max": q_max,
            "--q-points": q_points,
            "--directions": directions,
            "--light-q": light_q,
            "--hydration": hydration,
            "--contact-gap": contact_gap,
            "--seed": seed,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def train(
    set: Path | str | None = None,
    *,
    output: Path | str,
    control: str | float | Sequence[str | float] | None = None,
    short: bool = False,
    config: Path | str | None = None,
    ablate: bool = False,
    ablation_seeds: int | str | None = None,
    target: Literal["label", "space-group", "crystal-system", "point-group", "polar", "number"] | None = None,
    least_samples: int | str | None = None,
    number_classes: int | str | None = None,
    channels: str | float | Sequence[str | float] | None = None,
    split_by: Literal["cluster", "sample"] | None = None,
    split_seed: int | str | None = None,
    fractions: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    scaling: Literal["robust", "raw", "box-standardised"] | None = None,
    permutations: int | str | None = None,
    rotations: bool = False,
    widths: int | str | Sequence[int | str] | None = None,
    kernels: int | str | Sequence[int | str] | None = None,
    groups: int | str | None = None,
    average_only: bool = False,
    epochs: int | str | None = None,
    patience: int | str | None = None,
    logit_adjustment: float | str | None = None,
    batch: int | str | None = None,
    learning_rate: float | str | None = None,
    seed: int | str | None = None,
    device: str | float | Sequence[str | float] | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> TrainResult:
    """Train a network on a set of voxels, or on a control. The same command continues it.

    Parameters
    ----------
    set
        Set of voxels (zarr), made by 'protomer voxelize'
    output
        Directory of the results
    control
        Synthetic set with a known answer: shapes, charge, patch, xor, assemblies, permuted, identity,
        orientation, size or heavy-tails
    short
        The control's short form: coarser grids, fewer samples
    config
        Settings (TOML), such as the best.toml of a search or the settings.toml of another training; flags
        override them
    ablate
        Train on every subset of the channels as well
    ablation_seeds
        Number of seeds per subset [default: 3]
    target
        The quantity to predict [default: label]
    least_samples
        Classes with fewer samples become one class, "other" [default: 10]
    number_classes
        Ordered classes that the numbers of --target number are cut into [default: 5]
    channels
        Input channels of the network, separated by commas [default: all]
    split_by
        Unit of the split [default: cluster]
    split_seed
        Seed of the split [default: that of --seed, or the one a configuration names]
    fractions
        Shares of training, validation and test [default: 0.7,0.15,0.15]
    scaling
        Scaling of the channels [default: robust]
    permutations
        Exchanges of labels in the permutation test [default: 1000]
    rotations
        Average predictions over the 24 rotations of the cube, at 24 times the cost
    widths
        Channels of each block, separated by commas [default: 16,32,64]
    kernels
        Edge of the kernels, 1, 3 or 5: one for all blocks, or one for each [default: 3]
    groups
        Groups of the group normalisation; 0 for none [default: 8]
    average_only
        Pool by the average only at the end, instead of average and maximum
    epochs
        Maximum number of passes over the training part [default: 50]
    patience
        Stop after this many epochs without a smaller validation loss; 0 for never [default: 10]
    logit_adjustment
        Logit adjustment τ: 0 learns with the observed class frequencies; 1 as if all classes were equally
        frequent, with the frequencies restored in the predictions [default: 0]
    batch
        Samples per step [default: 8]
    learning_rate
        Learning rate after the warm-up [default: 0.001]
    seed
        Seed of weights, order and rotations, and of the split without --split-seed [default: 1]
    device
        Device that runs the network: cpu, cuda, or cuda:1 for the second NVIDIA device. CUDA needs a build
        with --features cuda [default: cpu]
    time_limit
        Stop (resumably, exit code 3) after this many minutes
    checkpoint_every
        Seconds between checkpoints: the most that a killed run loses [default: 20]
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    TrainResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it

    Examples
    --------
    >>> pm.train("set.zarr", target="crystal-system", epochs=40, output="run")  # doctest: +SKIP
    >>> pm.train(control="charge", short=True, output="charge")  # doctest: +SKIP
    """
    return call(
        TrainResult,
        ["train"],
        [set],
        {
            "--output": output,
            "--control": control,
            "--short": short,
            "--config": config,
            "--ablate": ablate,
            "--ablation-seeds": ablation_seeds,
            "--target": target,
            "--least-samples": least_samples,
            "--number-classes": number_classes,
            "--channels": channels,
            "--split-by": split_by,
            "--split-seed": split_seed,
            "--fractions": fractions,
            "--scaling": scaling,
            "--permutations": permutations,
            "--rotations": rotations,
            "--widths": widths,
            "--kernels": kernels,
            "--groups": groups,
            "--average-only": average_only,
            "--epochs": epochs,
            "--patience": patience,
            "--logit-adjustment": logit_adjustment,
            "--batch": batch,
            "--learning-rate": learning_rate,
            "--seed": seed,
            "--device": device,
            "--time-limit": time_limit,
            "--checkpoint-every": checkpoint_every,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def predict(
    run: Path | str,
    set: Path | str,
    *,
    output: Path | str | None = None,
    device: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> PredictResult:
    """Apply a network trained by 'protomer train' to every sample of a set of voxels: class, probabilities, and
    scores where the labels are known.

    Parameters
    ----------
    run
        Directory of a finished training
    set
        Set of voxels (zarr), made by 'protomer voxelize' with the settings of the training set
    output
        Table to write (CSV); standard output if omitted
    device
        Device that runs the network: cpu, cuda, or cuda:1 for the second NVIDIA device. CUDA needs a build
        with --features cuda [default: cpu]
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    PredictResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.predict("run", "new.zarr", output="predictions.csv")  # doctest: +SKIP
    >>> pm.predict("run", "new.zarr")  # doctest: +SKIP
    """
    return call(
        PredictResult,
        ["predict"],
        [run, set],
        {
            "--output": output,
            "--device": device,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def tune(
    set: Path | str,
    *,
    output: Path | str,
    trials: int | str | None = None,
    epochs: int | str | None = None,
    seed: int | str | None = None,
    vary_channels: bool = False,
    shard: str | float | Sequence[str | float] | None = None,
    target: Literal["label", "space-group", "crystal-system", "point-group", "polar", "number"] | None = None,
    least_samples: int | str | None = None,
    number_classes: int | str | None = None,
    channels: str | float | Sequence[str | float] | None = None,
    split_by: Literal["cluster", "sample"] | None = None,
    split_seed: int | str | None = None,
    fractions: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    scaling: Literal["robust", "raw", "box-standardised"] | None = None,
    permutations: int | str | None = None,
    rotations: bool = False,
    device: str | float | Sequence[str | float] | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> TuneResult:
    """Search for the network that predicts best: blocks, kernels, channels, learning rate. The same command
    continues it.

    Parameters
    ----------
    set
        Set of voxels (zarr), made by 'protomer voxelize'
    output
        Directory of the results
    trials
        Number of networks to try [default: 27]
    epochs
        Passes over the training part for networks that are not stopped early [default: 27]
    seed
        Seed of the drawn settings, split, weights, order and rotations [default: 1]
    vary_channels
        Try subsets of the channels as well
    shard
        Run only a part of the trials, such as 2/8, alongside other processes in the same directory, until it
        has to wait for other parts; the command without this flag collects the results [default: 1/1]
    target
        The quantity to predict [default: label]
    least_samples
        Classes with fewer samples become one class, "other" [default: 10]
    number_classes
        Ordered classes that the numbers of --target number are cut into [default: 5]
    channels
        Input channels of the network, separated by commas [default: all]
    split_by
        Unit of the split [default: cluster]
    split_seed
        Seed of the split [default: that of --seed, or the one a configuration names]
    fractions
        Shares of training, validation and test [default: 0.7,0.15,0.15]
    scaling
        Scaling of the channels [default: robust]
    permutations
        Exchanges of labels in the permutation test [default: 1000]
    rotations
        Average predictions over the 24 rotations of the cube, at 24 times the cost
    device
        Device that runs the network: cpu, cuda, or cuda:1 for the second NVIDIA device. CUDA needs a build
        with --features cuda [default: cpu]
    time_limit
        Stop (resumably, exit code 3) after this many minutes
    checkpoint_every
        Seconds between checkpoints: the most that a killed run loses [default: 20]
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    client
        A `distributed.Client`, the address of a Dask scheduler such as "tcp://host:8786", or "local" for
        workers on this machine. The workers must see all files and folders under the same paths
    parts
        Number of parts with a client [default: four per worker thread]
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    TuneResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it

    Examples
    --------
    >>> pm.tune("set.zarr", target="crystal-system", trials=27, output="search")  # doctest: +SKIP
    >>> pm.tune("set.zarr", trials=9, shard="1/4", output="search")  # doctest: +SKIP
    """
    return call(
        TuneResult,
        ["tune"],
        [set],
        {
            "--output": output,
            "--trials": trials,
            "--epochs": epochs,
            "--seed": seed,
            "--vary-channels": vary_channels,
            "--shard": shard,
            "--target": target,
            "--least-samples": least_samples,
            "--number-classes": number_classes,
            "--channels": channels,
            "--split-by": split_by,
            "--split-seed": split_seed,
            "--fractions": fractions,
            "--scaling": scaling,
            "--permutations": permutations,
            "--rotations": rotations,
            "--device": device,
            "--time-limit": time_limit,
            "--checkpoint-every": checkpoint_every,
            "--threads": threads,
            "--force": force,
        },
        progress,
        client=client,
        parts=parts,
    )


def voxelize(
    *,
    manifest: Path | str,
    output: Path | str,
    size: int | str | None = None,
    spacing: str | float | Sequence[str | float] | None = None,
    channels: str | float | Sequence[str | float] | None = None,
    orientation: Literal["random", "principal", "deposited"] | None = None,
    seed: int | str | None = None,
    potential: Literal["poisson-boltzmann", "debye-hueckel"] | None = None,
    salt: str | None = None,
    salt_molar: float | None = None,
    temperature: float | str | None = None,
    ph: float | str | None = None,
    probe: float | str | None = None,
    hydropathy_reach: float | str | None = None,
    most_incomplete: float | str | None = None,
    bodies: Path | str | None = None,
    density: float | str | None = None,
    shard: str | float | Sequence[str | float] | None = None,
    time_limit: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> VoxelizeResult:
    """Turn the structures of a manifest into a set of sparse voxel grids, a zarr v3 group: surface, potential,
    hydropathy.

    Parameters
    ----------
    manifest
        CSV with the columns file, label, cluster and optionally family, name; paths are relative to its
        folder
    output
        The set to write, such as SET.zarr
    size
        Voxels along each edge of a grid [default: 64]
    spacing
        Edge of a voxel, Å; `fit` scales each structure to fill the grid [default: 1.0]
    channels
        Channels of the voxels [default: shape,potential,hydropathy]
    orientation
        The orientation of structures [default: random]
    seed
        Seed of the random orientations [default: 0]
    potential
        Model of the potential; the equation is solved on a grid of 1 Å [default: poisson-boltzmann]
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M [default: 150mM]
    salt_molar
        The same as a number in mol/L, instead of `salt`
    temperature
        Temperature, K [default: 298.15]
    ph
        pH of the protonation [default: 7.4]
    probe
        Probe radius of the surface, Å [default: 1.4]
    hydropathy_reach
        Range of the hydropathy: residues with an atom within this distance of a voxel's centre count, Å
        [default: 5]
    most_incomplete
        Structures are excluded if a larger share of their residues lacks heavy atoms [default: 0.25]
    bodies
        Make the bodies in this folder as well, as `protomer ingest --stream` does; each structure is read,
        charged and given its exact surface only once
    density
        With --bodies: mesh vertices per Å² [default: 1]
    shard
        Process only a part of the manifest, such as 2/8; `protomer merge` joins the parts [default: 1/1]
    time_limit
        Stop after this many minutes; the same command continues it
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    client
        A `distributed.Client`, the address of a Dask scheduler such as "tcp://host:8786", or "local" for
        workers on this machine. The workers must see all files and folders under the same paths
    parts
        Number of parts with a client [default: four per worker thread]
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    VoxelizeResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class
    StoppedError
        If the time was over before the end; the same call continues it

    Examples
    --------
    >>> pm.voxelize(manifest="set.csv", output="set.zarr", seed=1)  # doctest: +SKIP
    >>> pm.voxelize(manifest="set.csv", shard="1/4", output="part1.zarr")  # doctest: +SKIP
    """
    return call(
        VoxelizeResult,
        ["voxelize"],
        [],
        {
            "--manifest": manifest,
            "--output": output,
            "--size": size,
            "--spacing": spacing,
            "--channels": channels,
            "--orientation": orientation,
            "--seed": seed,
            "--potential": potential,
            "--salt": salts("voxelize", salt, salt_molar),
            "--temperature": temperature,
            "--ph": ph,
            "--probe": probe,
            "--hydropathy-reach": hydropathy_reach,
            "--most-incomplete": most_incomplete,
            "--bodies": bodies,
            "--density": density,
            "--shard": shard,
            "--time-limit": time_limit,
            "--threads": threads,
            "--force": force,
        },
        progress,
        client=client,
        parts=parts,
    )


def merge(
    inputs: Path | str | Sequence[Path | str],
    *,
    output: Path | str,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Merge sets of voxel grids with the same settings; the parts of one manifest give the same set as a single
    run.

    Parameters
    ----------
    inputs
        Sets to merge
    output
        The set to write
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    Result
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.merge(["part1.zarr", "part2.zarr"], output="set.zarr")  # doctest: +SKIP
    >>> pm.merge(["a.zarr", "b.zarr"], output="both.zarr", force=True)  # doctest: +SKIP
    """
    return call(
        Result,
        ["merge"],
        [inputs],
        {
            "--output": output,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def bench(
    assembly: Path | str | Assembly | None = None,
    *,
    moves: int | str | None = None,
    energy: Literal["direct", "certified", "calibrated", "approximate", "none"] | None = None,
    tolerance: float | str | None = None,
    part: str | float | Sequence[str | float] | None = None,
    charges: int | str | Sequence[int | str] | None = None,
    seed: int | str | None = None,
    salt: str | None = None,
    salt_molar: float | None = None,
    temperature: float | str | None = None,
    permittivity: float | str | None = None,
    bjerrum: float | str | None = None,
    debye: float | str | None = None,
    cutoff: float | str | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    model: Literal["natural-1", "solution-1", "thesis"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> BenchResult:
    """Measure trial moves per CPU-second on an assembly, from the state it is in, and hash the decisions made.
    Without an assembly: measure on states that the program makes itself, and print a table of each energy
    mode's rate against the number of charges, of the parts of a move, of the cost against the number of
    bodies, and of replicas on several threads. That takes a few minutes.

    Parameters
    ----------
    assembly
        Assembly file; left out, the program makes its own states
    moves
        Trial moves [default: 10000; without an assembly, as many as the direct sum makes in a few seconds]
    energy
        Method of computing energies [default: the fastest way that decides as the direct sum; without an
        assembly, each way]
    tolerance
        Largest likely error of the energy of two bodies, kT, with --energy approximate [default: 0.001]
    part
        Only this table (repeat for several)
    charges
        Numbers of charges per body in the tables [default: 500,3000]
    seed
        Seed of the random numbers, and of the program's own states [default: 1]
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M
    salt_molar
        The same as a number in mol/L, instead of `salt`
    temperature
        Temperature, K [default: 298.15]
    permittivity
        Relative permittivity; that of water at the temperature if omitted
    bjerrum
        Bjerrum length (such as 7.0A), instead of temperature and permittivity
    debye
        Debye length (such as 9.6A), instead of a salt concentration
    cutoff
        Cut-off distance, for comparison with calculations that have one; energies are then summed directly.
        No cut-off if omitted
    interaction
        Effect on the charges of the low permittivity of the bodies, which salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    model
        Model of the interactions between the bodies; other flags change single terms of it [default: none;
        natural-1 for binding]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        Factor on the attraction of the scale [default: 1]
    desolvation
        Count what charges lose where other bodies displace solvent; with effective charges
    memory_limit
        Memory limit for all tables of energies by levels, such as 500MB [default: 4GB]
    no_cache
        Do not read or write the cache of tables of energies by levels and of effective charges. The cache
        folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
        holds at most 2 GB
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.

    Returns
    -------
    BenchResult
        The fields that `--json` prints, as attributes

    Raises
    ------
    MissingFileError
        If a file or a folder does not exist; also a `FileNotFoundError`
    ParseError
        If a file cannot be understood
    ConfigError
        If an argument is invalid
    ProtomerError
        For any other error; all of them are of this class

    Examples
    --------
    >>> pm.bench("ring.json", salt="300mM", moves=2000)  # doctest: +SKIP
    >>> pm.bench(part="charges", charges=500)  # doctest: +SKIP
    """
    return call(
        BenchResult,
        ["bench"],
        [assembly],
        {
            "--moves": moves,
            "--energy": energy,
            "--tolerance": tolerance,
            "--part": part,
            "--charges": charges,
            "--seed": seed,
            "--salt": salts("bench", salt, salt_molar),
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--interaction": interaction,
            "--inner-permittivity": inner_permittivity,
            "--ion-radius": ion_radius,
            "--model": model,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--memory-limit": memory_limit,
            "--no-cache": no_cache,
            "--threads": threads,
            "--force": force,
        },
        progress,
        repeated=["--part"],
    )
