"""The compiled drives beside the two lines of their description, solved joint by joint with a root finder."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from bridge.body import joint_tree, load_body
from bridge.body.joints import INDEX_WITH_MIRROR, N_JOINTS
from bridge.body.quantities import joint_no_load_speed
from emulator.servo.parameters import Backlash, ServoParameters
from emulator.servo.servo import Servo
from tests.servos import torques

STEP = 0.001
BODY = load_body("nao-v6")
JOINTS = tuple(joint_tree(BODY))


def beyond(gap: float, width: float) -> float:
    """How far a gap goes beyond a dead zone of a width."""
    return math.copysign(max(abs(gap) - 0.5 * width, 0.0), gap)


def clip(value: float, bound: float) -> float:
    return min(max(value, -bound), bound)


@dataclass
class Drive:
    """One drive with a rotor angle theta, by the equations of `emulator.servo.servo`."""

    stall: float
    no_load: float
    width: float
    parameters: ServoParameters
    theta: float
    twist: float = 0.0

    def step(self, request: float, stiffness: float, q: float, qd: float) -> float:
        """Torque of one step: motor line and gear line meet."""
        p = self.parameters
        # the loop takes theta of the last step, so its lead reaches one step further
        u = clip((request - self.theta - (p.lead + STEP) * qd) / p.full_voltage_error, 1.0)
        if stiffness <= 0.0:
            u = 0.0
        limit = self.stall * (stiffness if stiffness > 0.0 else p.brake if stiffness == 0.0 else 0.0)

        def theta_after(tau: float) -> float:
            # tau = stall (u - theta' / no_load)
            return self.theta + (u - tau / self.stall) * self.no_load * STEP

        def gear(tau: float) -> float:
            # 0 = x + relaxation x' - c tau
            x = beyond(self.theta + u * self.no_load * STEP - q, self.width)
            x -= tau * self.no_load / self.stall * STEP
            return x + p.gear_relaxation * (x - self.twist) / STEP - p.gear_compliance * tau

        tau = clip(brentq(gear, -1e4, 1e4, xtol=1e-13, rtol=1e-14), limit)
        gap = clip(theta_after(tau) - q, 0.5 * self.width + limit * p.gear_compliance)
        self.theta, self.twist = q + gap, beyond(gap, self.width)
        return tau


parameters = st.builds(
    ServoParameters,
    full_voltage_error=st.floats(0.01, 0.2),
    lead=st.floats(0.0, 0.01),
    gear_compliance=st.sampled_from([0.0, 0.002, 0.008]),
    gear_relaxation=st.sampled_from([0.0, 0.005, 0.02]),
    brake=st.sampled_from([0.0, 0.1]),
    backlash=st.floats(0.0, 0.05).map(
        lambda width: msgspec.convert(dict.fromkeys(Backlash.__struct_fields__, width), Backlash)
    ),
)


@settings(max_examples=60)
@given(parameters, st.integers(0, 2**32 - 1))
def test_torques_and_motor_angles_solve_the_two_lines(parameters: ServoParameters, seed: int) -> None:
    random = np.random.default_rng(seed)
    size = len(JOINTS)
    lower, upper = (
        np.array([getattr(BODY.joints[name], end) for name in JOINTS]) for end in ("lower", "upper")
    )
    middle = 0.5 * (lower + upper)
    servo = Servo(BODY, JOINTS, parameters, middle, STEP)
    drives = [
        Drive(servo.stall[i], servo.no_load_speed[i], servo.backlash[i], parameters, middle[i])
        for i in range(size)
    ]
    position, velocity = middle.copy(), np.zeros(size)
    slots = [INDEX_WITH_MIRROR[name] for name in JOINTS]
    for k in range(60):
        if k % 10 == 0:
            request = np.zeros(N_JOINTS)
            # near the middle of each range, so that no limit of a request acts
            request[slots] = middle + random.uniform(-0.05, 0.05, size)
            stiffness = random.choice([-1.0, 0.0, 0.2, 1.0], N_JOINTS)
            servo.latch(request, stiffness)
        torque = torques(servo, position, velocity)
        expected = [
            drive.step(request[slot], stiffness[slot], position[i], velocity[i])
            for i, (drive, slot) in enumerate(zip(drives, slots, strict=True))
        ]
        np.testing.assert_allclose(torque, expected, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(servo.motor_angle, [d.theta for d in drives], rtol=0.0, atol=1e-10)
        velocity = 0.9 * velocity + random.normal(0.0, 0.5, size)
        position = position + velocity * STEP


@settings(max_examples=30)
@given(st.floats(0.01, 0.3), st.integers(0, 2**32 - 1))
def test_currents_are_the_means_of_the_torques(friction: float, seed: int) -> None:
    """Dry friction is behind the gear: the motor's current does not see it, the joint does."""
    random = np.random.default_rng(seed)
    rough, smooth = (
        Servo(BODY, JOINTS, ServoParameters(dry_friction=f), np.zeros(len(JOINTS)), STEP)
        for f in (friction, 0.0)
    )
    squares, position = np.zeros((2, len(JOINTS)))
    for _ in range(10):
        position += random.normal(0.0, 0.01, len(JOINTS))
        velocity = random.normal(0.0, 1.0, len(JOINTS))
        torque = torques(smooth, position, velocity)
        braked = torques(rough, position, velocity)
        assert np.abs(torque - braked).max() <= friction + 1e-12
        squares += torque**2 / 10.0
    rough.end_cycle()
    smooth.end_cycle()
    np.testing.assert_array_equal(rough.current(), smooth.current())
    one = JOINTS.index("LKneePitch")
    # torque constant at the joint: volts per no-load speed
    ampere = math.sqrt(squares[one]) * joint_no_load_speed(BODY, "LKneePitch") / 21.6
    assert math.isclose(float(rough.current()[one]), ampere, rel_tol=1e-12)
