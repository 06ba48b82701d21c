"""The program ``cosmic``: ``python -m cosmic optimize stability``. ``python -m cosmic --help`` lists its commands."""

from __future__ import annotations

import signal
import sys

from . import _core


def main() -> int:
    """Runs the command of the command line, and returns its exit code."""
    # Python's own handler would wait for the end of the command. A signal that is ignored stays ignored.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _core.program(["cosmic", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
