"""The one constant of nature in the walker."""

from typing import Final

GRAVITY: Final = 9.81
"""m/s^2 (thesis 2.5)."""
