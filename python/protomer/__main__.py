"""The command line: `protomer`, or `python -m protomer`."""

import signal
import sys

from ._protomer import main as _main


def main() -> int:
    """Runs the words of the command line; returns the exit code."""
    # Ctrl-C is the program's own affair here: it stops at the next step and can be continued.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
