"""Results of simulations: one, a sweep over salt, and several sweeps."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from . import _protomer
from ._assembly import Assembly, Trajectory, nearest
from ._chart import Axis, Chart, Curve, Level, salt_axis
from ._errors import unknown
from ._log import read_log
from ._result import Result, missing, numbers

Numbers = NDArray[np.float64]

_COLUMNS: list[dict[str, Any]] = _protomer.columns()
"""The columns of a log, as the program declares them."""
_KEYS: dict[str, str] = {column["name"].lower(): column["mean"] for column in _COLUMNS}
"""The attributes of a sweep and the columns of its table."""
_KEYS |= {key.lower(): key for column in _COLUMNS for key in (column["deviation"], column["error"]) if key}


def _replica(directory: Path, salt_molar: float, replica: int) -> Path:
    """The folder of a simulation."""
    return directory / f"salt_{salt_molar:.6f}M" / f"replica_{replica}"


def _assembly_of(directory: Path) -> Assembly:
    """The assembly that a run was begun with, as its record names it."""
    record = directory / "run.json"
    if not record.exists():
        raise missing(f"{directory} holds no run.json, which names the assembly; finish the work first", record)
    named = json.loads(record.read_text(encoding="utf-8")).get("details", {}).get("assembly")
    if named is None:
        raise missing(f"{record} names no assembly; read it with pm.Assembly.read", record)
    return Assembly.read(directory / named)


def _trajectory(path: Path) -> Trajectory:
    if not path.exists():
        raise missing(f"there is no {path}; a run writes it after its equilibration, unless trajectory_every is 0", path)
    return Trajectory(path)


class SimulationResult(Result):
    """Averages of one simulation.

    Examples
    --------
    >>> run = pm.simulate("ring.json", salt="100mM", output="run")     # doctest: +SKIP
    >>> run.trajectory()[-1].positions_angstrom                        # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "sweep.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("sweep", "simulation")

    @classmethod
    def _fields_of(cls, directory: Path) -> Any:
        fields = super()._fields_of(directory)
        replicas = [replica for row in fields["replicas"] for replica in row]
        if len(replicas) != 1:
            raise ValueError(f"{directory} holds {len(replicas)} simulations; use SweepResult.read")
        effective = fields["salts"][0].get("effective_bodies")
        return replicas[0] if effective is None else {**replicas[0], "effective_bodies": effective}

    @property
    def trajectories(self) -> list[Path]:
        """The file of its trajectory; none if it was run with `trajectory_every=0`."""
        return sorted(self.directory.glob("salt_*/replica_*/trajectory.gsd"))

    def trajectory(self) -> Trajectory:
        """Opens its trajectory.

        Returns
        -------
        Trajectory
            The poses of production, frame by frame

        Raises
        ------
        MissingFileError
            If it has none; also a `FileNotFoundError`

        Examples
        --------
        >>> run.trajectory().positions_angstrom.shape                  # doctest: +SKIP
        (20, 4, 3)
        """
        found = self.trajectories
        return _trajectory(found[0] if found else self.directory / "trajectory.gsd")

    def assembly(self, frame: int | None = None) -> Assembly:
        """The assembly that the run was begun with, or its bodies at a frame.

        Parameters
        ----------
        frame
            A frame of the trajectory, counted from zero, or from the end if negative; the start if left out

        Returns
        -------
        Assembly

        Raises
        ------
        MissingFileError
            If the assembly or the trajectory is not there; also a `FileNotFoundError`
        IndexError
            If there is no such frame

        Examples
        --------
        >>> pm.export(run.assembly(-1), output="end.cif")              # doctest: +SKIP
        """
        return _at(_assembly_of(self.directory), self.trajectory()[frame] if frame is not None else None)

    @property
    def log(self) -> dict[str, NDArray[Any]]:
        """The columns of its log, one entry per sampled sweep, (T,) each."""
        return read_log(self._file(""))

    def _chart(self, quantity: str | None) -> Chart:
        """A column of the log against the sweep, with its mean; the radius of gyration if left out."""
        log = self.log
        columns = {name: column for column in _COLUMNS for name in (column["quantity"], column["name"])}
        if quantity is not None and quantity not in columns:
            unknown("quantity", quantity, [column["quantity"] for column in _COLUMNS])
        column = columns[quantity] if quantity else _COLUMNS[0]
        average = self._fields.get(column["name"]) or {}
        level = [Level(average["mean"])] if average.get("mean") is not None else []
        return Chart(Axis("sweep"), Axis(column["title"]), [Curve(log["sweep"], log[column["name"]]), *level])


def _at(assembly: Assembly, frame: Any) -> Assembly:
    return assembly if frame is None else assembly.with_poses(frame.positions_angstrom, frame.orientations_wxyz)


class SweepResult(Result):
    """Stability against salt: one entry per salt concentration.

    The columns of its table are attributes, (S,) each: the mean over replicas under the name in the log (`r_g_angstrom`,
    `native_contacts`, `largest_cluster`, `energy_kt`, `contacts`, `bound_fraction`), the standard deviation between replicas with
    `sd` (`r_g_sd_angstrom`, `native_contacts_sd`, ...), and `r_g_se_angstrom`, the standard error from the replicas' own, which are
    corrected for autocorrelation. They are NaN in results of earlier versions that lack them.

    Examples
    --------
    >>> sweep = pm.SweepResult.read("stability")                       # doctest: +SKIP
    >>> sweep.half_salt_molar                                          # doctest: +SKIP
    >>> sweep.trajectory(salt_molar=0.05, replica=1)[-1]               # doctest: +SKIP
    """

    _FILE: ClassVar[str | None] = "sweep.json"
    _KINDS: ClassVar[tuple[str, ...]] = ("sweep", "simulation")

    def _folders(self) -> list[Path]:
        """The folders of the simulations, by salt and replica as in the settings."""
        settings = self._fields["settings"]
        return [
            _replica(self.directory, salt, replica) for salt in settings["salt_M"] for replica in range(settings["replicas"])
        ]

    def _folder(self, salt_molar: float | None, replica: int) -> Path:
        settings = self._fields["settings"]
        salts: list[float] = settings["salt_M"]
        if salt_molar is None:
            if len(salts) > 1:
                unknown("salt concentration", None, salts)
            salt_molar = salts[0]
        salt = salts[nearest(salts, salt_molar, "salt concentration (mol/L)")]
        if replica not in range(settings["replicas"]):
            unknown("replica", replica, range(settings["replicas"]))
        return _replica(self.directory, salt, replica)

    @property
    def trajectories(self) -> list[Path]:
        """The files of the trajectories, by salt and replica; without those that a run does not have."""
        paths = (folder / "trajectory.gsd" for folder in self._folders())
        return [path for path in paths if path.exists()]

    def trajectory(self, *, salt_molar: float | None = None, replica: int = 0) -> Trajectory:
        """Opens the trajectory of one simulation.

        Parameters
        ----------
        salt_molar
            Its salt concentration, mol/L; may be left out if there is only one
        replica
            Its replica, counted from zero

        Returns
        -------
        Trajectory
            The poses of production, frame by frame

        Raises
        ------
        KeyError
            If there is no such salt or replica; it lists those that exist
        MissingFileError
            If the simulation has no trajectory; also a `FileNotFoundError`

        Examples
        --------
        >>> sweep.trajectory(salt_molar=0.05).positions_angstrom.shape         # doctest: +SKIP
        (20, 4, 3)
        """
        return _trajectory(self._folder(salt_molar, replica) / "trajectory.gsd")

    def log(self, *, salt_molar: float | None = None, replica: int = 0) -> dict[str, NDArray[Any]]:
        """The log of one simulation.

        Parameters
        ----------
        salt_molar, replica
            As in `trajectory`

        Returns
        -------
        dict
            Its columns, one entry per sampled sweep, (T,) each

        Raises
        ------
        KeyError
            If there is no such salt or replica; it lists those that exist

        Examples
        --------
        >>> sweep.log(salt_molar=0.05)["energy_kT"].mean()             # doctest: +SKIP
        """
        return read_log(self._folder(salt_molar, replica))

    def assembly(self, frame: int | None = None, *, salt_molar: float | None = None, replica: int = 0) -> Assembly:
        """The assembly that the sweep was begun with, or its bodies at a frame of one simulation.

        Parameters
        ----------
        frame
            A frame of the trajectory, counted from zero, or from the end if negative; the start if left out
        salt_molar, replica
            As in `trajectory`

        Returns
        -------
        Assembly

        Raises
        ------
        KeyError
            If there is no such salt or replica; it lists those that exist
        MissingFileError
            If the assembly or the trajectory is not there; also a `FileNotFoundError`

        Examples
        --------
        >>> pm.export(sweep.assembly(-1, salt_molar=0.3), output="end.cif")    # doctest: +SKIP
        """
        opened = None if frame is None else self.trajectory(salt_molar=salt_molar, replica=replica)[frame]
        return _at(_assembly_of(self.directory), opened)

    def _column(self, name: str) -> Numbers:
        # Results of earlier versions lack some columns.
        return numbers([row.get(name) for row in self._fields["salts"]])

    @property
    def salt_molar(self) -> Numbers:
        """Salt concentrations, mol/L, (S,)."""
        return self._column("salt_M")

    def __getattr__(self, name: str) -> Any:
        if name in _KEYS:
            return self._column(_KEYS[name])
        return super().__getattr__(name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *_KEYS]

    def _chart(self, quantity: str | None) -> Chart:
        """A column against salt with the spread between replicas; the radius of gyration if left out."""
        columns = {column["quantity"]: column for column in _COLUMNS if column["deviation"]}
        if quantity is not None and quantity not in columns:
            unknown("quantity", quantity, columns)
        column = columns[quantity] if quantity else _COLUMNS[0]
        mean, deviation = self._column(column["mean"]), self._column(column["deviation"])
        curve = Curve(self.salt_molar * 1000.0, mean, error=deviation, marker="o")
        return Chart(salt_axis(self.salt_molar), Axis(column["title"]), [curve])


class CompareResult(Result):
    """Several sweeps side by side."""

    def _chart(self, quantity: str | None) -> Chart:
        """Radius of gyration, or the fraction of native contacts, against salt, a line for each sweep."""
        columns = {column["quantity"]: column for column in _COLUMNS[:2]}
        if quantity is not None and quantity not in columns:
            unknown("quantity", quantity, columns)
        column = columns[quantity] if quantity else _COLUMNS[0]
        sweeps = self._fields["sweeps"]
        curves = []
        for sweep in sweeps:
            salt, mean, deviation = (numbers(sweep[key]) for key in ("salt_M", column["mean"], column["deviation"]))
            curves.append(Curve(salt * 1000.0, mean, sweep["name"], deviation, marker="o"))
        salts = np.concatenate([numbers(sweep["salt_M"]) for sweep in sweeps])
        return Chart(salt_axis(salts), Axis(column["title"]), curves)
