"""For all tests: a Ctrl-C that children can hear.

A shell starts background jobs with SIGINT ignored, and what is ignored stays so in every child; a handler of
this process is the default in its children.
"""

from __future__ import annotations

import signal

signal.signal(signal.SIGINT, signal.default_int_handler)
