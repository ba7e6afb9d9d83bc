"""Work on many machines: the parts of a command as tasks of Dask.

Every task is the same command with `--shard i/n`, on files visible to all workers. The files are the protocol: the finished
work of a lost worker remains, and its unfinished work continues from the last checkpoint. Once everything is done, the
command itself, without `--shard`, collects it. So the result equals the local one, byte for byte.
"""

from __future__ import annotations

import json
import shutil
import socket
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from . import _protomer
from ._protomer import ConfigError, ProtomerError, StoppedError, __version__

PARTS_PER_THREAD = 4
"""Enough for workers to end at about the same time; parts without work cost almost nothing."""
SECONDS_TO_ANSWER = 10
LOCAL = "local"
"""Instead of an address: a scheduler and workers on this machine, for the duration of the command."""

Progress = Callable[[int, int, str], None]
_FOR_PEOPLE = frozenset(["json", "quiet", "verbose", "no-progress", "scheduler"])
"""Flags that are meaningless for a part of a command."""


class Command(NamedTuple):
    """A parsed command with absolute paths."""

    verb: list[str]
    flags: list[tuple[str, str | None]]
    places: list[str]

    @classmethod
    def of(cls, words: Sequence[str]) -> Command:
        """Parses the words of a command; ConfigError if they are not a command."""
        return cls(*_protomer.take_apart(words))

    def has(self, name: str) -> bool:
        """Whether a flag was given."""
        return any(flag == name for flag, _ in self.flags)

    def value(self, name: str) -> str:
        """The value of a flag that was given."""
        return next(value for flag, value in self.flags if flag == name and value is not None)

    def words(self, **others: str) -> list[str]:
        """The command as words, with other values for some flags."""
        kept = [(flag, value) for flag, value in self.flags if flag not in others and flag not in _FOR_PEOPLE]
        flags = [f"--{flag}" if value is None else f"--{flag}={value}" for flag, value in [*kept, *others.items()]]
        return [*self.verb, *flags, "--", *self.places]


class Workers:
    """The workers of a client, and how to use them."""

    def __init__(self, client: Any, parts: int | None, progress: Progress | None) -> None:
        self._client, self._parts, self._progress = client, parts, progress

    def parts(self, begun: int | None = None) -> int:
        """The number of parts: as requested, as in an earlier call, or from the number of worker threads."""
        return self._parts or begun or PARTS_PER_THREAD * max(1, sum(self._client.nthreads().values()))

    def run(self, commands: Sequence[Sequence[str]]) -> list[Any]:
        """Runs commands, each as a task; yields their answers in the order in which they end."""
        from distributed import KilledWorker, as_completed

        tasks = [self._client.submit(_run, words, __version__, pure=False) for words in commands]
        answers: list[Any] = []
        try:
            for task in as_completed(tasks, loop=self._client.loop):
                answers.append(task.result())
                if isinstance(answers[-1], ProtomerError) and not isinstance(answers[-1], StoppedError):
                    raise answers[-1]
                if self._progress is not None:
                    self._progress(len(answers), len(tasks), "parts")
        except KilledWorker as error:
            raise ProtomerError(f"a part lost its worker too often, perhaps because of insufficient memory: {error}") from error
        except CancelledError as error:
            raise ProtomerError(f"the scheduler was lost; the same command continues the work: {error}") from error
        finally:
            self._client.cancel(tasks)
        for answer in answers:
            if isinstance(answer, StoppedError):
                raise answer
        return answers


def share_out(words: Sequence[str], client: Any, parts: int | None = None, progress: Progress | None = None) -> None:
    """Lets workers do everything of a command except its final step.

    `client` is a `distributed.Client`, the address of a scheduler, or "local".
    """
    command = Command.of(words)
    if command.has("shard"):
        raise ConfigError("--shard is a single part; omit it, because the scheduler runs all parts")
    with _connected(client) as connected:
        _SHARED_OUT[command.verb[0]](command, Workers(connected, parts, progress))


def _sweep(command: Command, workers: Workers) -> None:
    workers.run(_parts(command, workers.parts()))


def _conditions(command: Command, workers: Workers) -> None:
    if not command.has("output"):
        raise ConfigError(f"the parts of a {command.verb[0]} need a directory that all workers see; add --output DIR")
    workers.run(_parts(command, workers.parts()))


def _voxelize(command: Command, workers: Workers) -> None:
    output = Path(command.value("output"))
    if output.exists() and not command.has("force"):
        return  # The command itself says whether it is this set.
    folder = output.with_name(f"{output.name}.parts")
    # Parts are files: if some exist, keep their number.
    begun = [int(path.name.partition("-of-")[2].split(".")[0]) for path in folder.glob("*-of-*.zarr*")]
    count = workers.parts(max(begun, default=None))
    sets = [str(folder / f"{number}-of-{count}.zarr") for number in range(1, count + 1)]
    workers.run(_parts(command, count, sets))
    _protomer.call(["merge", f"--output={output}", *(["--force"] if command.has("force") else []), "--", *sets])
    for path in sets:
        shutil.rmtree(path)
    with suppress(OSError):  # Whatever else lies there is not ours.
        folder.rmdir()


def _tune(command: Command, workers: Workers) -> None:
    parts = _parts(command, workers.parts())
    # A part ends when it has to wait for others, and continues in the next round. A single part is the whole search.
    while not all(answer.get("finished", True) for answer in workers.run(parts)):
        pass


_SHARED_OUT = {
    "free-energy": _sweep,
    "hpmc": _sweep,
    "lattice": _sweep,
    "pair": _conditions,
    "score": _conditions,
    "stability": _conditions,
    "sweep": _sweep,
    "tune": _tune,
    "voxelize": _voxelize,
}
"""How to divide what each verb does; what is left to do is the verb itself."""


def _parts(command: Command, count: int, outputs: Sequence[str] = ()) -> list[list[str]]:
    """The words of every part, with separate outputs where needed."""
    # One thread each: workers bring the parallelism.
    threads = {} if command.has("threads") else {"threads": "1"}
    own = [{"output": output} for output in outputs] or [{}] * count
    return [command.words(shard=f"{n}/{count}", **threads, **part) for n, part in enumerate(own, start=1)]


def _run(words: list[str], version: str) -> Any:
    """A command on a worker: what it answers, or its error, which Dask would shout about."""
    if version != __version__:
        return ProtomerError(f"a worker has protomer {__version__}, and it was called by {version}; install the same there")
    try:
        return _protomer.call(words)[1]
    except ProtomerError as error:
        return error


@contextmanager
def _connected(client: Any) -> Iterator[Any]:
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        advice = "pip install './python[cluster]' from the root of the project"
        raise ImportError(f"work on many machines needs Dask: {advice}") from error
    if not isinstance(client, str):
        yield client
    elif client == LOCAL:
        with LocalCluster(threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as connected:
            yield connected
    else:
        _reach(client)
        with Client(client, timeout=SECONDS_TO_ANSWER) as connected:
            if not connected.nthreads():
                print(f"waiting for workers: 'dask worker {client}' starts one", file=sys.stderr)
            yield connected


def _reach(address: str) -> None:
    """Waits for an answer at an address. A Dask client that fails to connect can be neither closed nor ignored."""
    scheme, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if not host or not port.isdigit():
        raise ConfigError(f"'{address}' is not the address of a scheduler; give one such as tcp://host:8786, or {LOCAL}")
    end = time.monotonic() + SECONDS_TO_ANSWER
    while scheme in ("", "tcp", "tls"):
        try:
            return socket.create_connection((host.strip("[]"), int(port)), SECONDS_TO_ANSWER).close()
        except OSError as error:
            if time.monotonic() > end:
                start = "'dask scheduler' starts one, 'dask worker ADDRESS' its workers"
                raise ProtomerError(f"no Dask scheduler answers at {address} ({error}); {start}") from error
        time.sleep(0.1)
