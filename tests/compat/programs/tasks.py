"""Motions that wait for each other, arms that stop at the head, and breath."""

import math
import time

from naoqi import ALProxy

motion = ALProxy("ALMotion", "nao.local", 9559)
motion.setStiffnesses("Body", 1.0)

motion.post.angleInterpolation("HeadYaw", 0.4, 3.0, True)
time.sleep(0.3)
motion.post.angleInterpolation("HeadYaw", -0.3, 0.5, True)
time.sleep(0.7)
tasks = motion.getTaskList()
print("tasks", [task[0] for task in tasks], motion.getAngles("HeadYaw", True)[0] > 0.0)
motion.killTask(tasks[0][1])
time.sleep(1.5)
print("then", round(motion.getAngles("HeadYaw", True)[0], 1), motion.getTaskList())

into_head = [math.radians(angle) for angle in (-50, 6, 0, -85, 0, 0)]
for protected in (True, False):
    motion.setCollisionProtectionEnabled("LArm", protected)
    motion.angleInterpolationWithSpeed("LArm", into_head, 0.8)
    time.sleep(0.2)
    print("arm", protected, motion.isCollision("LArm"))

motion.setBreathEnabled("RArm", True)
time.sleep(2.0)
print("breathes", motion.getBreathEnabled("RArm"), motion.getBreathConfig())
