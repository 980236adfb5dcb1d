"""Errors that a user can cause, each with one sentence and an exit code."""

from __future__ import annotations

from typing import ClassVar


class NaoHilError(Exception):
    """Base of all errors whose message names the fault and the remedy to the user."""

    exit_code: ClassVar[int] = 3


class ConfigurationError(NaoHilError):
    """A wrong option, file or parameter (exit code 2)."""

    exit_code = 2


class LinkError(NaoHilError):
    """A process, a link or a device failed (exit code 3)."""


class RobotSilent(LinkError):
    """The robot does not answer."""


class FrameError(NaoHilError):
    """A message from the wire that is not a valid frame; names the field at fault."""


class LeaseRefused(LinkError):
    """Another controller holds the robot; names the holder."""


class DcmRefused(NaoHilError):
    """A DCM request that cannot be carried out; names the item at fault."""


class WalkRefused(NaoHilError):
    """A walk command that cannot be carried out; names the bound (exit code 2)."""

    exit_code = 2


class WalkFailed(NaoHilError):
    """A walk that could not be carried out to its end, though robot and link are well; names the cause."""


class NaoqiRefused(NaoHilError):
    """A NAOqi call that cannot be carried out; names the fault and the remedy."""
