"""Least squares of the emulator's drives on a recording, with intervals that allow for the model's errors.

The model has one joint at a time. A sample counts while the joint's own command moves, or has just moved, and
no other one of the same limb does. Fast motion counts for few joints: whoever shakes a leg or an arm moves all
its joints, which the model leaves out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.optimize import least_squares
from scipy.stats import norm
from scipy.stats import t as student

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX, LEG_JOINTS, TORSO
from bridge.errors import ConfigurationError
from bridge.types import Array
from emulator.servo.parameters import Backlash, ServoParameters
from nao_hil.identification import measures
from nao_hil.identification.readings import Signals, hangs
from nao_hil.identification.servo_model import ServoModel

AFTER: Final = 0.7
"""Time for which a joint is watched after its command has moved, s."""
FAST: Final = 0.6
"""Speed of a command from which on motion is fast, rad/s."""
QUICK: Final = ("HeadYaw", "HeadPitch", "AnklePitch", "AnkleRoll")
"""Joints whose fast motion counts: with it the model is as near to the engine's robot as in slow motion, the
rounding of the encoder (measured; with ElbowRoll and ElbowYaw it is ten times as far off, because a forearm
stops somewhere within its backlash; WristYaw is taken to be like them)."""
_EPSILON: Final = 1e-7
_STEADY: Final = 0.02
"""Change of the stiffness that does not matter."""
LEGS: Final = frozenset(joint for joints in LEG_JOINTS.values() for joint in joints)
"""Not used while they carry the robot."""


def useful(body: Body, signals: Signals, joints: Sequence[str]) -> NDArray[np.bool_]:
    """Samples that count, (n, joints)."""
    columns = [INDEX[joint] for joint in joints]
    command, position = signals.command[:, columns], signals.position[:, columns]
    way = np.abs(np.diff(np.nan_to_num(command), axis=0, prepend=np.nan_to_num(command[:1])))
    moving = _lately(way, signals.cycle) > _EPSILON
    fast = _lately(way, signals.cycle) > FAST * signals.cycle
    limbs = [_limb(body, joint) for joint in joints]
    stiffness = signals.stiffness[:, columns]
    steady = np.abs(stiffness - np.median(stiffness, axis=0)) < _STEADY
    counted = moving & steady & np.isfinite(command) & np.isfinite(position) & signals.measured[:, None]
    if hangs(body, signals) is False:
        counted[:, [i for i, joint in enumerate(joints) if joint in LEGS]] = False
    for i, joint in enumerate(joints):
        others = [k for k in range(len(joints)) if k != i and limbs[i] & limbs[k]]
        counted[:, i] &= ~moving[:, others].any(axis=1)
        if not joint.endswith(QUICK):
            counted[:, i] &= ~fast[:, i]
    return np.asarray(counted)


def stretches(samples: NDArray[np.bool_], longest: int) -> NDArray[np.int64]:
    """Number of the unbroken stretch of each sample that counts, all joints together; -1 for the others.

    Args:
        samples: (n, joints)
        longest: Samples after which another stretch begins.
    """
    rows = np.arange(len(samples))[:, None]
    starts = samples & ~np.vstack([np.zeros_like(samples[:1]), samples[:-1]])
    since = rows - np.maximum.accumulate(np.where(starts, rows, 0), axis=0)
    starts = samples & (since % longest == 0)
    numbers = np.cumsum(starts.ravel(order="F")).reshape(samples.shape, order="F") - 1
    return np.where(samples, numbers, -1)


def _lately(way: Array, cycle: float) -> Array:
    """The largest way of a cycle in the last `AFTER`."""
    size = round(AFTER / cycle)
    return np.asarray(maximum_filter1d(way, size, axis=0, origin=(size - 1) // 2, mode="nearest"))


def _limb(body: Body, joint: str) -> frozenset[str]:
    """Names of the limbs that this joint moves: its own; the motor of both hips moves two."""
    if joint == "LHipYawPitch":
        return frozenset({"LHipYawPitch", "RHipYawPitch"})
    tree = joint_tree(body)
    while tree[joint].parent != TORSO:
        joint = tree[joint].parent
    return frozenset({joint})


class ParameterKind(NamedTuple):
    """A fitted parameter that all joints share, or that each group of joints has."""

    change: float
    """By which derivatives are taken, SI units and radians; also its scale."""
    most: float
    """Upper bound of the search."""
    model_error: float
    """Standard deviation of the model's own error, invisible in the residuals; a fraction but for `ABSOLUTE`.
    Three robots' `model_error` of `python -m tests.bench experiments.calibration` times 1.6, by which the t
    distribution with 3 degrees of freedom is wider than the normal; backlash: RMS of HipYawPitch, the worst."""
    unit: str
    """For people."""
    least: float = 0.0
    """Lower bound of the search."""


KINDS: Final = {
    "delay": ParameterKind(5e-4, 0.15, 7e-4, "ms"),
    "full_voltage_error": ParameterKind(1e-3, 1.0, 0.02, "rad", least=0.005),
    "gear_compliance": ParameterKind(1e-4, 0.1, 0.05, "rad/(N m)"),
    "dry_friction": ParameterKind(5e-4, 1.0, 0.004, "N m"),
    "lead": ParameterKind(5e-4, 0.05, 1.2e-4, "ms"),
    "motor_time_constant": ParameterKind(5e-4, 0.05, 0.05, "ms", least=1e-4),
    "gear_relaxation": ParameterKind(1e-3, 0.1, 0.06, "ms"),
    "backlash": ParameterKind(5e-4, 0.2, 2e-4, "deg"),
}
"""By name, the groups' last."""
GLOBAL: Final = tuple(KINDS)[:-1]
"""Fitted parameters that all joints share."""
ABSOLUTE: Final = ("backlash", "delay", "lead")
"""Kinds of parameters whose model error is in rad and s."""
_BEGINNING: Final = 120.0
"""Part of a longer recording that the search begins with, s; in it, `nao-hil excite` moves every joint."""
_ROUGH: Final = 1e-3
"""Tolerance of the search on the beginning."""
_FINE: Final = 1e-4
"""Tolerance of the search on the whole."""
_ZERO: Final = 0.05
"""Largest zero error of an encoder that is looked for, rad."""
_ENOUGH: Final = 2.0
"""Time that a group's joints must have moved alone, s."""
_IDEAL: Final = 0.95
"""Share of the drives' residual below which a delay alone explains the angles better."""
_ROUNDING: Final = 1.5
"""Residuals of this many standard deviations of the encoders' rounding are a good fit."""
_ROBUST: Final = 3.0
"""Residuals beyond this many steps of the encoder count less than squared."""
_STRETCH: Final = 4.0
"""Longest stretch whose residuals are taken for alike, s."""
CONFIDENCE: Final = 0.95


@dataclass(frozen=True)
class Fit:
    """The parameters that fit best."""

    servo: ServoParameters
    names: tuple[str, ...]
    """Names of the fitted parameters: `delay`, ..., `backlash.KneePitch`."""
    values: Array
    """(p,), SI and radians."""
    covariance: Array
    """(p, p)"""
    freedom: Array
    """Degrees of freedom of each value's t distribution, (p,)."""
    joints: tuple[str, ...]
    """Columns of the following."""
    predicted: Array
    """Angles of the model, (n, joints), the encoders' zeros included, rad."""
    samples: Array
    """Those that counted, (n, joints), as numbers."""

    @property
    def _model_error(self) -> Array:
        """Standard deviation of the model's own error of each value, (p,)."""
        kinds = [name.partition(".")[0] for name in self.names]
        scales = np.where(np.isin(kinds, ABSOLUTE), 1.0, self.values)
        return np.asarray(scales * [KINDS[kind].model_error for kind in kinds])

    def interval(self, value: float, gradient: Array) -> tuple[float, float]:
        """Interval of a function of the parameters, with a confidence of `CONFIDENCE`.

        Args:
            value: Of the function.
            gradient: By the parameters, (p,).
        """
        level = 0.5 + 0.5 * CONFIDENCE
        used = np.abs(gradient) > 0.0
        scatter = student.ppf(level, self.freedom[used].min()) ** 2 * (gradient @ self.covariance @ gradient)
        model = norm.ppf(level) ** 2 * np.square(gradient * self._model_error).sum()
        half = float(np.sqrt(scatter + model))
        return max(value - half, 0.0), value + half


def fit(
    body: Body, signals: Signals, base: ServoParameters, progress: Callable[[int], None] = lambda _: None
) -> Fit:
    """Fit the drives of a robot whose torso does not move.

    The residuals are the encoders'. Each joint's encoder has a zero of its own, which is fitted too. The
    covariance is the sandwich estimate over stretches of motion: effects outside of the model make
    residuals that stay alike within a stretch, and differ from one to the next.

    Args:
        body: Data sheet.
        signals: The recording; every present joint has a command.
        base: Values that are not fitted, and where the search begins.
        progress: Called with the number of simulations.

    Raises:
        ConfigurationError: nothing in the recording moves as it would have to.
    """
    problem = _Problem(body, signals, base, progress)
    if not problem.groups:
        raise ConfigurationError(
            "No joint moves by itself for two seconds in this recording; `nao-hil excite` makes one in "
            "which all do."
        )
    start = problem.start
    rows = round(_BEGINNING / signals.cycle)
    if len(signals.time) > 2 * rows:  # most of the search on the beginning, which takes less time
        beginning = _Problem(body, signals.part(slice(0, rows)), base, progress)
        if beginning.groups:
            start = problem.start_from(beginning, beginning.solve(beginning.start, _ROUGH))
    fitted = problem.conclude(problem.solve(start, _FINE))
    _require_drives(fitted, signals, 2.0 * np.pi / body.encoder_steps)
    return fitted


def _require_drives(found: Fit, signals: Signals, step: float) -> None:
    """Raises ConfigurationError where the delayed command alone is nearer to a joint's angles than the drives.

    Those of a motor never are: the fitted drives delay too, and friction, load and backlash come on top. Then
    the recording shows requests, or an ideal simulator's angles, and any backlash is the model's own error.

    Args:
        found: The fit.
        signals: The recording.
        step: Of the encoders, rad; drives that fit to within its rounding are right as they are.
    """
    rounding = _ROUNDING * step / np.sqrt(12.0)
    for column, joint in enumerate(found.joints):
        used = np.flatnonzero(found.samples[:, column])
        if not len(used):
            continue
        command, angle = signals.command[:, INDEX[joint]], signals.position[used, INDEX[joint]]
        time = used * signals.cycle
        lags = np.arange(0.0, KINDS["delay"].most, 0.5 * signals.cycle)
        cycles = np.arange(len(command)) * signals.cycle
        errors = [float(np.std(angle - np.interp(time - lag, cycles, command))) for lag in lags]
        model = float(np.sqrt(np.mean(np.square(angle - found.predicted[used, column]))))
        if model > rounding and min(errors) < _IDEAL * model:
            raise ConfigurationError(
                f"The angles of {joint} are its commands {1e3 * lags[np.argmin(errors)]:.0f} ms later, "
                f"to within {np.degrees(min(errors)):.2g} degrees, unlike a motor with a load: the recording "
                "shows the commands themselves, or joints without drives. Record the encoders' angles."
            )


class _Problem:
    """Residuals in standard deviations of the encoders' rounding, and their derivatives.

    The unknowns are the parameters by `names`, then one zero of the encoder per joint.
    """

    def __init__(
        self, body: Body, signals: Signals, base: ServoParameters, progress: Callable[[int], None]
    ) -> None:
        self._model = ServoModel(body, signals)
        self._base, self._progress, self._runs = base, progress, 0
        self._longest = round(_STRETCH / signals.cycle)
        self._last: tuple[Array, Array] = (np.empty(0), np.empty(0))
        self._joints = self._model.joints
        self._samples = useful(body, signals, self._joints)
        self._deviation = 2.0 * np.pi / body.encoder_steps / np.sqrt(12.0)
        groups = dict.fromkeys(_group(joint) for joint in self._joints)
        moved = self._samples.sum(axis=0) * signals.cycle
        self.groups = [
            group
            for group in groups
            if sum(moved[i] for i, joint in enumerate(self._joints) if _group(joint) == group) >= _ENOUGH
        ]
        self.names = (*GLOBAL, *(f"backlash.{group}" for group in self.groups))
        for i, joint in enumerate(self._joints):
            if _group(joint) not in self.groups:
                self._samples[:, i] = False
        columns = [INDEX[joint] for joint in self._joints]
        self._measured = signals.position[:, columns]
        kinds = [KINDS[name.partition(".")[0]] for name in self.names]
        zeros = [_ZERO] * len(self._joints)
        self.scale = np.array([kind.change for kind in kinds] + [self._deviation] * len(zeros))
        self.bounds = (
            np.array([kind.least for kind in kinds] + [-zero for zero in zeros]),
            np.array([kind.most for kind in kinds] + zeros),
        )
        self.start = np.array([*self._guess(signals), *np.zeros(len(zeros))])

    def _guess(self, signals: Signals) -> list[float]:
        """Where to begin: the base, and the hysteresis of each group's first joint for its backlash."""
        guess = [float(getattr(self._base, name)) for name in GLOBAL]
        for group in self.groups:
            column = INDEX[next(joint for joint in self._joints if _group(joint) == group)]
            command, position = signals.command[:, column], signals.position[:, column]
            lag = measures.delay(command, position, signals.cycle)
            width = None if lag is None else measures.hysteresis(command, position, signals.cycle, lag)
            guess.append(getattr(self._base.backlash, group) if width is None else max(width, 0.0))
        return guess

    def solve(self, start: Array, tolerance: float) -> Array:
        """The unknowns that fit best.

        Args:
            start: Where the search begins.
            tolerance: Relative change of the cost or of the unknowns that ends it.
        """
        lower, upper = self.bounds
        solution = least_squares(
            self.residuals,
            np.clip(start, lower, upper),
            self.jacobian,
            bounds=self.bounds,
            x_scale=self.scale,
            loss="soft_l1",
            f_scale=_ROBUST * np.sqrt(12.0),
            ftol=tolerance,
            xtol=tolerance,
            max_nfev=25,
        )
        return np.asarray(solution.x)

    def start_from(self, other: _Problem, x: Array) -> Array:
        """Where to begin when a part of the recording, `other`, has been solved by `x`."""
        known = dict(zip(other.names, x.tolist(), strict=False))
        own = [known.get(name, value) for name, value in zip(self.names, self.start.tolist(), strict=False)]
        return np.array([*own, *x[len(other.names) :]])

    def servo(self, x: Array) -> ServoParameters:
        """The drives of a vector of unknowns."""
        values = dict(zip(self.names, x.tolist(), strict=False))
        backlash = msgspec.to_builtins(self._base.backlash)
        backlash |= {group: values[f"backlash.{group}"] for group in self.groups}
        return msgspec.structs.replace(
            self._base, backlash=Backlash(**backlash), **{name: values[name] for name in GLOBAL}
        )

    def _angles(self, x: Array) -> Array:
        if not np.array_equal(x[: len(self.names)], self._last[0]):
            self._runs += 1
            self._progress(self._runs)
            self._last = (x[: len(self.names)].copy(), self._model.predict(self.servo(x)))
        angles: Array = self._last[1]
        return angles

    def _scaled(self, angles: Array) -> Array:
        return np.asarray(angles.T[self._samples.T] / self._deviation)

    def residuals(self, x: Array) -> Array:
        """Residuals of the samples that count, joint after joint."""
        return self._scaled(self._angles(x) + x[len(self.names) :] - self._measured)

    def jacobian(self, x: Array) -> Array:
        """By differences; all backlashes at once, because a joint has only its own."""
        before = self._angles(x)
        count = len(self.names)
        owner = np.nonzero(self._samples.T)[0]
        out = np.zeros((len(owner), len(x)))
        for column in range(len(GLOBAL)):
            moved = x.copy()
            moved[column] += self.scale[column]
            out[:, column] = self._scaled(self._angles(moved) - before) / self.scale[column]
        moved = x.copy()
        moved[len(GLOBAL) : count] += self.scale[len(GLOBAL) : count]
        change = self._scaled(self._angles(moved) - before) / KINDS["backlash"].change
        for number, joint in enumerate(self._joints):
            own = owner == number
            out[own, count + number] = 1.0 / self._deviation
            if _group(joint) in self.groups:
                out[own, len(GLOBAL) + self.groups.index(_group(joint))] = change[own]
        return out

    def conclude(self, x: Array) -> Fit:
        """The fit, with its covariance."""
        jacobian, residuals = self.jacobian(x), self.residuals(x)
        weight = 1.0 / np.sqrt(1.0 + np.square(residuals / (_ROBUST * np.sqrt(12.0))))  # soft_l1's derivative
        information = jacobian.T @ (weight[:, None] * jacobian)
        inverse_information = np.linalg.pinv(information, hermitian=True)
        number = stretches(self._samples, self._longest).T[self._samples.T]
        scores = np.zeros((number.max() + 1, len(x)))
        np.add.at(scores, number, (weight * residuals)[:, None] * jacobian)
        shares = np.zeros_like(scores)
        np.add.at(shares, number, weight[:, None] * np.square(jacobian))
        clusters = np.square(shares.sum(axis=0)) / np.maximum(np.square(shares).sum(axis=0), 1e-300)
        count = len(self.names)
        freedom = np.maximum(clusters[:count] - 1.0, 1.0)
        covariance = (inverse_information @ (scores.T @ scores) @ inverse_information)[:count, :count]
        inflation = np.sqrt((freedom + 1.0) / freedom)
        return Fit(
            servo=self.servo(x),
            names=self.names,
            values=x[:count],
            covariance=covariance * np.outer(inflation, inflation),
            freedom=freedom,
            joints=self._joints,
            predicted=self._angles(x) + x[count:],
            samples=self._samples.astype(np.float64),
        )


def _group(joint: str) -> str:
    """Key of a joint in the table of backlash."""
    return joint if joint.startswith("Head") else joint[1:]


def joints_of(group: str, joints: Sequence[str]) -> list[str]:
    """The joints of a group of both sides."""
    return [joint for joint in joints if _group(joint) == group]
