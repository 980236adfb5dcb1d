"""The `nao-hil` script, and `python -m nao_hil.cli` without it installed."""

import os
import signal

# First of all: a Ctrl-C in an import would print a traceback, or get lost in a destructor.
_BEFORE = signal.signal(signal.SIGINT, lambda _number, _frame: os._exit(130))

import gc  # noqa: E402


def main() -> None:
    """Load the command line and run it."""
    # Before numpy is imported: on matrices of this size its threads wait longer than they compute.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # The libraries' objects stay: to look among them for garbage after every 700 takes an eighth of the start.
    gc.set_threshold(20_000, 50)
    from nao_hil.cli.main import main as run

    run(interrupt=_BEFORE)


if __name__ == "__main__":
    main()
