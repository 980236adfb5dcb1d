"""Programs that know only qi, run in a process of their own: `python naoqi_clients.py NAME URL`.

Each prints one JSON object. The calls of `social` are those that the NAO drivers of social-interaction-cloud
2.3.0 make for its requests, in their order; those of `samples` are the vendor's public motion samples', through
a stand-in for `naoqi.ALProxy`.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import qi

RED = "ChestBoard/Led/Red/Actuator/Value"
PREFIX = "Device/SubDeviceList/"


def wait(condition: Callable[[], Any]) -> None:
    """For what takes some cycles on an idle machine."""
    for _ in range(10_000):
        if condition():
            return
        time.sleep(0.005)
    sys.exit("what was waited for has not come")


def wait_until(dcm: Any, moment: int) -> None:
    wait(lambda: dcm.getTime(0) >= moment)


def in_time(dcm: Any, *commands: Callable[[int], list[Any]]) -> int:
    """Send commands before the first of their times, anew if the machine was busy; the time they refer to."""
    for _ in range(100):
        begin: int = dcm.getTime(0) + 60
        for make in commands:
            dcm.setAlias(make(begin))
        if dcm.getTime(0) < begin + 40:
            return begin
    sys.exit("no two commands come within 100 ms")


def dcm_program(session: Any) -> dict[str, Any]:
    """createAlias, set, and both forms of setAlias with all four update types; what each led to."""
    dcm, memory = session.service("DCM"), session.service("ALMemory")
    names = [PREFIX + RED, "ChestBoard/Led/Green/Actuator/Value", "Nothing/Actuator/Value"]
    result: dict[str, Any] = {"alias": dcm.createAlias(["Leds", names]), "prefix": dcm.getPrefix()}
    for form in ("time-separate", "time-mixed"):
        for update in ("Merge", "ClearAll", "ClearAfter", "ClearBefore"):
            begin = in_time(
                dcm,
                lambda begin: command("ClearAll", form, [begin + 40, begin + 80], [0.25, 0.5]),  # noqa: B023
                lambda begin: command(update, form, [begin + 60], [1.0]),  # noqa: B023
            )
            wait_until(dcm, begin + 150)
            result[f"{form} {update}"] = memory.getData(PREFIX + RED)
            dcm.set(["Leds", "ClearAll", [[0.0, dcm.getTime(0)]]])
            wait_until(dcm, begin + 190)
    now = dcm.getTime(0)
    dcm.setAlias("Leds", now, [0.5, 0.25, 0.0])
    wait_until(dcm, now + 40)
    result["overload"] = memory.getListData([PREFIX + RED, names[1]])
    result["refused"] = refusal(lambda: dcm.setAlias(["Leds", "Sometimes", "time-mixed", []]))
    result["no list"] = [refusal(lambda value=value: dcm.setAlias(value)) for value in (None, 5, True, "Leds")]
    return result


def command(update: str, form: str, times: list[int], values: list[float]) -> list[Any]:
    """One command for the red LED of the alias `Leds`."""
    if form == "time-separate":
        return ["Leds", update, form, 0, times, [values, [0.0] * len(times), [0.0] * len(times)]]
    pairs = [[value, moment] for value, moment in zip(values, times, strict=True)]
    return ["Leds", update, form, [pairs, [[0.0, times[0]]], []]]


def refusal(call: Any) -> str:
    try:
        call()
    except RuntimeError as error:
        return str(error)
    return ""


def social(session: Any) -> dict[str, Any]:
    """Motion, stiffness, recorder, autonomous abilities, LEDs and buttons, as their drivers call them."""
    motion, posture = session.service("ALMotion"), session.service("ALRobotPosture")
    model, memory = session.service("ALRobotModel"), session.service("ALMemory")
    result: dict[str, Any] = {"type": model.getRobotType()}
    arm = ["LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand"]
    motion.setStiffnesses(arm, 0.6)
    wait(lambda: max(abs(s - 0.6) for s in motion.getStiffnesses(arm)) < 1e-3)  # it is sent with the next cycle
    result["stiffness"] = motion.getStiffnesses(arm)
    before = motion.getAngles(arm, False)
    motion.setAngles(arm, [1.2, *before[1:]], 0.75)
    wait(lambda: abs(motion.getAngles(arm, True)[0] - 1.2) < 1e-3)
    recorded = motion.getAngles(arm, True)
    times = [[0.1, 0.2]] * len(arm)
    motion.angleInterpolation(arm, [[angle, angle + 0.01] for angle in recorded], times, True)
    result["angles"] = motion.getAngles(arm, True)
    motion.setSmartStiffnessEnabled(True)
    result["smart"] = motion.getSmartStiffnessEnabled()
    motion.setIdlePostureEnabled("Body", False)
    motion.setBreathEnabled("Body", False)
    motion.setExternalCollisionProtectionEnabled("All", True)
    motion.setMoveArmsEnabled(False, False)
    result["velocity"] = motion.getRobotVelocity()
    result["posture"] = posture.goToPosture("StandInit", 0.8)
    result["sideways"] = refusal(lambda: motion.moveTo(0.0, 0.2, 0.0))
    for name in ("Blinking",):
        session.service(f"ALAutonomous{name}").setEnabled(False)
    for name in ("ALBackgroundMovement", "ALListeningMovement", "ALSpeakingMovement", "ALBasicAwareness"):
        session.service(name).setEnabled(False)
    result["life"] = session.service("ALAutonomousLife").getState()
    leds = session.service("ALLeds")
    leds.fadeRGB("FaceLeds", 1.0, 0.5, 0.0, 0.1)
    leds.setIntensity("ChestLeds", 0.5)
    result["intensity"] = leds.getIntensity("ChestLeds")
    touched: list[Any] = []
    subscriber = memory.subscriber("TouchChanged")
    subscriber.signal.connect(touched.append)
    print("subscribed", flush=True)
    for _ in range(2000):
        if touched:
            break
        time.sleep(0.01)
    result["touched"] = touched[:1]
    motion.rest()
    result["rested"] = [posture.getPosture(), motion.robotIsWakeUp()]
    motion.wakeUp()
    result["woke"] = [posture.getPosture(), motion.robotIsWakeUp()]
    return result


class ALProxy:
    """`naoqi.ALProxy` over qi: calls, and `post` for calls that do not wait."""

    def __init__(self, name: str, session: Any) -> None:
        self._service = session.service(name)
        self.post = Post(self._service)

    def __getattr__(self, method: str) -> Any:
        return getattr(self._service, method)


class Post:
    def __init__(self, service: Any) -> None:
        self._service = service

    def __getattr__(self, method: str) -> Any:
        return lambda *arguments: getattr(self._service, method)(*arguments, _async=True)


def samples(session: Any) -> dict[str, Any]:
    """Stiffness, setAngles, changeAngles, interpolations, tasks, configuration, limits and moves."""
    motion, posture = ALProxy("ALMotion", session), ALProxy("ALRobotPosture", session)
    result: dict[str, Any] = {}
    motion.stiffnessInterpolation("Body", 1.0, 0.1)
    result["stiff"] = min(motion.getStiffnesses("Body"))
    result["reached"] = posture.goToPosture("StandInit", 0.5)
    names, angles = "Body", motion.getAngles("Body", True)
    motion.setAngles(names, angles, 0.2)
    motion.setAngles(["HeadYaw", "HeadPitch"], [0.3, -0.3], 0.2)
    wait(lambda: abs(motion.getAngles("Head", True)[1] + 0.3) < 1e-3)
    result["set"] = motion.getAngles("Head", False)
    motion.changeAngles("HeadYaw", -0.25, 0.2)
    wait(lambda: abs(motion.getAngles("HeadYaw", True)[0] - 0.05) < 1e-3)
    result["changed"] = motion.getAngles("HeadYaw", False)
    motion.angleInterpolation("HeadYaw", 0.5, 0.2, True)
    motion.angleInterpolation("HeadYaw", [0.2, 0.0], [0.2, 0.4], True)
    joints = ["HeadYaw", "HeadPitch"]
    began = time.monotonic()
    motion.angleInterpolation(joints, [[0.2, 0.0], [-0.2, 0.2, 0.0]], [[0.2, 0.4], [0.1, 0.2, 0.6]], True)
    result["took"] = time.monotonic() - began
    motion.angleInterpolationWithSpeed("Head", [0.1, 0.1], 0.3)
    result["with speed"] = motion.getAngles("Head", False)
    running = motion.post.angleInterpolation("HeadYaw", 1.0, 5.0, True)
    motion.killTasksUsingResources(["HeadYaw"])
    running.wait(5000)
    result["killed"] = motion.getAngles("HeadYaw", True)
    result["config"] = dict(zip(*motion.getRobotConfig(), strict=True))
    result["limits"] = motion.getLimits("LShoulderRoll")
    result["summary"] = motion.getSummary().splitlines()[0]
    result["turn"] = refusal(lambda: motion.moveToward(0.0, 0.0, 0.5))
    result["unknown"] = refusal(lambda: motion.animation())
    result["version"] = session.service("ALSystem").systemVersion()
    result["body type"] = session.service("ALMemory").getData("RobotConfig/Body/Type")
    return result


PROGRAMS = {"dcm": dcm_program, "social": social, "samples": samples}


def main() -> None:
    session = qi.Session()
    session.connect(sys.argv[2])
    print(json.dumps(PROGRAMS[sys.argv[1]](session)), flush=True)


if __name__ == "__main__":
    main()
