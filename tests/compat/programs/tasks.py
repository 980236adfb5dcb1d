"""Motions that wait for each other, arms that stop at the head, and breath."""

import math
import time

from naoqi import ALProxy

motion = ALProxy("ALMotion", "nao.local", 9559)
motion.setStiffnesses("Body", 1.0)


def wait(condition):
    """Until it is true, for some minutes at most."""
    for _ in range(3000):
        if condition():
            break
        time.sleep(0.05)


motion.post.angleInterpolation("HeadYaw", 0.4, 60.0, True)
wait(motion.getTaskList)
motion.post.angleInterpolation("HeadYaw", -0.3, 0.5, True)
wait(lambda: len(motion.getTaskList()) == 2 and motion.getAngles("HeadYaw", True)[0] > 0.0)
tasks = motion.getTaskList()
print("tasks", [task[0] for task in tasks], motion.getAngles("HeadYaw", True)[0] > 0.0)
motion.killTask(tasks[0][1])
wait(lambda: not motion.getTaskList())
print("then", round(motion.getAngles("HeadYaw", True)[0], 1), motion.getTaskList())

into_head = [math.radians(angle) for angle in (-50, 6, 0, -85, 0, 0)]
for protected in (True, False):
    motion.setCollisionProtectionEnabled("LArm", protected)
    motion.angleInterpolationWithSpeed("LArm", into_head, 0.8)
    wait(lambda: motion.isCollision("LArm") == ("near" if protected else "collision"))  # noqa: B023
    print("arm", protected, motion.isCollision("LArm"))

motion.setBreathEnabled("RArm", True)
time.sleep(2.0)
print("breathes", motion.getBreathEnabled("RArm"), motion.getBreathConfig())
