"""The hip motion of a configuration: named by its parameters, or scaled from the body's shipped plan.

`nao-hil plan --robot BODY --out DIR` searches a plan; `plans/BODY.toml` is the `config.toml` that it writes for
the shipped parameters. x_sd and x_ed scale with the length of a step, as bound (11) does, and y_d and y_m with
the distance of the feet. With steps of up to 50 mm the scaled motion has the margin of a searched one (within
0.2 mm on a nao-v3 and a nao-v6); at 70 mm it has 2 to 3 mm less, at 80 mm 4 to 7 mm. Other changed parameters
keep the motion; `nao-hil plan --set` searches one for them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import msgspec

from bridge.body import Body
from bridge.config import load_toml
from walker.planning.huang.hip import Choice
from walker.planning.huang.parameters import HuangParameters, refuse

PLANS: Final = Path(__file__).parent / "plans"


class ShippedPlan(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A plan with all parameters that it was searched for."""

    robot: str
    gait: str
    parameters: HuangParameters


def choice_of(p: HuangParameters, body: Body) -> Choice:
    """Where the hip is at the ends and in the middle of single support.

    Args:
        p: parameters; the numbers that they name are taken as they are.
        body: data sheet.

    Raises:
        ConfigurationError: the parameters leave a number open and no plan is shipped for this body.
    """
    if p.x_sd is not None and p.x_ed is not None and p.y_d is not None and p.y_m is not None:
        return Choice(p.x_sd, p.x_ed, p.y_d, p.y_m)
    file = PLANS / f"{body.name}.toml"
    if not file.exists():
        refuse(
            f"no plan is shipped for a {body.name}; search one with `nao-hil plan --out plan` and the same "
            "--robot, and walk with --config plan/config.toml"
        )
    planned = load_toml(file, ShippedPlan).parameters
    along, across = p.D_s / planned.D_s, p.l_FA / planned.l_FA
    return Choice(
        *(
            scale * getattr(planned, name) if getattr(p, name) is None else getattr(p, name)
            for name, scale in (("x_sd", along), ("x_ed", along), ("y_d", across), ("y_m", across))
        )
    )
