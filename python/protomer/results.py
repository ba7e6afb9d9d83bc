"""The results of verbs. `plot` of each draws into axes of matplotlib, new ones if none are given, and returns them."""

from __future__ import annotations

from ._chart import Axis, Chart, Curve
from ._lattices import FrameworkResult, LatticeResult, LatticeSweepResult
from ._learning import PredictResult, TrainResult, TuneResult, VoxelizeResult
from ._pairs import PairResult, PotentialResult, ScatteringResult, StabilityResult
from ._phases import HardBodySweepResult, PhaseDiagramResult
from ._result import Result
from ._scores import ScoreResult
from ._sweeps import CompareResult, SimulationResult, SweepResult

__all__ = [
    "BenchResult",
    "CompareResult",
    "FrameworkResult",
    "HardBodySweepResult",
    "LatticeResult",
    "LatticeSweepResult",
    "PairResult",
    "PhaseDiagramResult",
    "PotentialResult",
    "PredictResult",
    "Result",
    "ScatteringResult",
    "SimulationResult",
    "ScoreResult",
    "StabilityResult",
    "SweepResult",
    "TrainResult",
    "TuneResult",
    "VoxelizeResult",
]


class BenchResult(Result):
    """Speeds of the engine."""

    def _chart(self, quantity: str | None) -> Chart:
        """Trial moves per CPU-second against the charges of a body, a line for each way to compute energies."""
        rows = self._fields.get("charges") or []
        if not rows:
            raise ValueError('only the table of charges can be drawn; call pm.bench without an assembly, with part=["charges"]')
        curves = []
        for energy in dict.fromkeys(row["energy"] for row in rows):
            own = [row for row in rows if row["energy"] == energy]
            rates = [row["moves_per_cpu_second"] for row in own]
            curves.append(Curve([row["charges"] for row in own], rates, energy, marker="o"))
        return Chart(Axis("charges of a body", log=True), Axis("trial moves per CPU-second", log=True), curves)
