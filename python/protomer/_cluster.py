"""A sweep on many machines: parts of it as tasks of Dask.

Every task is `sweep(..., shard="i/n")` in the same directory, which all workers must see. The directory is the protocol: what a
lost worker had finished stays, what it was at goes on from its checkpoint, and the last call collects the parts. So the result
is the local one, bit for bit.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping
from typing import Any

from . import _verbs
from ._call import Path
from .results import SweepResult

PARTS_PER_THREAD = 4
"""Enough that workers end at about the same time; parts without a simulation cost next to nothing."""


def sweep(
    assembly: Path,
    *,
    output: Path,
    client: Any | None = None,
    parts: int | None = None,
    retries: int = 3,
    progress: Callable[[int, int, str], None] | None = None,
    **settings: Any,
) -> SweepResult:
    """Simulate an assembly at several salt concentrations: here, or on the workers of a Dask client.

    Parameters
    ----------
    assembly
        Assembly file
    output
        Directory of the results; with a client, one that all workers see under this path
    client
        A `distributed.Client`, or the address of a scheduler ("tcp://host:8786"); None: this machine
    parts
        Tasks to make of the sweep; four for each thread of the workers if left out
    retries
        How often a task is tried again after its worker was lost
    progress
        Called as progress(done, total, unit): sweeps here, parts with a client
    settings
        What follows, as on the command line
    """
    if client is None:
        return _verbs.sweep(assembly, output=output, progress=progress, **settings)
    assembly, output = os.path.abspath(assembly), os.path.abspath(output)
    _run_parts(client, assembly, output, settings, parts, retries, progress)
    # Everything is there; this writes the table and the figure.
    return _verbs.sweep(assembly, output=output, **settings)


def _with_the_keywords_of(verb: Callable[..., Any]) -> None:
    """Shows the settings where a reader looks for them: in the signature and in help()."""
    here, there = inspect.signature(sweep), inspect.signature(verb)
    own = [parameter for parameter in here.parameters.values() if parameter.kind is not inspect.Parameter.VAR_KEYWORD]
    settings = [parameter for name, parameter in there.parameters.items() if name not in here.parameters]
    sweep.__signature__ = here.replace(parameters=[*own, *settings])  # type: ignore[attr-defined]
    described = (verb.__doc__ or "").split("----------\n", 1)[-1]
    sweep.__doc__ = f"{inspect.cleandoc(sweep.__doc__ or '')}\n\n{inspect.cleandoc(described)}"


_with_the_keywords_of(_verbs.sweep)


def _run_parts(
    client: Any,
    assembly: str,
    output: str,
    settings: Mapping[str, Any],
    parts: int | None,
    retries: int,
    progress: Callable[[int, int, str], None] | None,
) -> None:
    from distributed import Client, as_completed

    owned = isinstance(client, str)
    if owned:
        client = Client(client)
    try:
        count = parts or PARTS_PER_THREAD * max(1, sum(client.nthreads().values()))
        # One thread each: workers bring the parallelism.
        shared = {"threads": 1, **settings}
        numbers = range(1, count + 1)
        futures = [
            client.submit(_part, assembly, output, f"{n}/{count}", shared, pure=False, retries=retries) for n in numbers
        ]
        for done, future in enumerate(as_completed(futures), start=1):
            future.result()
            if progress is not None:
                progress(done, count, "parts")
    finally:
        if owned:
            client.close()


def _part(assembly: str, output: str, shard: str, settings: Mapping[str, Any]) -> int:
    """One part, on a worker; simulations that were done already cost nothing."""
    return int(_verbs.sweep(assembly, output=output, shard=shard, **settings)["simulations"])
