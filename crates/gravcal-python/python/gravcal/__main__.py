"""The program `gravcal`."""

import signal
import sys

from . import _native


def main() -> int:
    """Runs the program with the arguments of the command line; gives its exit code."""
    # Ctrl-C, and a reader who has seen enough, are the program's own matter.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.run_program(["gravcal", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
