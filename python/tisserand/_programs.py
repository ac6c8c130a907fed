"""The programs of the command line, ``reduce`` and ``simulate``."""

import signal
import sys

from tisserand import _native


def _run(name: str) -> int:
    # The program listens to signals itself, and ends with their status.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    arguments = [name, *sys.argv[1:]]
    return _native.run_reduce(arguments) if name == "reduce" else _native.run_simulate(arguments)


def reduce() -> int:
    """The program ``reduce``."""
    return _run("reduce")


def simulate() -> int:
    """The program ``simulate``."""
    return _run("simulate")
