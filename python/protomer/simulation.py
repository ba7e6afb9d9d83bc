"""Simulations in memory, for loops, observables and schedules of one's own.

>>> import protomer as pm
>>> squares = pm.HardBodies("polygon:4", bodies=100, packing_fraction=0.5)
>>> squares.run(50)
>>> squares.positions.shape, squares.sweep
((100, 2), 50)

`HardBodies` is the engine of ``hpmc run``, `ContactDynamics` that of ``md run``, `LatticeSimulation` that of ``lattice run``: they take the settings of the verb as
keywords, under the names that its ``run.toml`` has. `AssemblySimulation` is that of ``simulate`` and takes its keywords.
"""

from __future__ import annotations

import csv
import json
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._assembly import Trajectory
from ._call import salts, words_of
from ._objects import Files
from ._protomer import ConfigError, LiveSimulation

S = TypeVar("S", bound="Simulation")
Numbers = NDArray[np.float64]


class Simulation:
    """Bodies that move when `run` is called; the common part of `HardBodies`, `ContactDynamics` and `LatticeSimulation`.

    The arrays of the state (`positions`, `orientations`, ...) are made once. `run`, `place` and `restore` fill them
    again, so a name that is bound to one of them always shows the present state; keep a `.copy()` of what shall stay.
    They cannot be written to: `place` moves bodies, because it can refuse overlaps.
    """

    _kind = ""

    def __init__(self, settings: Mapping[str, Any], arrays: Mapping[str, ArrayLike | None]) -> None:
        self._hold(LiveSimulation(self._kind, json.dumps(settings), _columns(arrays) or None))

    def _hold(self, native: LiveSimulation) -> None:
        self._native = native
        self._views = {name: _locked(array) for name, array in self._native._arrays().items()}
        self._observers: list[tuple[int, Callable[[Any], Any]]] = []
        self._log: Any = None

    def run(self: S, count: int) -> S:
        """Advances by so many sweeps or steps and calls the observers on the way.

        Parameters
        ----------
        count
            Sweeps of hard bodies, steps of bodies in motion

        Raises
        ------
        KeyboardInterrupt
            On Ctrl-C, between two sweeps or steps; the simulation can go on
        """
        end = self.done + _natural("count", count)
        while self.done < end:
            ends = [(self.done // every + 1) * every for every, _ in self._observers]
            self._native._advance(min([end, *ends]) - self.done)
            for every, observer in self._observers:
                if self.done % every == 0:
                    observer(self)
        return self

    def every(self, count: int, observer: Callable[[Any], Any]) -> Callable[[], None]:
        """Calls ``observer(simulation)`` whenever the number of sweeps or steps is a multiple of `count`.

        Returns
        -------
        function
            Ends the calls

        >>> import protomer as pm
        >>> disks = pm.HardBodies("rod:1", bodies=10, packing_fraction=0.3)
        >>> seen = []
        >>> stop = disks.every(10, lambda disks: seen.append(disks.done))
        >>> _ = disks.run(35); stop(); _ = disks.run(10); seen
        [10, 20, 30]
        """
        if _natural("count", count) == 0:
            raise ConfigError("count is 0; give the sweeps or steps between two calls")
        entry = (count, observer)
        self._observers.append(entry)

        def stop() -> None:
            if entry in self._observers:
                self._observers.remove(entry)

        return stop

    def place(self, **arrays: ArrayLike) -> None:
        """Puts the bodies elsewhere, by arrays under the names of the state, and `box`; what is not named stays.

        Raises
        ------
        GeometryError
            For bodies that overlap; the state is as before then
        """
        self._native._place(_columns(arrays))

    def change(self, **settings: Any) -> None:
        """Goes on with other settings, such as another pressure or temperature.

        Raises
        ------
        ConfigError
            For settings that cannot be, and for those that make other bodies
        """
        self._native._change(json.dumps(self._settings_of(settings)))

    def measure(self) -> dict[str, float | list[float] | None]:
        """The row of the log that the verb would write for this state; see `log`."""
        return {column: _number(text) for column, text in self._native._measure()}

    def save(self) -> bytes:
        """Everything that changes during a simulation; `restore` goes back to it, bit for bit."""
        return self._native._save()

    def restore(self, saved: bytes) -> None:
        """Goes back to a saved state of this simulation."""
        self._native._restore(saved)

    def write_to(self, directory: str | Path) -> None:
        """Opens a new directory for `log` and `frame`: ``log.csv`` and ``trajectory.gsd`` as the verb writes them, and the
        settings in ``settings.json``.

        Raises
        ------
        FileExistsError
            If the directory holds anything
        """
        path = Path(directory)
        path.mkdir(parents=True, exist_ok=True)
        if any(path.iterdir()):
            raise FileExistsError(f"{path} is not empty; give a new directory")
        (path / "settings.json").write_text(json.dumps(self.settings, indent=2) + "\n")
        self._native._open_trajectory(path / "trajectory.gsd")
        self._log = path / "log.csv"
        with open(self._log, "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerow([column for column, _ in self._native._measure()])

    def log(self) -> dict[str, float | list[float] | None]:
        """Measures the state, as `measure`, and appends the row to ``log.csv`` if `write_to` has opened one."""
        row = self._native._measure()
        if self._log is not None:
            with open(self._log, "a", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow([text for _, text in row])
        return {column: _number(text) for column, text in row}

    def frame(self) -> None:
        """Appends the state to ``trajectory.gsd``; `write_to` opens it."""
        self._native._write_frame()

    @property
    def done(self) -> int:
        """Sweeps or steps done, with those of the preparation."""
        return self._native._done()

    @property
    def settings(self) -> dict[str, Any]:
        """The settings."""
        found: dict[str, Any] = json.loads(self._native._settings())
        return found

    @property
    def positions(self) -> Numbers:
        """Centres from the middle of the box, a row for each body: two columns in a plane, three in space."""
        return self._views["positions"]

    @property
    def orientations(self) -> Numbers:
        """Quaternions with the scalar first, a row for each body."""
        return self._views["orientations"]

    @property
    def box(self) -> Numbers:
        """Edges and tilt factors of the box: Lx, Ly, Lz, xy, xz, yz, with zeros for what it does not have."""
        box: Numbers = self._views["box"][0]
        return box

    @property
    def angles(self) -> Numbers:
        """Angles of the bodies of a plane, radians, from -π to π. These are computed from the orientations and not kept."""
        if self.positions.shape[1] != 2:
            raise ConfigError("bodies in space have no angle; use orientations")
        w, z = self.orientations[:, 0], self.orientations[:, 3]
        angles: Numbers = np.angle(np.exp(2j * np.arctan2(z, w)))
        return angles

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {len(self)} bodies after {self.done}>"

    @classmethod
    def _settings_of(cls, settings: Mapping[str, Any]) -> dict[str, Any]:
        return dict(settings)


class HardBodies(Simulation):
    """Monte Carlo of hard bodies, the engine of ``hpmc run``, in memory.

    Parameters
    ----------
    shape
        File or name, as for ``hpmc run``; several for a mixture
    kinds
        Number of the shape of each body, in a mixture
    positions, orientations, angles
        Bodies to begin with: centres from the middle of the box; quaternions with the scalar first or, in a plane, angles
        in radians. Without them the bodies begin as the verb begins them
    box
        Edges of the box and, if it is tilted, tilt factors behind them; needed with `positions`
    settings
        Keys of the verb's ``run.toml``: `bodies`, `packing_fraction`, `seed`, `equilibration` (sweeps in which the steps are
        tuned), `start`, ... Short forms: ``pressure=2.0``, ``gravity=0.5``, ``depletants=[(0.1, 20.0)]``

    >>> import protomer as pm
    >>> balls = pm.HardBodies("polygon:4", positions=[[-1, 0], [1, 0.2]], angles=[0, 0.3], box=[6, 6], seed=2)
    >>> _ = balls.run(10)
    >>> balls.sweep, len(balls)
    (10, 2)
    """

    _kind = "hard bodies"

    def __init__(
        self,
        shape: str | Path | list[str],
        *,
        positions: ArrayLike | None = None,
        orientations: ArrayLike | None = None,
        angles: ArrayLike | None = None,
        kinds: ArrayLike | None = None,
        box: ArrayLike | None = None,
        **settings: Any,
    ) -> None:
        arrays = {"positions": positions, "orientations": orientations, "angles": angles, "kinds": kinds, "box": box}
        super().__init__(self._settings_of({"shape": _names(shape), **settings}), arrays)

    @property
    def sweep(self) -> int:
        """Sweeps done, with those of the equilibration."""
        return self.done

    @classmethod
    def _settings_of(cls, settings: Mapping[str, Any]) -> dict[str, Any]:
        found = dict(settings)
        for name, key in [("pressure", "kt_per_volume"), ("gravity", "weight_kt_per_length")]:
            if isinstance(found.get(name), (int, float)):
                found[name] = {key: float(found[name])}
        depletants = found.get("depletants")
        if depletants is not None:
            pairs = [kind if isinstance(kind, dict) else dict(zip(("radius", "fugacity"), kind)) for kind in depletants]
            found["depletants"] = pairs
        if isinstance(found.get("start"), Path):
            found["start"] = str(found["start"])
        return found


class ContactDynamics(Simulation):
    """Bodies in motion, the engine of ``md run``, in memory.

    Parameters
    ----------
    shape
        File or name, as for ``md run``; several for a mixture
    positions, orientations, angles, velocities, spins
        Bodies to begin with, in the units of the verb: centres from the middle of the box; quaternions with the scalar first
        or, in a plane, angles in radians; velocities and angular momenta in the frame of each body with three columns. Without
        velocities the bodies get those of the temperature. Without positions they begin as the verb begins them, through
        compression and equilibration, which are the first steps of `run`
    kinds
        Number of the shape of each body, in a mixture
    box
        Edges of the box; needed with `positions`
    settings
        Keys of the verb's ``run.toml``: `time_step`, `ensemble`, `temperature`, `seed`, ...
    """

    _kind = "dynamics"

    def __init__(
        self,
        shape: str | Path | list[str],
        *,
        positions: ArrayLike | None = None,
        orientations: ArrayLike | None = None,
        angles: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
        spins: ArrayLike | None = None,
        kinds: ArrayLike | None = None,
        box: ArrayLike | None = None,
        **settings: Any,
    ) -> None:
        arrays = {
            "positions": positions,
            "orientations": orientations,
            "angles": angles,
            "velocities": velocities,
            "spins": spins,
            "kinds": kinds,
            "box": box,
        }
        super().__init__({"shape": _names(shape), **settings}, arrays)

    @property
    def step(self) -> int:
        """Steps done, with those of the preparation."""
        return self.done

    @property
    def velocities(self) -> Numbers:
        """Velocities of the centres, a row of three numbers for each body."""
        return self._views["velocities"]

    @property
    def spins(self) -> Numbers:
        """Angular momenta in the frame of each body; in a plane the third number."""
        return self._views["spins"]


class LatticeSimulation(Simulation):
    """Rigid squares joined by rods, the engine of ``lattice run``, in memory.

    Parameters
    ----------
    positions, angles, velocities, spins
        Squares to begin with, row by row of the lattice: centres, angles in radians, and their rates. They are brought onto the
        rods, and refused where that moves them by more than 0.001. Without velocities the squares get those of the settings; without
        positions they begin as the verb begins them
    settings
        Keys of the verb's ``run.toml``: `rows`, `columns`, `r0`, `edges`, `kappa`, `temperature`, `friction`, `seed`, ...

    >>> import protomer as pm
    >>> lattice = pm.LatticeSimulation(rows=4, columns=4, r0=0.5, time_step=0.01)
    >>> _ = lattice.run(50)
    >>> round(lattice.time, 9), lattice.angles.shape
    (0.5, (16,))
    """

    _kind = "lattice"

    def __init__(
        self,
        *,
        positions: ArrayLike | None = None,
        angles: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
        spins: ArrayLike | None = None,
        **settings: Any,
    ) -> None:
        arrays = {"positions": positions, "angles": angles, "velocities": velocities, "spins": spins}
        super().__init__({name: str(value) if isinstance(value, Path) else value for name, value in settings.items()}, arrays)

    @property
    def step(self) -> int:
        """Steps done."""
        return self.done

    @property
    def time(self) -> float:
        """Time, from the start of the simulation."""
        return float(str(dict(self._native._measure())["time"]))

    @property
    def orientations(self) -> Numbers:
        """Quaternions with the scalar first, a row for each square; computed from the angles and not kept."""
        half = 0.5 * self.angles
        zero = np.zeros_like(half)
        return np.column_stack([np.cos(half), zero, zero, np.sin(half)])

    @property
    def angles(self) -> Numbers:
        """Angles of the squares, radians."""
        angles: Numbers = self._views["angles"][:, 0]
        return angles

    @property
    def velocities(self) -> Numbers:
        """Velocities of the centres, a row of two numbers for each square."""
        return self._views["velocities"]

    @property
    def spins(self) -> Numbers:
        """Rates of the angles."""
        spins: Numbers = self._views["spins"][:, 0]
        return spins


class AssemblySimulation(Simulation):
    """Monte Carlo of bodies with charges, the engine of ``simulate``, in memory.

    Parameters
    ----------
    assembly
        Assembly file, or `Assembly`
    positions, orientations
        Bodies to begin with, a row for each body of the assembly: centres in Å, quaternions with the scalar first. Without them
        the bodies begin where the assembly has them
    start
        Trajectory of another run, or the directory that holds it: the bodies begin as in its last frame, or as in `frame`
    settings
        Keywords of `simulate`: `salt`, `model`, `seed`, `equilibration`, ... `change` takes the keys of its ``run.toml``

    >>> import protomer as pm
    >>> ring = pm.AssemblySimulation("ring.json", salt="100mM", equilibration=0)   # doctest: +SKIP
    >>> ring.run(10).measure()["r_g_angstrom"]                                     # doctest: +SKIP
    """

    def __init__(
        self,
        assembly: Any,
        *,
        positions: ArrayLike | None = None,
        orientations: ArrayLike | None = None,
        start: str | Path | None = None,
        frame: int = -1,
        salt: Any = None,
        salt_molar: Any = None,
        **settings: Any,
    ) -> None:
        if start is not None:
            positions, orientations = _poses(start, frame, positions, orientations)
        arrays = {"positions": positions, "orientations": orientations}
        flags = {f"--{name.replace('_', '-')}": value for name, value in settings.items()}
        # The directory of the results is a flag that the verb requires; nothing is written there.
        flags |= {"--salt": salts("AssemblySimulation", salt, salt_molar, required=settings.get("config") is None), "--output": "in-memory"}
        with Files(["inspect"], None, replace=False) as files:
            words, placed = words_of(["simulate"], [assembly], flags, files)
            native, warned = LiveSimulation._of_assembly([*words, "--", *placed], _columns(arrays) or None)
        for line in warned:
            warnings.warn(line.removeprefix("warning: "), stacklevel=2)
        self._hold(native)

    @property
    def sweep(self) -> int:
        """Sweeps done, with those of the equilibration."""
        return self.done


def _poses(start: str | Path, frame: int, *others: ArrayLike | None) -> tuple[ArrayLike, ArrayLike]:
    """Positions and orientations of a frame of a trajectory; -1 is the last."""
    if any(given is not None for given in others):
        raise ConfigError("start has its own positions and orientations; give one or the other")
    found = Trajectory(_trajectory_in(Path(start)))[frame]
    return found.positions_angstrom, found.orientations_wxyz


def _trajectory_in(path: Path) -> Path:
    """The trajectory of a run, whose directory has a folder for its salt; a file is that file."""
    if not path.is_dir():
        return path
    found = sorted(path.rglob("trajectory.gsd"))
    if len(found) != 1:
        raise ConfigError(f"{path} has {len(found)} trajectories; give the trajectory.gsd of one simulation")
    return found[0]


def _names(shape: str | Path | list[str]) -> str | list[str]:
    return [str(name) for name in shape] if isinstance(shape, list) else str(shape)


def _columns(arrays: Mapping[str, ArrayLike | None]) -> dict[str, Numbers]:
    """Arrays with two dimensions: lists of numbers become a column, and the box a row."""
    found = {}
    for name, values in arrays.items():
        if values is None:
            continue
        array = np.asarray(values, dtype=np.float64)
        if array.ndim == 1:
            array = array[None, :] if name == "box" else array[:, None]
        if array.ndim != 2:
            raise ConfigError(f"{name} has {array.ndim} dimensions; give a row for each body")
        found[name] = array
    return found


def _locked(array: Numbers) -> Numbers:
    view = array.view()
    view.flags.writeable = False
    return view


def _natural(name: str, value: int) -> int:
    if not isinstance(value, (int, np.integer)) or value < 0:
        raise ConfigError(f"{name} is {value!r}; give a whole number, 0 or more")
    return int(value)


def _number(text: str) -> float | list[float] | None:
    numbers = [float(word) for word in text.split()]
    return None if not numbers else numbers[0] if len(numbers) == 1 else numbers
