"""The `nao-hil` script, and `python -m nao_hil.cli` without it installed."""

import os
import signal


def main() -> None:
    """Load the command line and run it; a Ctrl-C while the libraries load ends it without a traceback."""
    before = signal.signal(signal.SIGINT, lambda _number, _frame: os._exit(130))
    # Before numpy is imported: on matrices of this size its threads wait longer than they compute.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from nao_hil.cli.main import main as run

    signal.signal(signal.SIGINT, before)
    run()


if __name__ == "__main__":
    main()
