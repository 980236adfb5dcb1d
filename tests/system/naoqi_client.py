"""A program that knows only qi, run in a process of its own: `python naoqi_client.py URL`.

It makes the calls of the NAO drivers of social-interaction-cloud 2.3.0 for its requests, in their order, and
prints one JSON object.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import qi


def wait(condition: Callable[[], Any]) -> None:
    """For what takes some cycles on an idle machine."""
    for _ in range(10_000):
        if condition():
            return
        time.sleep(0.005)
    sys.exit("what was waited for has not come")


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


def main() -> None:
    session = qi.Session()
    session.connect(sys.argv[1])
    print(json.dumps(social(session)), flush=True)


if __name__ == "__main__":
    main()
