"""The vendor's client and server library, `qi`, which is an extra."""

from __future__ import annotations

import importlib.util
import os
import platform
import sys
from typing import Any, Final

from bridge.errors import LinkError

NEWEST_PYTHON: Final = (3, 12)
"""For which there is a package of qi."""


def require_qi() -> None:
    """See that qi is there.

    Raises:
        LinkError: it is not; says where there is a package of it.
    """
    if importlib.util.find_spec("qi") is not None:
        return
    here = f"Python {platform.python_version()} on {platform.system()} {platform.machine()}"
    available = (
        sys.version_info[:2] <= NEWEST_PYTHON and sys.platform == "linux" and platform.machine() == "x86_64"
    )
    remedy = (
        "pip install 'nao-hil[naoqi]'"
        if available
        else "it has packages for Python 3.8 to 3.12 on Linux x86-64 only, run it there"
    )
    raise LinkError(f"the package qi is not installed for {here}; {remedy}.")


def load_qi() -> Any:
    """The module `qi`, without its warning that the program makes no application.

    The warning would go to the standard output, among the results of a command.

    Raises:
        ImportError: it is not installed.
    """
    os.environ.setdefault("QI_LOG_FILTERS", "qi.path.sdklayout=error")
    import qi

    return qi
