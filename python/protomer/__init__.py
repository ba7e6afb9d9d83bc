"""protomer: protein structures to rigid bodies, bodies to assemblies, assemblies to stability.

>>> import protomer as pm
>>> pm.ingest("5pti.cif.gz", output="bodies", ph=7.4)          # doctest: +SKIP
>>> body = pm.Body.read("bodies/5pti.body")                    # doctest: +SKIP
>>> body.net_charge_e, body.vertices_angstrom.shape            # doctest: +SKIP
>>> assembly = pm.Assembly.read("ring.json")                   # doctest: +SKIP
>>> pm.sweep(assembly, salt_molar=[0.03, 0.3], output="sweep") # doctest: +SKIP

Every verb of the command line is a function with the same flags as keywords (``pm.sweep(..., salt="10mM..300mM/8")``);
verbs with subcommands are objects (``pm.assemble.ring(...)``, ``pm.lattice.run(...)``). Results are objects with
the fields that ``--json`` prints. Lengths are in Å, energies in kT, charges in e, salt in mol/L.
"""

from ._protomer import (
    CheckpointError,
    ConfigError,
    ConvergenceError,
    GeometryError,
    MissingFileError,
    ParseError,
    ProtomerError,
    StoppedError,
    __version__,
)
from ._errors import PartialError, UnknownNameError
from ._verbs import *  # noqa: F403
from ._verbs import __all__ as _verb_names
from ._assembly import Assembly, Frame, Trajectory
from ._body import Body
from . import dynamics, structure
from ._sets import VoxelSet, VoxelStream
from ._log import read_log
from .simulation import AssemblySimulation, ContactDynamics, HardBodies, LatticeSimulation, Simulation
from .results import *  # noqa: F403
from .results import __all__ as _result_names

__all__ = [
    "Assembly",
    "AssemblySimulation",
    "Body",
    "CheckpointError",
    "ConfigError",
    "ContactDynamics",
    "ConvergenceError",
    "Frame",
    "GeometryError",
    "HardBodies",
    "LatticeSimulation",
    "MissingFileError",
    "ParseError",
    "PartialError",
    "ProtomerError",
    "Simulation",
    "StoppedError",
    "Trajectory",
    "UnknownNameError",
    "VoxelSet",
    "VoxelStream",
    "__version__",
    "dynamics",
    "read_log",
    "structure",
    *_result_names,
    *_verb_names,
]
