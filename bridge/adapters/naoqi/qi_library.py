"""The vendor's client and server library, `qi`, which is an extra."""

from __future__ import annotations

import os
from typing import Any


def load_qi() -> Any:
    """The module `qi`, without its warning that the program makes no application.

    The warning would go to the standard output, among the results of a command.

    Raises:
        ImportError: it is not installed.
    """
    os.environ.setdefault("QI_LOG_FILTERS", "qi.path.sdklayout=error")
    import qi

    return qi
