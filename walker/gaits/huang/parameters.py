"""Parameters of the walking cycle of Huang et al. (2001), and the bounds that need no plan."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import msgspec

from bridge.errors import ConfigurationError
from bridge.ground import KnownGround
from walker.gaits.gait import GaitParameters, PeriodicStep

# A NAO is half a metre high: a larger length is a typing error.
_Length = Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]
_Place = Annotated[float, msgspec.Meta(ge=-1.0, le=1.0)]
_Time = Annotated[float, msgspec.Meta(ge=0.01, le=60.0)]
_Pitch = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]


class HuangParameters(GaitParameters, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the gait; symbols of the source, SI units and rad."""

    LENGTH: ClassVar = "D_s"

    T_c: _Time
    """Duration of a walking cycle of the planner, one step, s."""
    T_d: _Time
    """Double support at its beginning, s."""
    T_m: _Time
    """Time of the swing foot's highest point, from the beginning of its cycle, s."""
    D_s: _Length
    """Length of a step, m."""
    l_FA: _Length
    """Distance of the ankles along y, m; the source walks in the plane."""
    q_b: _Pitch
    """Pitch of the rear foot about its toe when it lifts, rad."""
    q_f: _Pitch
    """Pitch of the front foot about its heel when it lands, rad."""
    L_ao: _Length | None = None
    """Way of the ankle from its lift to its highest point in a whole step, m; None: half of it, D_s."""
    H_ao: _Length
    """Height of the ankle there, above the ground, m."""
    H_min: _Length
    """Height of the hip joints above the ground in the middle of double support, m."""
    H_max: _Length
    """The same in the middle of single support, m."""
    T_start: _Time
    """From rest to the first cycle, and from the last one to rest, s; not in the source."""
    sole_give: Annotated[float, msgspec.Meta(gt=0.0, le=0.01)]
    """Parts of a sole less than this above the ground bear load, m."""
    x_0: _Place = 0.0
    """The point of the stance foot from which x_sd and x_ed count, ahead of the ankle, m; 0 in the source.
    The middle of a NAO's sole is 20 mm ahead of its ankle; counted from there the best ones are on (11)."""
    x_sd: _Place | None = None
    """Distance of the hip behind that point when single support begins, m; None: as planned for the body, see
    `walker.gaits.huang.hip`."""
    x_ed: _Place | None = None
    """Distance ahead of it when single support ends, m; None: as planned."""
    y_d: _Place | None = None
    """Distance of the hip from the path towards the stance foot when single support begins and ends, m; None:
    as planned."""
    y_m: _Place | None = None
    """The same in the middle of single support, m; None: as planned."""
    D_max: _Length = 0.13
    """Longest step over an edge of the known ground, m."""
    overhang: Annotated[float, msgspec.Meta(ge=0.0, le=0.1)] = 0.04
    """Length of a sole that may overhang an edge of the known ground, at heel or toe, m."""
    progress: Annotated[float, msgspec.Meta(gt=0.5, le=1.5)] = 1.0
    """Fraction of the planned way that the robot makes: edges of known ground are expected that much later."""
    ground: KnownGround = KnownGround()
    """The ground that the feet are planned for."""
    first_swing: Literal["L", "R"] = "R"
    """The foot that makes the first step."""

    @property
    def periodic_step(self) -> PeriodicStep:
        """One cycle."""
        return PeriodicStep(self.D_s, self.T_c)


def check_bounds(p: HuangParameters) -> None:
    """The order of times and heights, and bound (11).

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    if p.T_d >= p.T_c:
        refuse(f"T_d = {p.T_d} s must be less than T_c = {p.T_c} s, and exceeds it by {p.T_d - p.T_c:.3g} s")
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
            over = 1e3 * abs(value if value <= 0.0 else value - 0.5 * p.D_s)
            violates = f"violates bound (11) by {over:.1f} mm" if over >= 0.05 else "lies on bound (11)"
            refuse(f"{name} = {value} m {violates}; it must be between 0 and 0.5 D_s = {0.5 * p.D_s:.4g} m")


def refuse(sentence: str) -> None:
    """Raise a ConfigurationError that names the gait."""
    raise ConfigurationError(f"gait huang: {sentence}.")
