"""Parameters of the walking cycle of Huang et al. (2001), and the bounds that need no plan."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from bridge.errors import ConfigurationError
from bridge.ground import KnownGround

_Positive = Annotated[float, msgspec.Meta(gt=0.0)]
_NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class HuangParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the gait; symbols of the source, SI units and rad."""

    T_c: _Positive
    """Duration of a walking cycle of the planner, one step, s."""
    T_d: _Positive
    """Double support at its beginning, s."""
    T_m: _Positive
    """When the swing foot is highest, from the beginning of its cycle, s."""
    D_s: _Positive
    """Length of a step, m."""
    l_FA: _Positive
    """Distance of the ankles along y, m; the source walks in the plane."""
    q_b: _NotNegative
    """Pitch of the rear foot about its toe when it lifts, rad."""
    q_f: _NotNegative
    """Pitch of the front foot about its heel when it lands, rad."""
    L_ao: _Positive | None = None
    """Way of the ankle from its lift to its highest point in a whole step, m; None: half of it, D_s."""
    H_ao: _Positive
    """Height of the ankle there, above the ground, m."""
    H_min: _Positive
    """Height of the hip joints above the ground in the middle of double support, m."""
    H_max: _Positive
    """The same in the middle of single support, m."""
    T_start: _Positive
    """From rest to the first cycle, and from the last one to rest, s; not in the source."""
    sole_give: _Positive
    """What of a sole is less than this above the ground bears load, m."""
    x_0: float = 0.0
    """The point of the stance foot from which x_sd and x_ed count, ahead of the ankle, m; 0 in the source.
    The middle of a NAO's sole is 20 mm ahead of its ankle, and counted from there the best ones lie on (11)."""
    x_sd: float | None = None
    """How far the hip is behind that point when single support begins, m; None: searched."""
    x_ed: float | None = None
    """How far it is ahead of it when single support ends, m; None: searched."""
    y_d: float | None = None
    """How far the hip is off the path towards the stance foot when single support begins and ends, m; None:
    searched."""
    y_m: float | None = None
    """The same in the middle of single support, m; None: searched."""
    grid: Annotated[int, msgspec.Meta(ge=3, le=400)] = 40
    """Points of the search along each of its two dimensions."""
    D_max: _Positive = 0.13
    """Longest step over an edge of the known ground, m."""
    overhang: _NotNegative = 0.04
    """How much of a sole's length may hang over an edge of the known ground, at heel or toe, m."""
    progress: Annotated[float, msgspec.Meta(gt=0.5, le=1.5)] = 1.0
    """Share of the planned way that the robot makes: edges of the known ground are expected that much later."""
    ground: KnownGround = KnownGround()
    """The ground that the feet are planned for."""
    first_swing: Literal["L", "R"] = "R"
    """The foot that makes the first step."""


def check_bounds(p: HuangParameters) -> None:
    """The order of times and heights, and bound (11).

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    if p.T_d >= p.T_c:
        refuse(f"T_d = {p.T_d} s is {p.T_d - p.T_c:.3g} s too long; it must be less than T_c = {p.T_c} s")
    if not p.T_d < p.T_m < p.T_c:
        over = p.T_d - p.T_m if p.T_m <= p.T_d else p.T_m - p.T_c
        refuse(
            f"T_m = {p.T_m} s lies {over:.3g} s outside the swing; it must be between T_d = {p.T_d} s and "
            f"T_c = {p.T_c} s"
        )
    if p.H_min > p.H_max:
        refuse(f"H_min = {p.H_min} m is {1e3 * (p.H_min - p.H_max):.1f} mm above H_max = {p.H_max} m (7)")
    if p.L_ao is not None and p.L_ao >= 2.0 * p.D_s:
        refuse(
            f"L_ao = {p.L_ao} m lies {1e3 * (p.L_ao - 2.0 * p.D_s):.1f} mm beyond the landing at 2 D_s = "
            f"{2.0 * p.D_s} m"
        )
    for name, value in (("x_sd", p.x_sd), ("x_ed", p.x_ed)):
        if value is not None and not 0.0 < value < 0.5 * p.D_s:
            over = -value if value <= 0.0 else value - 0.5 * p.D_s
            refuse(
                f"{name} = {value} m violates bound (11) by {1e3 * over:.1f} mm; it must be between 0 and "
                f"0.5 D_s = {0.5 * p.D_s:.4g} m"
            )


def refuse(sentence: str) -> None:
    """Raise a ConfigurationError that names the gait."""
    raise ConfigurationError(f"gait huang: {sentence}.")
