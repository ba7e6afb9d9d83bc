"""Types of the verbs as functions. Written by the program from its table of flags; do not edit:
UPDATE_REFERENCE=1 cargo test -p protomer-cli --test documentation
"""

# ruff: noqa: E501
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from distributed import Client
from numpy.typing import NDArray

from ._assembly import Assembly
from ._body import Body
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
    ScoreResult,
    SimulationResult,
    StabilityResult,
    SweepResult,
    TrainResult,
    TuneResult,
    VoxelizeResult,
)

__all__ = [
    "fetch",
    "ingest",
    "surface",
    "body",
    "assemble",
    "candidates",
    "inspect",
    "export",
    "stability",
    "simulate",
    "sweep",
    "residues",
    "reweight",
    "compare",
    "pair",
    "binding",
    "score",
    "scattering",
    "potential",
    "titrate",
    "voxelize",
    "merge",
    "train",
    "tune",
    "predict",
    "lattice",
    "framework",
    "shape",
    "hpmc",
    "free_energy",
    "md",
    "phase_diagram",
    "report",
    "bench",
]

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
    network."""

def ingest(
    inputs: Path | str | Sequence[Path | str],
    *,
    output: Path | str,
    name: str | float | Sequence[str | float] | None = None,
    chain: str | float | Sequence[str | float] | None = None,
    residues: str | float | Sequence[str | float] | None = None,
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
    protonation: Literal["water", "structure"] | None = None,
    anion_binding: float | str | None = None,
    protonation_salt: float | str | None = None,
    titratable: bool = False,
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
    """Turn structure files (PDB, mmCIF, PQR, each also gzipped) into bodies: surface mesh, charges,
    hydropathy."""

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
    """Compute the solvent-excluded surface of a structure, a PQR, a body, or an .xyzr file (x y z radius
    per line): mesh, exact area and volume. Cavities are kept by default."""

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
    """Make a body from a mesh and charges (PQR, or whitespace-separated x y z charge). Coordinates are
    kept: the body's origin is that of the files."""

class _Assemble:
    """Build assemblies: from the chains of a structure, as a ring or a stack of two rings, or at random."""

    def structure(
        self,
        inputs: Path | str | Sequence[Path | str],
        *,
        output: Path | str,
        chain: str | float | Sequence[str | float] | None = None,
        residues: str | float | Sequence[str | float] | None = None,
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
        protonation: Literal["water", "structure"] | None = None,
        anion_binding: float | str | None = None,
        protonation_salt: float | str | None = None,
        titratable: bool = False,
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
        """Decompose a structure: each chain becomes a body, or each of several files in one frame;
        identical ones become one body, and each copy a pose."""

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
        """A ring of bodies, or a stack of two rings, closed to contact. Bodies alternate around the ring."""

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
        """Bodies at random positions and orientations in a periodic box, without overlaps."""

assemble: _Assemble

def candidates(
    bodies: Path | str | Body | Sequence[Path | str | Body],
    *,
    ring: int | str | None = None,
    stack: int | str | None = None,
    symmetry: Literal["none", "cyclic", "dihedral"] | None = None,
    gap: float | str | None = None,
    box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    output: Path | str | None = None,
    tilt: str | float | Sequence[str | float] | None = None,
    spin: str | float | Sequence[str | float] | None = None,
    refine: int | str | None = None,
    group: Literal["tetrahedral", "octahedral", "icosahedral"] | None = None,
    samples: int | str | None = None,
    seed: int | str | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
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
    ions: Literal["linear", "boltzmann"] | None = None,
    regulation: bool = False,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Enumerate the distinct up/down arrangements of bodies in a ring or a stack of two rings, up to the
    symmetry of the stack, and write each as an assembly closed to contact; or search their tilts and
    spins, or cages of a cubic group, for low energies."""

def inspect(
    assembly: Path | str | Assembly,
    *,
    energy: Literal["direct", "certified", "calibrated", "approximate", "none"] | None = None,
    tolerance: float | str | None = None,
    contact_gap: float | str | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
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
    ions: Literal["linear", "boltzmann"] | None = None,
    regulation: bool = False,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Inspect an assembly: overlaps, pair energies, radius of gyration."""

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
    schema: Literal["2.0", "1.4"] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Write an assembly, or a frame of a simulation, as a PDB or mmCIF file with all atoms of the bodies,
    and a script for a viewer. Chains get new identifiers; a table in the file says which copy and chain
    each was. An output that ends in .gsd is a trajectory in another version of its schema."""

def stability(
    inputs: Path | str | Assembly | Sequence[Path | str | Assembly],
    *,
    body: str | float | Sequence[str | float] | None = None,
    output: Path | str | None = None,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    concentration: str | float | Sequence[str | float] | None = None,
    ph: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    protonation: Literal["water", "structure"] | None = None,
    anion_binding: float | str | None = None,
    temperature: float | str | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    contact_gap: float | str | None = None,
    most_parts: int | str | None = None,
    limit: float | str | None = None,
    live_states: int | str | None = None,
    runs: int | str | None = None,
    way: Literal["mass-action", "biased"] | None = None,
    windows: int | str | None = None,
    sweeps: int | str | None = None,
    seed: int | str | None = None,
    chain: str | float | Sequence[str | float] | None = None,
    residues: str | float | Sequence[str | float] | None = None,
    assembly: str | float | Sequence[str | float] | None = None,
    altloc: str | float | Sequence[str | float] | None = None,
    keep_ligands: bool = False,
    keep_waters: bool = False,
    keep_hydrogens: bool = False,
    keep_nucleic_acids: bool = False,
    missing: Literal["keep", "skip", "fail"] | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    structure_model: int | str | None = None,
    shard: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> StabilityResult:
    """Say how much of an assembly there is at equilibrium, up to which salt: yields of the whole and of
    its parts by mass action over their partition functions. The same command continues work that was
    stopped."""

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
    state: str | float | Sequence[str | float] | None = None,
    frame: int | str | None = None,
    config: Path | str | None = None,
    sweeps: int | str | None = None,
    equilibration: int | str | None = None,
    cluster_moves: int | str | None = None,
    binding_moves: int | str | None = None,
    proton_moves: int | str | None = None,
    depletant_radius: float | str | None = None,
    depletant_fraction: float | str | None = None,
    seed: int | str | None = None,
    contact_gap: float | str | None = None,
    log_every: int | str | None = None,
    trajectory_every: int | str | None = None,
    energy: Literal["direct", "certified", "calibrated", "approximate", "none"] | None = None,
    tolerance: float | str | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    ions: Literal["linear", "boltzmann"] | None = None,
    regulation: bool = False,
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
    """Run one simulation of an assembly at one salt concentration. The same command continues it."""

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
    proton_moves: int | str | None = None,
    depletant_radius: float | str | None = None,
    depletant_fraction: float | str | None = None,
    seed: int | str | None = None,
    contact_gap: float | str | None = None,
    log_every: int | str | None = None,
    trajectory_every: int | str | None = None,
    energy: Literal["direct", "certified", "calibrated", "approximate", "none"] | None = None,
    tolerance: float | str | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    ions: Literal["linear", "boltzmann"] | None = None,
    regulation: bool = False,
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
    surviving contacts against salt. The same command continues a sweep that was stopped."""

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
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    interaction: Literal["bare", "effective", "response"] | None = None,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    ions: Literal["linear", "boltzmann"] | None = None,
    regulation: bool = False,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Share out the energy of an assembly by residues and pairs of residues, averaged over the frames of a
    sweep or a simulation: which residues hold it together, which touch, and what single exchanges of
    charge would change. Where effective charges interact, energies are shared out by the plain charges
    of the bodies. Where runs from the assembly and from a fluid disagree, only frames count in which
    more than half of the contacts are left."""

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
    """Weight the frames of a sweep at all salts together into curves between the salts that were
    simulated, with errors, and at other concentrations of bodies by mass action: where half of the
    contacts are left."""

def compare(
    sweeps: Path | str | Sequence[Path | str],
    *,
    output: Path | str,
    title: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> CompareResult:
    """Draw several finished sweeps in one figure; the legend names the directories."""

def pair(
    first: Path | str | Body,
    second: Path | str | Body | None = None,
    *,
    output: Path | str | None = None,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    ph: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    protonation: Literal["water", "structure"] | None = None,
    anion_binding: float | str | None = None,
    interaction: Literal["hard", "bare", "effective", "response"] | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    relative_error: float | str | None = None,
    b22_error: float | str | None = None,
    most_directions: int | str | None = None,
    seed: int | str | None = None,
    contact_gap: float | str | None = None,
    core: Literal["surface", "beads"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    inner_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    ions: Literal["linear", "boltzmann"] | None = None,
    regulation: bool = False,
    temperature: float | str | None = None,
    permittivity: float | str | None = None,
    bjerrum: float | str | None = None,
    debye: float | str | None = None,
    cutoff: float | str | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    no_cache: bool = False,
    shard: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> PairResult:
    """Compute the thermodynamics of two bodies over a grid of salt and pH: second virial coefficient,
    potential of mean force, dissociation constant, bound poses. The same command continues work that
    was stopped."""

def binding(
    receptor: Path | str | Body,
    ligand: Path | str | Body | None = None,
    *,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    body: str | float | Sequence[str | float] | None = None,
    ph: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    protonation: Literal["water", "structure"] | None = None,
    anion_binding: float | str | None = None,
    temperature: float | str | None = None,
    no_kd: bool = False,
    seed: int | str | None = None,
    exchanges: bool = False,
    proton_uptake: bool = False,
    spacing: float | str | None = None,
    margin: float | str | None = None,
    inner_permittivity: float | str | None = None,
    outer_permittivity: float | str | None = None,
    ion_radius: float | str | None = None,
    ions: Literal["linear", "boltzmann"] | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    chain: str | float | Sequence[str | float] | None = None,
    residues: str | float | Sequence[str | float] | None = None,
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
    """Estimate how strongly a complex of known pose binds, and the effect of salt, pH and charges:
    affinity from its contacts, charge part by the Poisson-Boltzmann equation, dissociation constant by
    integration over the poses nearby."""

def score(
    source: Path | str,
    *,
    output: Path | str,
    body: str | float | Sequence[str | float] | None = None,
    crystal: bool = False,
    columns: str | float | Sequence[str | float] | None = None,
    salt: str | Sequence[str] | None = None,
    salt_molar: float | Sequence[float] | NDArray[np.float64] | None = None,
    ph: float | str | None = None,
    protonation: Literal["water", "structure"] | None = None,
    anion_binding: float | str | None = None,
    concentration: float | str | None = None,
    temperature: float | str | None = None,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    spacing: float | str | None = None,
    seed: int | str | None = None,
    strict: bool = False,
    shard: str | float | Sequence[str | float] | None = None,
    chain: str | float | Sequence[str | float] | None = None,
    residues: str | float | Sequence[str | float] | None = None,
    assembly: str | float | Sequence[str | float] | None = None,
    altloc: str | float | Sequence[str | float] | None = None,
    keep_ligands: bool = False,
    keep_waters: bool = False,
    keep_hydrogens: bool = False,
    keep_nucleic_acids: bool = False,
    missing: Literal["keep", "skip", "fail"] | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    structure_model: int | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> ScoreResult:
    """Score many complexes or designs: a folder or a table of structures in, a table with a row for each
    out. The same command continues work that was stopped, and adds complexes and columns."""

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
    """Compute the scattering of light and X-rays by an assembly or by the trajectories of a run: cluster
    sizes, hydrodynamic radii as dynamic light scattering averages them, S(q) of the centres, P(q) of
    the bodies and I(q) of the whole."""

def potential(
    input: Path | str | Body,
    *,
    salt: str | None = None,
    salt_molar: float | None = None,
    model: Literal["poisson-boltzmann", "debye-hueckel"] | None = None,
    ions: Literal["linear", "boltzmann"] | None = None,
    valence: str | float | Sequence[str | float] | None = None,
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
    """Solve the Poisson-Boltzmann equation around a structure, PQR or body: potential in kT/e and
    solvation energy."""

def titrate(
    input: Path | str,
    *,
    salt: str | None = None,
    salt_molar: float | None = None,
    ph: str | float | Sequence[str | float] | None = None,
    temperature: float | str | None = None,
    inner_permittivity: float | str | None = None,
    anion_binding: float | str | None = None,
    output: Path | str | None = None,
    chain: str | float | Sequence[str | float] | None = None,
    residues: str | float | Sequence[str | float] | None = None,
    model: int | str | None = None,
    assembly: str | float | Sequence[str | float] | None = None,
    altloc: str | float | Sequence[str | float] | None = None,
    keep_ligands: bool = False,
    keep_waters: bool = False,
    keep_hydrogens: bool = False,
    keep_nucleic_acids: bool = False,
    missing: Literal["keep", "skip", "fail"] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Compute the pKa values of a structure with the Poisson-Boltzmann equation: what shifts them, the net
    charge against pH, the isoelectric point."""

def voxelize(
    *,
    manifest: Path | str,
    output: Path | str,
    size: int | str | None = None,
    spacing: str | float | Sequence[str | float] | None = None,
    channels: str | float | Sequence[str | float] | None = None,
    interface_reach: float | str | None = None,
    orientation: Literal["random", "principal", "deposited"] | None = None,
    seed: int | str | None = None,
    potential: Literal["poisson-boltzmann", "debye-hueckel"] | None = None,
    salt: str | None = None,
    salt_molar: float | None = None,
    temperature: float | str | None = None,
    ph: float | str | None = None,
    protonation: Literal["water", "structure"] | None = None,
    anion_binding: float | str | None = None,
    probe: float | str | None = None,
    hydropathy_reach: float | str | None = None,
    most_incomplete: float | str | None = None,
    bodies: Path | str | None = None,
    density: float | str | None = None,
    strict: bool = False,
    shard: str | float | Sequence[str | float] | None = None,
    time_limit: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> VoxelizeResult:
    """Turn the structures of a manifest into a set of sparse voxel grids, a zarr v3 group: surface,
    potential, hydropathy."""

def merge(
    inputs: Path | str | Sequence[Path | str],
    *,
    output: Path | str,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Merge sets of voxel grids with the same settings; the parts of one manifest give the same set as a
    single run."""

def train(
    set: Path | str | None = None,
    *,
    output: Path | str,
    control: str | float | Sequence[str | float] | None = None,
    short: bool = False,
    config: Path | str | None = None,
    weights_from: Path | str | None = None,
    ablate: bool = False,
    ablation_seeds: int | str | None = None,
    labels: Path | str | None = None,
    label_column: str | float | Sequence[str | float] | None = None,
    target: Literal["label", "space-group", "crystal-system", "point-group", "polar", "number"] | None = None,
    least_samples: int | str | None = None,
    number_classes: int | str | None = None,
    loss: Literal["cross-entropy", "normal"] | None = None,
    channels: str | float | Sequence[str | float] | None = None,
    split_by: Literal["cluster", "sample"] | None = None,
    split_seed: int | str | None = None,
    fractions: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    training_share: float | str | None = None,
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
    """Train a network on a set of voxels, or on a control. The same command continues it."""

def tune(
    set: Path | str,
    *,
    output: Path | str,
    trials: int | str | None = None,
    epochs: int | str | None = None,
    seed: int | str | None = None,
    vary_channels: bool = False,
    shard: str | float | Sequence[str | float] | None = None,
    labels: Path | str | None = None,
    label_column: str | float | Sequence[str | float] | None = None,
    target: Literal["label", "space-group", "crystal-system", "point-group", "polar", "number"] | None = None,
    least_samples: int | str | None = None,
    number_classes: int | str | None = None,
    loss: Literal["cross-entropy", "normal"] | None = None,
    channels: str | float | Sequence[str | float] | None = None,
    split_by: Literal["cluster", "sample"] | None = None,
    split_seed: int | str | None = None,
    fractions: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
    training_share: float | str | None = None,
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
    """Search for the network that predicts best: blocks, kernels, channels, learning rate. The same
    command continues it."""

def predict(
    run: Path | str,
    set: Path | str,
    *,
    output: Path | str | None = None,
    labels: Path | str | None = None,
    label_column: str | float | Sequence[str | float] | None = None,
    device: str | float | Sequence[str | float] | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> PredictResult:
    """Apply a network trained by 'protomer train' to every sample of a set of voxels: class,
    probabilities, and scores where the labels are known."""

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
        """Two-dimensional crystals of rigid squares whose corners are joined by rigid rods."""

    def run(
        self,
        config: Path | str | None = None,
        *,
        output: Path | str,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        ns: int | str | None = None,
        angle_potential: Path | str | None = None,
        opening_potential: Path | str | None = None,
        rows: int | str | None = None,
        columns: int | str | None = None,
        r0: float | str | None = None,
        kappa: float | str | None = None,
        edges: Literal["open", "periodic"] | None = None,
        cell: Literal["fixed", "flexible"] | None = None,
        cell_mass: float | str | None = None,
        state: str | float | Sequence[str | float] | None = None,
        frame: int | str | None = None,
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
        stress_xx: float | str | None = None,
        stress_yy: float | str | None = None,
        seed: int | str | None = None,
        log_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> LatticeResult:
        """Run one lattice. The same command continues it."""

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
        shard: str | float | Sequence[str | float] | None = None,
        locked_within: float | str | None = None,
        ns: int | str | None = None,
        angle_potential: Path | str | None = None,
        opening_potential: Path | str | None = None,
        rows: int | str | None = None,
        columns: int | str | None = None,
        r0: float | str | None = None,
        kappa: float | str | None = None,
        edges: Literal["open", "periodic"] | None = None,
        cell: Literal["fixed", "flexible"] | None = None,
        cell_mass: float | str | None = None,
        state: str | float | Sequence[str | float] | None = None,
        frame: int | str | None = None,
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
        stress_xx: float | str | None = None,
        stress_yy: float | str | None = None,
        seed: int | str | None = None,
        log_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        client: Client | str | None = None,
        parts: int | None = None,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> LatticeSweepResult:
        """Run lattices of several rod lengths and κ, once per seed, on all threads, with tables and
        figures. The same command continues a sweep that was stopped."""

    def elastic(
        self,
        directories: Path | str | Sequence[Path | str],
        *,
        discard: float | str | None = None,
        blocks: int | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Compliances and Poisson's ratio of runs in a heat bath: from the fluctuations of the strain in
        each run, and from the response of runs that differ in their stress."""

    def divergence(
        self,
        directory: Path | str,
        *,
        column: str | float | Sequence[str | float] | None = None,
        dimension: int | str | None = None,
        delay: int | str | None = None,
        window: int | str | None = None,
        horizon: int | str | None = None,
        fit_from: int | str | None = None,
        fit_to: int | str | None = None,
        radius: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """The maximal Lyapunov exponent of a run from the time series of a column of its log, as
        Rosenstein or as Kantz estimate it."""

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
        """Make a self-contained HTML page that plays a run in any browser."""

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
        """The square that represents a body with a symmetry axis, as part of a configuration."""

    def joint(
        self,
        body: Path | str,
        *,
        rod: str | float | Sequence[str | float],
        axis: Literal["auto", "x", "y", "z"] | None = None,
        size: Literal["corners", "outside", "area"] | None = None,
        turned_over: bool = False,
        openings: int | str | None = None,
        directions: int | str | None = None,
        interaction: Literal["bare", "effective"] | None = None,
        salt: str | None = None,
        salt_molar: float | None = None,
        temperature: float | str | None = None,
        permittivity: float | str | None = None,
        bjerrum: float | str | None = None,
        debye: float | str | None = None,
        cutoff: float | str | None = None,
        output: Path | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """The potential of mean force of two copies of a body that a rod ties at their corners, against
        the angle between them: a table for --angle-potential."""

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
        """Integrate the state of a file (JSON: ns, r0, kappa, s0, v0, times): without collisions to the
        listed times, and up to the first contact and through it."""

    def respond(
        self,
        file: Path | str,
        *,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """The elastic impact at the contact state of a file (JSON: ns, r0, first_collision with s and v)."""

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
        velocities."""

lattice: _Lattice

class _Framework:
    """Elastic constants, mechanisms and deformation of a periodic network of rods and hinges: from a
    builder, or custom, from a TOML file (--write gives an example)."""

    def __call__(
        self,
        file: Path | str | None = None,
        *,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        builder, or custom, from a TOML file (--write gives an example)."""

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
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Hexagonal honeycomb: ribs h along z, ribs l at the angle theta to them; re-entrant below 90
        degrees."""

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
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Squares that share corners and rotate alternately."""

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
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Equilateral triangles that share corners and rotate alternately."""

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
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Arrowheads: long ribs at the outer and short ribs at the inner angle to z."""

    def missing_rib(
        self,
        *,
        angle: float | str,
        ks: float | str,
        kh: float | str,
        arm: float | str | None = None,
        rib: float | str | None = None,
        cross_kh: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Missing-rib foam: crosses turned out of the axes, whose arms are joined by ribs at elbows."""

    def stars(
        self,
        *,
        angle: float | str,
        ks: float | str,
        kh: float | str,
        points: int | str | None = None,
        side: float | str | None = None,
        rib: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Stars with four or six points, joined by ribs from point to point."""

    def chiral(
        self,
        *,
        ks: float | str,
        kh: float | str,
        spokes: int | str | None = None,
        radius: float | str | None = None,
        ligament: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Chiral honeycomb: rigid wheels, joined by ligaments that touch them."""

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
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """The lattice of squares whose corners are joined by rods."""

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
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Face-centred cubic net of nearest-neighbour rods."""

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
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Diamond net of nearest-neighbour rods, hinged between all rods at a node."""

    def alpha_cristobalite(
        self,
        *,
        ks: float | str,
        kh: float | str,
        scale: float | str | None = None,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Tetrahedra of alpha-cristobalite, from its crystal structure."""

    def tables(
        self,
        *,
        na: float | str | None = None,
        cells: str | float | Sequence[str | float] | None = None,
        thickness: str | float | Sequence[str | float] | None = None,
        relax: bool = False,
        fixed_cell: bool = False,
        flexure: float | str | None = None,
        segments: int | str | None = None,
        scan: str | float | Sequence[str | float] | None = None,
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
        """Tables 2 to 4 of Grima et al., Mol. Simul. 31, 925 (2005), printed and recomputed."""

framework: _Framework

class _Shape:
    """Measure a convex shape, rounded or not: volume, surface, integrated mean curvature and second virial
    coefficient, exactly. The shape is that of a file: the corners of a convex polygon (text with two
    columns), the convex hull of points in space (three columns), or a convex mesh, such as an .off
    file; concave ones are refused. One point with a rounding is a disk or a ball. Or it has a name:
    tetrahedron, cube, octahedron, dodecahedron, icosahedron, truncated-octahedron, rhombic-dodecahedron
    (edges of length 1), truncated-tetrahedron:T (T from 0, the tetrahedron with edges of length 1, to
    1, the octahedron; 2/3 is Archimedean), cuboid:A,B,C, prism:N,HEIGHT (edges of length 1), polygon:N
    (area 1), ellipse:A,B and ellipsoid:A,B,C (half axes)."""

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
        """Measure a convex shape, rounded or not: volume, surface, integrated mean curvature and second
        virial coefficient, exactly. The shape is that of a file: the corners of a convex polygon (text
        with two columns), the convex hull of points in space (three columns), or a convex mesh, such as
        an .off file; concave ones are refused. One point with a rounding is a disk or a ball. Or it has
        a name: tetrahedron, cube, octahedron, dodecahedron, icosahedron, truncated-octahedron,
        rhombic-dodecahedron (edges of length 1), truncated-tetrahedron:T (T from 0, the tetrahedron
        with edges of length 1, to 1, the octahedron; 2/3 is Archimedean), cuboid:A,B,C, prism:N,HEIGHT
        (edges of length 1), polygon:N (area 1), ellipse:A,B and ellipsoid:A,B,C (half axes)."""

    def contact(
        self,
        pairs: Path | str,
        *,
        potential: Literal["contact", "face-sum", "smooth"] | None = None,
        central: Literal["none", "conservative", "printed", "gradient"] | None = None,
        attraction: float | str | None = None,
        attraction_cut_off: float | str | None = None,
        map: Path | str | None = None,
        map_reach: float | str | None = None,
        map_points: int | str | None = None,
        map_levels: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Print the repulsion of pairs of convex shapes: energy, force and torques of each pair. PAIRS is
        a JSON list of objects: `a` and `b` (file or name of a shape, as for `shape`), `position` (of
        the centroid of b; that of a is at the origin), `orientation_a` and `orientation_b` (an angle in
        radians for polygons, a quaternion w x y z for polyhedra; left out: not turned). The repulsion
        has the length 0.15 sigma, where sigma is the mean diameter of the balls about the centroids
        that fit in, and the energy 1 at that distance; energies are in units of epsilon."""

    def overlap_volume(
        self,
        pairs: Path | str,
        *,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Print the volume that two convex shapes, swept by a depletant, have in common, for each pair.
        PAIRS is a JSON list of objects: `a` and `b` (file or name of a shape, as for `shape`),
        `position` (of the centroid of b; that of a is at the origin), `orientation_a` and
        `orientation_b` (an angle in radians for polygons, a quaternion w x y z for polyhedra; left out:
        not turned), `depletant_radius`, and `rounding_a` and `rounding_b` (radius of the ball that
        rounds each shape). Penetrable depletants of number density n in the reservoir give the pair the
        energy -n kT times this volume."""

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
        exactly; and if requested, the third one, and the second one among depletants. Shapes are those
        of `shape`. A concave body is given by its convex pieces, joined by + as for `hpmc`; its
        coefficients are sampled with --triples."""

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
        approximation for dense fluids. For crystals, see `hpmc free-volume`."""

shape: _Shape

class _Hpmc:
    """Hard convex bodies in a periodic box, with penetrable depletants."""

    def run(
        self,
        *,
        shape: str | float | Sequence[str | float],
        output: Path | str,
        share: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        rounding: float | str | None = None,
        spread: float | str | None = None,
        swaps: int | str | None = None,
        bodies: int | str | None = None,
        start: str | float | Sequence[str | float] | None = None,
        frame: int | str | None = None,
        turn: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        gravity: float | str | None = None,
        field: Path | str | None = None,
        potential: Path | str | None = None,
        depletants: str | float | Sequence[str | float] | None = None,
        equilibration: int | str | None = None,
        sweeps: int | str | None = None,
        sample_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        insertions: int | str | None = None,
        points: int | str | None = None,
        packing_fraction: float | str | None = None,
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
        """Run hard bodies in a periodic box. The same command continues the run; more sweeps extend it.
        Bodies are placed at random and compressed to the packing fraction, or stand on the sites of a
        crystal. In the equilibration the steps are tuned; then the pressure is measured by trial
        compressions, the free volume of the depletants by random points, and the chemical potential by
        insertion."""

    def sweep(
        self,
        *,
        shape: str | float | Sequence[str | float],
        output: Path | str,
        share: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        rounding: float | str | None = None,
        spread: float | str | None = None,
        swaps: int | str | None = None,
        bodies: int | str | None = None,
        start: str | float | Sequence[str | float] | None = None,
        frame: int | str | None = None,
        turn: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        box: float | str | Sequence[float | str] | NDArray[np.float64] | None = None,
        gravity: float | str | None = None,
        field: Path | str | None = None,
        potential: Path | str | None = None,
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
        shard: str | float | Sequence[str | float] | None = None,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        client: Client | str | None = None,
        parts: int | None = None,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> HardBodySweepResult:
        """Run hard bodies at several packing fractions or pressures, once per seed, on all threads: the
        equation of state as a table and a figure. The same command continues a sweep; more sweeps,
        packing fractions, pressures and seeds extend it. Over packing fractions of a fluid, the excess
        free energy is integrated from no bodies."""

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
        """Print the free volume of depletants in a perfect crystal whose bodies do not move. Lines through
        the unit cell are cut exactly by the bodies, each swept by a depletant; the error is that of
        grids of lines that are shifted against each other. For crystals that move, give `run` a start
        and depletants."""

hpmc: _Hpmc

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
    share: Literal["errors", "even"] | None = None,
    shard: str | float | Sequence[str | float] | None = None,
    seed: int | str | None = None,
    time_limit: float | str | None = None,
    checkpoint_every: float | str | None = None,
    threads: int | str | None = None,
    force: bool = False,
    client: Client | str | None = None,
    parts: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Compute the free energy of a crystal of hard bodies. The same command continues the run; more sweeps
    extend it. Springs hold the bodies and their orientations to the sites. With the strongest springs
    the free energy is exact; the difference to none is integrated over 21 strengths, and sweeps go to
    those whose errors count most (Frenkel and Ladd). The free energy is A/(N kT) at this number of
    bodies, for a thermal wavelength of one in the unit of the shape and an integral of one over all
    orientations. The excess is what it is more than that of an ideal gas of the same density, ln ρ - 1."""

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
        fixed_orientations: bool = False,
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
        start: str | float | Sequence[str | float] | None = None,
        frame: int | str | None = None,
        compress_from: float | str | None = None,
        compress_steps: int | str | None = None,
        equilibrate_steps: int | str | None = None,
        preparation_time_step: float | str | None = None,
        log_every: int | str | None = None,
        trajectory_every: int | str | None = None,
        pair_potential: Path | str | None = None,
        field: Path | str | None = None,
        time_limit: float | str | None = None,
        checkpoint_every: float | str | None = None,
        threads: int | str | None = None,
        force: bool = False,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Result:
        """Follow convex bodies in motion, from a wide lattice through a slow compression. The same command
        continues a run. Bodies repel each other between the points that --potential names (energy
        epsilon at the distance sigma_c = 0.15 sigma; sigma is the mean diameter of the balls about the
        centroids that fit in). Units: epsilon, the length that gives a body area or volume one, density
        one. The packing fraction counts bodies with a layer of sigma_c/2."""

md: _Md

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
    `--size-ratio` and `--reservoir`, hard spheres among penetrable depletants by free volume theory:
    the fluid of Carnahan and Starling, the cell model of the crystal, free volumes of scaled particle
    theory. With `--fluid`, `--crystal` and `--free-energy`, any bodies, by what `hpmc sweep` and
    `free-energy` measured, with errors; with `--reservoir` among the depletants whose free volumes were
    measured. With `--branch`, tables of free energies: two columns, a packing fraction (or density) and
    the free energy per volume, one file per phase. Pressures are in units of kT over the volume of a
    body, chemical potentials in kT; with tables both are in the units of the tables."""

def report(
    directory: Path | str,
    *,
    output: Path | str | None = None,
    assembly: Path | str | Assembly | None = None,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Make a self-contained HTML page of a directory of results: figures with their numbers, rotatable
    bodies, animated lattices. The page loads nothing."""

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
    ions: Literal["linear", "boltzmann"] | None = None,
    regulation: bool = False,
    model: Literal["natural-1", "solution-1", "solution-2", "thesis"] | None = None,
    contacts: Literal["none", "calvados3", "kim-hummer"] | None = None,
    contact_strength: float | str | None = None,
    desolvation: bool = False,
    memory_limit: int | str | None = None,
    no_cache: bool = False,
    threads: int | str | None = None,
    force: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> BenchResult:
    """Measure trial moves per CPU-second on an assembly, from the state it is in, and hash the decisions
    made. Without an assembly: measure on states that the program makes itself, and print a table of
    each energy mode's rate against the number of charges, of the parts of a move, of the cost against
    the number of bodies, and of replicas on several threads. That takes a few minutes."""
