"""The command line: `protomer`, or `python -m protomer`."""

from __future__ import annotations

import signal
import sys

from ._protomer import ConfigError, ProtomerError, StoppedError
from ._protomer import main as _main


def main() -> int:
    """Runs the words of the command line; returns the exit code."""
    words = sys.argv[1:]
    if any(map(_is_scheduler, words)):
        try:
            words = _shared_out(words)
        except (ProtomerError, ImportError) as error:
            print(f"error: {error}", file=sys.stderr)
            return 3 if isinstance(error, StoppedError) else 1
        except KeyboardInterrupt:
            print("stopped; the same command continues it", file=sys.stderr)
            return 3
    # The program handles Ctrl-C itself: it stops at the next step and can be continued.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _main(words)


def _shared_out(words: list[str]) -> list[str]:
    """Has the workers of a scheduler do the work; the words of what is left to do."""
    from . import _cluster

    try:
        command = _cluster.Command.of(words)
    except ConfigError:
        return words  # The program itself reports what is wrong with them, or prints the help.
    address = command.value("scheduler")
    quiet = command.has("quiet") or command.has("no-progress") or not sys.stderr.isatty()
    _cluster.share_out(words, address, progress=None if quiet else _show)
    at = next(place for place, word in enumerate(words) if _is_scheduler(word))
    after = at + 2 if words[at + 1 : at + 2] == [address] else at + 1
    return words[:at] + words[after:]


def _is_scheduler(word: str) -> bool:
    return word.partition("=")[0] == "--scheduler"


def _show(done: int, total: int, unit: str) -> None:
    print(f"\r{done}/{total} {unit}", end="\n" if done == total else "", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
