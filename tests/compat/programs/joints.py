# ruff: noqa: UP031
"""Stiffness, targets, interpolations and readings of joints, through proxies."""

import sys
import time

from naoqi import ALProxy


def main(robot_ip, port=9559):
    motion = ALProxy("ALMotion", robot_ip, port)
    posture = ALProxy("ALRobotPosture", robot_ip, port)
    motion.wakeUp()
    posture.goToPosture("StandInit", 0.8)
    names = ["HeadYaw", "HeadPitch"]
    motion.setStiffnesses("Head", 1.0)
    motion.setAngles(names, [0.3, -0.2], 0.3)
    for _ in range(3000):
        if abs(motion.getAngles(names, True)[0] - 0.3) < 0.01:
            break
        time.sleep(0.05)
    print("set %.1f %.1f" % tuple(motion.getAngles(names, True)))
    motion.angleInterpolation(names, [[0.0, 0.2], [0.1]], [[0.2, 0.5], [0.5]], True)
    print("through %.1f %.1f" % tuple(motion.getAngles(names, True)))
    motion.angleInterpolationWithSpeed("Head", [0.0, 0.0], 0.5)
    task = motion.post.angleInterpolation("HeadYaw", 1.0, 60.0, True)
    print("runs", motion.isRunning(task))
    motion.stop(task)
    for _ in range(3000):
        if not motion.isRunning(task):
            break
        time.sleep(0.05)
    print("runs", motion.isRunning(task))
    print("limits", len(motion.getLimits("Body")), "names", len(motion.getBodyNames("Body")))
    motion.openHand("LHand")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1")
