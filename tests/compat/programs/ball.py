"""Detection of the red ball by its event, and a tracker that follows it with the head."""

import math
import time

from naoqi import ALProxy

IP, PORT = "nao.local", 9559
memory, detection = ALProxy("ALMemory", IP, PORT), ALProxy("ALRedBallDetection", IP, PORT)
detection.setActiveCamera(1)
detection.subscribe("Test_RedBall", 100, 0.0)
value = []
for _ in range(3000):
    value = memory.getData("redBallDetected")
    if value and isinstance(value, list) and len(value) >= 2:
        break
    time.sleep(0.05)
detection.unsubscribe("Test_RedBall")
center_x, center_y, size_x, _ = value[1]
print("ball left", 0.0 < center_x < 0.3, "below", abs(center_y) < 0.5, "size", 0.04 < size_x < 0.2, value[4])

motion, tracker = ALProxy("ALMotion", IP, PORT), ALProxy("ALTracker", IP, PORT)
tracker.registerTarget("RedBall", 0.06)
tracker.setMode("Head")
tracker.track("RedBall")
near = False
for _ in range(3000):  # seconds on an idle machine
    place = tracker.getTargetPosition(0)
    yaw, pitch = motion.getAngles(["HeadYaw", "HeadPitch"], True)
    near = len(place) == 3 and abs(yaw - math.atan2(0.05, 0.35)) < 0.02 and pitch > 0.2
    if near and not tracker.isTargetLost():
        break
    time.sleep(0.05)
print("followed", near, [round(x, 2) for x in place])
print("lost", tracker.isTargetLost(), "active", tracker.isActive(), tracker.getActiveTarget())
tracker.stopTracker()
tracker.unregisterAllTargets()
