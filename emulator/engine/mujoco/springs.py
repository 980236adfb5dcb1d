"""Springs of a given stiffness from MuJoCo's soft constraints.

MuJoCo's force in a constraint is (-b v - k d r - a) / R: r the violation (negative), v its rate, a its
acceleration in the step, d the impedance, and R = (1 - d) / d times the inverse inertia that the compiler
found. A spring and damper by implicit Euler is -K (r + h v + h^2 a) - B (v + h a). Both are the same with
1 / R = K h^2 + B h, the constraint's apparent mass, on a link of any mass.
"""

from __future__ import annotations

Numbers = tuple[float, ...]


def spring(
    stiffness: float, relaxation: float, step: float, inverse_inertia: float
) -> tuple[tuple[float, float], Numbers]:
    """`solref` and `solimp` of a spring with a damper.

    Args:
        stiffness: K, N/m or N m/rad.
        relaxation: B / K, s.
        step: Physics step h, s.
        inverse_inertia: MuJoCo's `invweight0` of what is constrained, 1/kg or 1/(kg m^2).
    """
    per_rate = stiffness * (step + relaxation)
    mass = per_rate * step
    impedance = 1.0 / (1.0 + 1.0 / (mass * inverse_inertia))
    # in MuJoCo's direct form both are divided by the impedance
    reference = (-stiffness / mass * impedance, -per_rate / mass * impedance)
    return reference, (impedance, impedance, 0.001, 0.5, 2.0)
