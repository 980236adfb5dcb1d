"""The walking cycle of Huang et al. (2001): heel and toe, and a search for the largest margin."""

from walker.gait.huang.gait import HuangGait
from walker.gait.huang.parameters import HuangParameters

__all__ = ["HuangGait", "HuangParameters"]
