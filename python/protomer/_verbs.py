"""The verbs of protomer as functions. Written by the program from its table of flags; do not edit:
UPDATE_REFERENCE=1 cargo test -p protomer-cli --test documentation
"""

# ruff: noqa: E501
from __future__ import annotations

from typing import Literal

from ._call import Client, Integer, Integers, Number, Numbers, Path, Paths, Progress, Quantity, Text, call
from .results import (
    BenchResult,
    CompareResult,
    FrameworkResult,
    LatticeResult,
    LatticeSweepResult,
    PairResult,
    PotentialResult,
    PredictResult,
    Result,
    SimulationResult,
    SweepResult,
    TrainResult,
    TuneResult,
    VoxelizeResult,
)

__all__ = [
    "ingest",
    "fetch",
    "surface",
    "potential",
    "shape",
    "hpmc",
    "phase-diagram",
    "body",
    "assemble",
    "candidates",
    "compare",
    "framework",
    "inspect",
    "pair",
    "simulate",
    "sweep",
    "lattice",
    "report",
    "export",
    "train",
    "predict",
    "tune",
    "voxelize",
    "merge",
    "bench",
]


def ingest(
    inputs: Paths,
    *,
    output: Path,
    name: Text | None = None,
    chain: Text | None = None,
    model: Text | None = None,
    assembly: Text | None = None,
    altloc: Text | None = None,
    keep_ligands: bool = False,
    keep_waters: bool = False,
    keep_hydrogens: bool = False,
    keep_nucleic_acids: bool = False,
    missing: Literal["keep", "skip", "fail"] | None = None,
    ph: Number | None = None,
    charges: Literal["force-field", "formal", "none"] | None = None,
    mutate: Text | None = None,
    density: Number | None = None,
    probe: Number | None = None,
    cavities: Literal["drop", "keep"] | None = None,
    interior_radius: Number | None = None,
    offset: Number | None = None,
    export: Text | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Turn structure files (PDB, mmCIF, PQR, each also gzipped) into bodies: surface mesh, charges, hydropathy.

    Parameters
    ----------
    inputs
        Structure files, or folders that contain them
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
        What to do with residues that lack heavy atoms [default: keep]
    ph
        pH of the protonation equilibria [default: 7.4]
    charges
        Where the charges sit [default: force-field]
    mutate
        Point mutations, such as A:K45E,B:N12D; side chains are replaced in place
    density
        Mesh vertices per Å² [default: 1]
    probe
        Probe radius, Å [default: 1.4]
    cavities
        What to do with cavities inside the body [default: drop]
    interior_radius
        A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors are never filled,
        because other bodies may be inside [default: 10]
    offset
        Move the surface inward by this much, Å [default: 0]
    export
        Also write the mesh and the charges in these formats
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.
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
            "--probe": probe,
            "--cavities": cavities,
            "--interior-radius": interior_radius,
            "--offset": offset,
            "--export": export,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def fetch(
    entries: Text,
    *,
    output: Path | None = None,
    base: Text | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    input: Path,
    *,
    density: Number | None = None,
    probe: Number | None = None,
    cavities: Literal["drop", "keep"] | None = None,
    interior_radius: Number | None = None,
    offset: Number | None = None,
    output: Path | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Compute the solvent-excluded surface of a structure, a PQR, a body, or an .xyzr file (x y z radius per
    line): mesh, exact area and volume. Cavities are kept by default.

    Parameters
    ----------
    input
        Structure, PQR, body or .xyzr file, optionally gzipped
    density
        Mesh vertices per Å² [default: 1]
    probe
        Probe radius, Å [default: 1.4]
    cavities
        What to do with cavities [default: keep]
    interior_radius
        A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors are never filled
        [default: 10]
    offset
        Move the surface inward by this much, Å [default: 0]
    output
        Mesh file to write: .ply, .obj, .off or .stl
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.
    """
    return call(
        Result,
        ["surface"],
        [input],
        {
            "--density": density,
            "--probe": probe,
            "--cavities": cavities,
            "--interior-radius": interior_radius,
            "--offset": offset,
            "--output": output,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def potential(
    input: Path,
    *,
    salt: Quantity,
    model: Literal["poisson-boltzmann", "debye-hueckel"] | None = None,
    spacing: Number | None = None,
    margin: Number | None = None,
    boundary: Literal["screened-atoms", "coarse-grid"] | None = None,
    temperature: Number | None = None,
    inner_permittivity: Number | None = None,
    outer_permittivity: Number | None = None,
    ion_radius: Number | None = None,
    surface: Literal["solvent-excluded", "van-der-waals", "solvent-accessible"] | None = None,
    probe: Number | None = None,
    points: Path | None = None,
    no_error_estimate: bool = False,
    output: Path | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> PotentialResult:
    """Solve the linearised Poisson-Boltzmann equation around a structure, PQR or body: potential in kT/e and
    solvation energy.

    Parameters
    ----------
    input
        Structure, PQR or body file, optionally gzipped
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M
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
        Volume file to write: .mrc, .map, .ccp4, .dx or .npz
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.
    """
    return call(
        PotentialResult,
        ["potential"],
        [input],
        {
            "--salt": salt,
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
    coefficient, exactly. The shape is the convex hull of the points of a file: text with two columns (a
    polygon) or three (a polyhedron), or an .off, .obj, .ply or .stl mesh. One point with a rounding is a disk
    or a ball. Or it has a name: tetrahedron, cube, octahedron, dodecahedron, icosahedron (edges of length 1),
    truncated-tetrahedron:T (T from 0, the tetrahedron with edges of length 1, to 1, the octahedron; 2/3 is
    Archimedean), cuboid:A,B,C, prism:N,HEIGHT (edges of length 1), polygon:N (area 1).
    """

    def __call__(
        self,
        shape: Text | None = None,
        *,
        rounding: Number | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
    ) -> Result:
        """Measure a convex shape, rounded or not: volume, surface, integrated mean curvature and second virial
        coefficient, exactly. The shape is the convex hull of the points of a file: text with two columns (a
        polygon) or three (a polyhedron), or an .off, .obj, .ply or .stl mesh. One point with a rounding is a
        disk or a ball. Or it has a name: tetrahedron, cube, octahedron, dodecahedron, icosahedron (edges of
        length 1), truncated-tetrahedron:T (T from 0, the tetrahedron with edges of length 1, to 1, the
        octahedron; 2/3 is Archimedean), cuboid:A,B,C, prism:N,HEIGHT (edges of length 1), polygon:N (area 1).

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
        pairs: Path,
        *,
        potential: Literal["contact", "face-sum", "smooth"] | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
            Which points of the bodies repel each other [default: smooth]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.
        """
        return call(
            Result,
            ["shape", "contact"],
            [pairs],
            {
                "--potential": potential,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )


shape = _Shape()


class _Hpmc:
    """Hard convex bodies in a periodic box, with penetrable depletants."""

    def run(
        self,
        *,
        shape: Text,
        packing_fraction: Number,
        output: Path,
        rounding: Number | None = None,
        bodies: Integer | None = None,
        depletants: Text | None = None,
        equilibration: Integer | None = None,
        sweeps: Integer | None = None,
        seed: Integer | None = None,
        sample_every: Integer | None = None,
        trajectory_every: Integer | None = None,
        insertions: Integer | None = None,
        points: Integer | None = None,
        time_limit: Number | None = None,
        checkpoint_every: Number | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
    ) -> Result:
        """Run hard bodies in a periodic cube or square. The same command continues the run; more sweeps extend
        it. Bodies are placed at random and compressed to the packing fraction. In the equilibration the steps
        are tuned; then the pressure is measured by trial compressions, the free volume of the depletants by
        random points, and the chemical potential by insertion.

        Parameters
        ----------
        shape
            File with points, or the name of a shape, as for `shape`
        packing_fraction
            The part of the box that the bodies fill
        output
            Directory of the results
        rounding
            Radius of the ball, or disk, that rounds it (Minkowski sum) [default: 0]
        bodies
            Number of bodies [default: 216]
        depletants
            Penetrable hard spheres, or disks, in equilibrium with a reservoir: radius and number density in
            the reservoir, several with commas between them. With density 0 only free volumes are measured
        equilibration
            Sweeps in which the steps are tuned and nothing is measured [default: 2000]
        sweeps
            Sweeps after that; a sweep is one trial move per body [default: 10000]
        seed
            Seed of the random numbers [default: 1]
        sample_every
            Sweeps between measurements [default: 5]
        trajectory_every
            Sweeps between frames of the trajectory; 0 for none [default: 500]
        insertions
            Bodies inserted at random per measurement, for the chemical potential [default: 0]
        points
            Points per measurement, for free volumes [default: ten per body]
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
                "--depletants": depletants,
                "--equilibration": equilibration,
                "--sweeps": sweeps,
                "--seed": seed,
                "--sample-every": sample_every,
                "--trajectory-every": trajectory_every,
                "--insertions": insertions,
                "--points": points,
                "--time-limit": time_limit,
                "--checkpoint-every": checkpoint_every,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )


hpmc = _Hpmc()


def phase-diagram(
    *,
    size_ratio: Numbers | None = None,
    reservoir: Numbers | None = None,
    branch: Paths | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Print the phases that coexist: their packing fractions, pressure and chemical potential. With
    `--size-ratio` and `--reservoir`, hard spheres among penetrable depletants by free volume theory: the
    fluid of Carnahan and Starling, the cell model of the crystal, free volumes of scaled particle theory.
    With `--branch`, tables of free energies: two columns, a packing fraction (or density) and the free energy
    per volume, one file per phase. Pressures are in units of kT over the volume of a sphere, chemical
    potentials in kT; with tables both are in the units of the tables.

    Parameters
    ----------
    size_ratio
        Radius of the depletants over that of the spheres; several with commas between them
    reservoir
        Packing fraction of the depletants in the reservoir; several with commas between them
    branch
        Table of the free energy of a phase; once per phase
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.
    """
    return call(
        Result,
        ["phase-diagram"],
        [],
        {
            "--size-ratio": size_ratio,
            "--reservoir": reservoir,
            "--branch": branch,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )


def body(
    *,
    mesh: Path,
    output: Path,
    charges: Path | None = None,
    name: Text | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
        input: Path,
        *,
        output: Path,
        chain: Text | None = None,
        model: Text | None = None,
        assembly: Text | None = None,
        altloc: Text | None = None,
        keep_ligands: bool = False,
        keep_waters: bool = False,
        keep_hydrogens: bool = False,
        keep_nucleic_acids: bool = False,
        missing: Literal["keep", "skip", "fail"] | None = None,
        ph: Number | None = None,
        charges: Literal["force-field", "formal", "none"] | None = None,
        mutate: Text | None = None,
        density: Number | None = None,
        probe: Number | None = None,
        cavities: Literal["drop", "keep"] | None = None,
        interior_radius: Number | None = None,
        offset: Number | None = None,
        relax: bool = False,
        box: Numbers | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
    ) -> Result:
        """Decompose a structure: identical chains become one body, and each copy a pose.

        Parameters
        ----------
        input
            Structure file
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
            What to do with residues that lack heavy atoms [default: keep]
        ph
            pH of the protonation equilibria [default: 7.4]
        charges
            Where the charges sit [default: force-field]
        mutate
            Point mutations, such as A:K45E,B:N12D; side chains are replaced in place
        density
            Mesh vertices per Å² [default: 1]
        probe
            Probe radius, Å [default: 1.4]
        cavities
            What to do with cavities inside the body [default: drop]
        interior_radius
            A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors are never
            filled, because other bodies may be inside [default: 10]
        offset
            Move the surface inward by this much, Å [default: 0]
        relax
            Remove overlaps of the hard surfaces by the smallest uniform expansion
        box
            Edge of a cubic periodic box, or three edges, Å; open space if omitted
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.
        """
        return call(
            Result,
            ["assemble", "structure"],
            [input],
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
                "--probe": probe,
                "--cavities": cavities,
                "--interior-radius": interior_radius,
                "--offset": offset,
                "--relax": relax,
                "--box": box,
                "--threads": threads,
                "--force": force,
            },
            progress,
        )

    def ring(
        self,
        bodies: Paths,
        *,
        members: Integer,
        output: Path,
        stack: Integer | None = None,
        directions: Text | None = None,
        tilt: Numbers | None = None,
        spin: Numbers | None = None,
        gap: Number | None = None,
        box: Numbers | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        bodies: Paths,
        *,
        counts: Integers,
        output: Path,
        seed: Integer | None = None,
        box: Numbers | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
    bodies: Paths,
    *,
    ring: Integer,
    stack: Integer | None = None,
    symmetry: Literal["none", "cyclic", "dihedral"] | None = None,
    gap: Number | None = None,
    box: Numbers | None = None,
    output: Path | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    sweeps: Paths,
    *,
    output: Path,
    title: Text | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
        file: Path | None = None,
        *,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        theta: Number,
        kh: Number,
        ks: Number,
        h: Number | None = None,
        l: Number | None = None,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        angle: Number,
        ks: Number,
        kh: Number,
        side: Number | None = None,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        angle: Number,
        ks: Number,
        kh: Number,
        side: Number | None = None,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        outer: Number,
        inner: Number,
        ks: Number,
        kh: Number,
        width: Number | None = None,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        r0: Number,
        angle: Number,
        square_ks: Number,
        ks: Number,
        kh: Number,
        l: Number | None = None,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        ks: Number,
        edge: Number | None = None,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        ks: Number,
        kh: Number,
        edge: Number | None = None,
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        na: Number | None = None,
        cells: Text | None = None,
        thickness: Text | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        load: Text | None = None,
        stress: Text | None = None,
        stress_kind: Literal["nominal", "cauchy"] | None = None,
        derivatives: bool = False,
        write: Path | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
    assembly: Path,
    *,
    energy: Literal["direct", "calibrated", "approximate", "none"] | None = None,
    tolerance: Number | None = None,
    contact_gap: Number | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: Number | None = None,
    desolvation: bool = False,
    salt: Quantity | None = None,
    temperature: Number | None = None,
    permittivity: Number | None = None,
    bjerrum: Number | None = None,
    debye: Number | None = None,
    cutoff: Number | None = None,
    interaction: Literal["bare", "effective"] | None = None,
    inner_permittivity: Number | None = None,
    ion_radius: Number | None = None,
    memory_limit: Integer | None = None,
    no_cache: bool = False,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        What multiplies the attraction of the scale [default: 1]
    desolvation
        Count what charges lose where other bodies displace solvent; with effective charges
    salt
        Concentration of a 1:1 salt, such as 100mM or 0.1M
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
        Whether the charges of the bodies act, or their effective charges: those that give the potential
        around bodies of low permittivity that salt does not enter [default: bare]
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
    """
    return call(
        Result,
        ["inspect"],
        [assembly],
        {
            "--energy": energy,
            "--tolerance": tolerance,
            "--contact-gap": contact_gap,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--salt": salt,
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


def pair(
    first: Path,
    second: Path | None = None,
    *,
    output: Path | None = None,
    salt: Quantity | None = None,
    ph: Numbers | None = None,
    interaction: Literal["hard", "bare", "effective"] | None = None,
    relative_error: Number | None = None,
    b22_error: Number | None = None,
    most_directions: Integer | None = None,
    seed: Integer | None = None,
    contact_gap: Number | None = None,
    shard: Text | None = None,
    core: Literal["surface", "beads"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: Number | None = None,
    desolvation: bool = False,
    inner_permittivity: Number | None = None,
    ion_radius: Number | None = None,
    temperature: Number | None = None,
    permittivity: Number | None = None,
    bjerrum: Number | None = None,
    debye: Number | None = None,
    cutoff: Number | None = None,
    time_limit: Number | None = None,
    checkpoint_every: Number | None = None,
    no_cache: bool = False,
    threads: Integer | None = None,
    force: bool = False,
    client: Client | None = None,
    parts: int | None = None,
    progress: Progress | None = None,
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
    ph
        pH values at which structure files are made into bodies, such as 4.5,7
    interaction
        What acts between the bodies beside their surfaces [default: bare]
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
        What keeps the bodies apart: their surfaces, or the cores of the beads of the contact term [default:
        surface]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        What multiplies the attraction of the scale [default: 1]
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
    """
    return call(
        PairResult,
        ["pair"],
        [first, second],
        {
            "--output": output,
            "--salt": salt,
            "--ph": ph,
            "--interaction": interaction,
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
    assembly: Path,
    *,
    output: Path,
    salt: Quantity | None = None,
    temperature: Number | None = None,
    permittivity: Number | None = None,
    bjerrum: Number | None = None,
    debye: Number | None = None,
    cutoff: Number | None = None,
    config: Path | None = None,
    sweeps: Integer | None = None,
    equilibration: Integer | None = None,
    cluster_moves: Integer | None = None,
    seed: Integer | None = None,
    contact_gap: Number | None = None,
    log_every: Integer | None = None,
    trajectory_every: Integer | None = None,
    energy: Literal["direct", "calibrated", "approximate", "none"] | None = None,
    tolerance: Number | None = None,
    interaction: Literal["bare", "effective"] | None = None,
    inner_permittivity: Number | None = None,
    ion_radius: Number | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: Number | None = None,
    desolvation: bool = False,
    time_limit: Number | None = None,
    checkpoint_every: Number | None = None,
    memory_limit: Integer | None = None,
    no_cache: bool = False,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    interaction
        Whether the charges of the bodies act, or their effective charges: those that give the potential
        around bodies of low permittivity that salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        What multiplies the attraction of the scale [default: 1]
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
    """
    return call(
        SimulationResult,
        ["simulate"],
        [assembly],
        {
            "--output": output,
            "--salt": salt,
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--config": config,
            "--sweeps": sweeps,
            "--equilibration": equilibration,
            "--cluster-moves": cluster_moves,
            "--seed": seed,
            "--contact-gap": contact_gap,
            "--log-every": log_every,
            "--trajectory-every": trajectory_every,
            "--energy": energy,
            "--tolerance": tolerance,
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
    assembly: Path,
    *,
    output: Path,
    salt: Quantity | None = None,
    replicas: Integer | None = None,
    exchange_every: Integer | None = None,
    starts: Literal["assembly", "fluid", "both"] | None = None,
    shard: Text | None = None,
    config: Path | None = None,
    sweeps: Integer | None = None,
    equilibration: Integer | None = None,
    cluster_moves: Integer | None = None,
    seed: Integer | None = None,
    contact_gap: Number | None = None,
    log_every: Integer | None = None,
    trajectory_every: Integer | None = None,
    energy: Literal["direct", "calibrated", "approximate", "none"] | None = None,
    tolerance: Number | None = None,
    interaction: Literal["bare", "effective"] | None = None,
    inner_permittivity: Number | None = None,
    ion_radius: Number | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: Number | None = None,
    desolvation: bool = False,
    time_limit: Number | None = None,
    checkpoint_every: Number | None = None,
    memory_limit: Integer | None = None,
    no_cache: bool = False,
    temperature: Number | None = None,
    permittivity: Number | None = None,
    bjerrum: Number | None = None,
    debye: Number | None = None,
    cutoff: Number | None = None,
    threads: Integer | None = None,
    force: bool = False,
    client: Client | None = None,
    parts: int | None = None,
    progress: Progress | None = None,
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
    replicas
        Independent replicas per salt concentration
    exchange_every
        Sweeps between two exchanges of states between neighbouring salt concentrations; 0 for none [default:
        0]
    starts
        Where the replicas start [default: assembly]
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
    interaction
        Whether the charges of the bodies act, or their effective charges: those that give the potential
        around bodies of low permittivity that salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        What multiplies the attraction of the scale [default: 1]
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
    """
    return call(
        SweepResult,
        ["sweep"],
        [assembly],
        {
            "--output": output,
            "--salt": salt,
            "--replicas": replicas,
            "--exchange-every": exchange_every,
            "--starts": starts,
            "--shard": shard,
            "--config": config,
            "--sweeps": sweeps,
            "--equilibration": equilibration,
            "--cluster-moves": cluster_moves,
            "--seed": seed,
            "--contact-gap": contact_gap,
            "--log-every": log_every,
            "--trajectory-every": trajectory_every,
            "--energy": energy,
            "--tolerance": tolerance,
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


class _Lattice:
    """Two-dimensional crystals of rigid squares whose corners are joined by rigid rods."""

    def __call__(
        self,
        *,
        from_: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        config: Path | None = None,
        *,
        output: Path,
        time_limit: Number | None = None,
        checkpoint_every: Number | None = None,
        ns: Integer | None = None,
        rows: Integer | None = None,
        columns: Integer | None = None,
        r0: Number | None = None,
        kappa: Number | None = None,
        edges: Literal["open", "periodic"] | None = None,
        start: Text | None = None,
        angle_spread: Number | None = None,
        velocities: Literal["checkerboard", "random", "rest", "thermal"] | None = None,
        speed: Number | None = None,
        velocity_spread: Number | None = None,
        time: Number | None = None,
        steps: Integer | None = None,
        dt: Text | None = None,
        no_collisions: bool = False,
        restitution: Number | None = None,
        paper: bool = False,
        temperature: Number | None = None,
        friction: Number | None = None,
        seed: Integer | None = None,
        log_every: Integer | None = None,
        trajectory_every: Integer | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        config: Path | None = None,
        *,
        output: Path,
        time_limit: Number | None = None,
        checkpoint_every: Number | None = None,
        r0_list: Numbers | None = None,
        kappa_list: Numbers | None = None,
        seeds: Integer | None = None,
        lyapunov: bool = False,
        lyapunov_intervals: Integer | None = None,
        ns: Integer | None = None,
        rows: Integer | None = None,
        columns: Integer | None = None,
        r0: Number | None = None,
        kappa: Number | None = None,
        edges: Literal["open", "periodic"] | None = None,
        start: Text | None = None,
        angle_spread: Number | None = None,
        velocities: Literal["checkerboard", "random", "rest", "thermal"] | None = None,
        speed: Number | None = None,
        velocity_spread: Number | None = None,
        time: Number | None = None,
        steps: Integer | None = None,
        dt: Text | None = None,
        no_collisions: bool = False,
        restitution: Number | None = None,
        paper: bool = False,
        temperature: Number | None = None,
        friction: Number | None = None,
        seed: Integer | None = None,
        log_every: Integer | None = None,
        trajectory_every: Integer | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        directory: Path,
        *,
        output: Path | None = None,
        frames: Path | None = None,
        most_frames: Integer | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
    ) -> Result:
        """Make a self-contained HTML page that plays a run in any browser.

        Parameters
        ----------
        directory
            Directory of a run
        output
            The page [default: lattice.html in the directory]
        frames
            Also write the frames as SVG files into this directory
        most_frames
            Maximum number of frames, evenly spaced over the run [default: 1000]
        threads
            Threads to use; 0 means all [default: 0]
        force
            Overwrite existing results
        progress
            Called as progress(done, total, unit) during the work.
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
        body: Path,
        *,
        axis: Literal["auto", "x", "y", "z"] | None = None,
        size: Literal["corners", "outside", "area"] | None = None,
        output: Path | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        file: Path,
        *,
        dt: Number | None = None,
        longest: Number | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        file: Path,
        *,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
        ns: Integer | None = None,
        r0: Number | None = None,
        steps: Integer | None = None,
        dt: Text | None = None,
        no_collisions: bool = False,
        seed: Integer | None = None,
        threads: Integer | None = None,
        force: bool = False,
        progress: Progress | None = None,
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
    directory: Path,
    *,
    output: Path | None = None,
    assembly: Path | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    input: Path,
    *,
    output: Path,
    frame: Text | None = None,
    salt: Quantity | None = None,
    replica: Integer | None = None,
    assembly: Path | None = None,
    values: Literal["charge", "hydropathy"] | None = None,
    gather: bool = False,
    script: Literal["chimerax", "pymol"] | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    replica
        Replica of a sweep, counted from 0 [default: 0]
    assembly
        Assembly file of a simulation, if it has moved
    values
        What the B factors of the residues hold; zero if omitted
    gather
        Shift copies by box lengths, so that a cluster across the border of a periodic box is in one piece
    script
        Also write a script that opens the file, shows surfaces and colours each copy
    threads
        Threads to use; 0 means all [default: 0]
    force
        Overwrite existing results
    progress
        Called as progress(done, total, unit) during the work.
    """
    return call(
        Result,
        ["export"],
        [input],
        {
            "--output": output,
            "--frame": frame,
            "--salt": salt,
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


def train(
    set: Path | None = None,
    *,
    output: Path,
    control: Text | None = None,
    short: bool = False,
    config: Path | None = None,
    ablate: bool = False,
    ablation_seeds: Integer | None = None,
    target: Literal["label", "space-group", "crystal-system", "point-group", "polar"] | None = None,
    least_samples: Integer | None = None,
    channels: Text | None = None,
    split_by: Literal["cluster", "sample"] | None = None,
    split_seed: Integer | None = None,
    fractions: Numbers | None = None,
    scaling: Literal["robust", "raw", "box-standardised"] | None = None,
    permutations: Integer | None = None,
    rotations: bool = False,
    widths: Integers | None = None,
    kernels: Integers | None = None,
    groups: Integer | None = None,
    average_only: bool = False,
    epochs: Integer | None = None,
    patience: Integer | None = None,
    logit_adjustment: Number | None = None,
    batch: Integer | None = None,
    learning_rate: Number | None = None,
    seed: Integer | None = None,
    device: Text | None = None,
    time_limit: Number | None = None,
    checkpoint_every: Number | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
        Also train on every subset of the channels
    ablation_seeds
        Number of seeds per subset [default: 3]
    target
        The quantity to predict [default: label]
    least_samples
        Classes with fewer samples become one class, "other" [default: 10]
    channels
        Input channels of the network, separated by commas [default: all]
    split_by
        Unit of the split [default: cluster]
    split_seed
        Seed of the split [default: that of --seed, or the one a configuration names]
    fractions
        Shares of training, validation and test [default: 0.7,0.15,0.15]
    scaling
        How channels are scaled [default: robust]
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
    run: Path,
    set: Path,
    *,
    output: Path | None = None,
    device: Text | None = None,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    set: Path,
    *,
    output: Path,
    trials: Integer | None = None,
    epochs: Integer | None = None,
    seed: Integer | None = None,
    vary_channels: bool = False,
    shard: Text | None = None,
    target: Literal["label", "space-group", "crystal-system", "point-group", "polar"] | None = None,
    least_samples: Integer | None = None,
    channels: Text | None = None,
    split_by: Literal["cluster", "sample"] | None = None,
    split_seed: Integer | None = None,
    fractions: Numbers | None = None,
    scaling: Literal["robust", "raw", "box-standardised"] | None = None,
    permutations: Integer | None = None,
    rotations: bool = False,
    device: Text | None = None,
    time_limit: Number | None = None,
    checkpoint_every: Number | None = None,
    threads: Integer | None = None,
    force: bool = False,
    client: Client | None = None,
    parts: int | None = None,
    progress: Progress | None = None,
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
        Also try subsets of the channels
    shard
        Run only a part of the trials, such as 2/8, alongside other processes in the same directory, until it
        has to wait for other parts; the command without this flag collects the results [default: 1/1]
    target
        The quantity to predict [default: label]
    least_samples
        Classes with fewer samples become one class, "other" [default: 10]
    channels
        Input channels of the network, separated by commas [default: all]
    split_by
        Unit of the split [default: cluster]
    split_seed
        Seed of the split [default: that of --seed, or the one a configuration names]
    fractions
        Shares of training, validation and test [default: 0.7,0.15,0.15]
    scaling
        How channels are scaled [default: robust]
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
    manifest: Path,
    output: Path,
    size: Integer | None = None,
    spacing: Text | None = None,
    channels: Text | None = None,
    orientation: Literal["random", "principal", "deposited"] | None = None,
    seed: Integer | None = None,
    potential: Literal["poisson-boltzmann", "debye-hueckel"] | None = None,
    salt: Quantity | None = None,
    temperature: Number | None = None,
    ph: Number | None = None,
    probe: Number | None = None,
    hydropathy_reach: Number | None = None,
    most_incomplete: Number | None = None,
    shard: Text | None = None,
    time_limit: Number | None = None,
    threads: Integer | None = None,
    force: bool = False,
    client: Client | None = None,
    parts: int | None = None,
    progress: Progress | None = None,
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
            "--salt": salt,
            "--temperature": temperature,
            "--ph": ph,
            "--probe": probe,
            "--hydropathy-reach": hydropathy_reach,
            "--most-incomplete": most_incomplete,
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
    inputs: Paths,
    *,
    output: Path,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
    assembly: Path | None = None,
    *,
    moves: Integer | None = None,
    energy: Literal["direct", "calibrated", "approximate", "none"] | None = None,
    tolerance: Number | None = None,
    part: Text | None = None,
    charges: Integers | None = None,
    seed: Integer | None = None,
    salt: Quantity | None = None,
    temperature: Number | None = None,
    permittivity: Number | None = None,
    bjerrum: Number | None = None,
    debye: Number | None = None,
    cutoff: Number | None = None,
    interaction: Literal["bare", "effective"] | None = None,
    inner_permittivity: Number | None = None,
    ion_radius: Number | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: Number | None = None,
    desolvation: bool = False,
    memory_limit: Integer | None = None,
    no_cache: bool = False,
    threads: Integer | None = None,
    force: bool = False,
    progress: Progress | None = None,
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
        How energies are computed [default: the fastest way that decides as the direct sum; without an
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
        Whether the charges of the bodies act, or their effective charges: those that give the potential
        around bodies of low permittivity that salt does not enter [default: bare]
    inner_permittivity
        Relative permittivity inside the bodies [default: 4]
    ion_radius
        Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2]
    contacts
        Attraction between residues, by a published scale [default: none]
    contact_strength
        What multiplies the attraction of the scale [default: 1]
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
            "--salt": salt,
            "--temperature": temperature,
            "--permittivity": permittivity,
            "--bjerrum": bjerrum,
            "--debye": debye,
            "--cutoff": cutoff,
            "--interaction": interaction,
            "--inner-permittivity": inner_permittivity,
            "--ion-radius": ion_radius,
            "--contacts": contacts,
            "--contact-strength": contact_strength,
            "--desolvation": desolvation,
            "--memory-limit": memory_limit,
            "--no-cache": no_cache,
            "--threads": threads,
            "--force": force,
        },
        progress,
    )
