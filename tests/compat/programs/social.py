"""Calls of the NAO drivers of social-interaction-cloud 2.3.0 for its requests, in their order."""

import sys
import time

import qi

session = qi.Session()
session.connect(sys.argv[1])
motion, posture = session.service("ALMotion"), session.service("ALRobotPosture")
print("type", session.service("ALRobotModel").getRobotType())
arm = ["LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand"]
motion.setStiffnesses(arm, 0.6)
for _ in range(3000):  # it is sent with the next cycle
    if max(abs(stiffness - 0.6) for stiffness in motion.getStiffnesses(arm)) < 0.01:
        break
    time.sleep(0.01)
print("stiffness", [round(stiffness, 2) for stiffness in motion.getStiffnesses(arm)])
before = motion.getAngles(arm, False)
motion.setAngles(arm, [1.2, *before[1:]], 0.75)
for _ in range(3000):
    if abs(motion.getAngles(arm, True)[0] - 1.2) < 0.005:
        break
    time.sleep(0.05)
recorded = motion.getAngles(arm, True)
motion.angleInterpolation(arm, [[angle, angle + 0.01] for angle in recorded], [[0.1, 0.2]] * len(arm), True)
print("angle", round(motion.getAngles(arm, True)[0], 2))
motion.setSmartStiffnessEnabled(True)
motion.setIdlePostureEnabled("Body", False)
motion.setBreathEnabled("Body", False)
motion.setExternalCollisionProtectionEnabled("All", True)
motion.setMoveArmsEnabled(False, False)
print("smart", motion.getSmartStiffnessEnabled(), motion.getRobotVelocity())
print("posture", posture.goToPosture("StandInit", 0.8))
try:
    motion.moveTo(0.0, 0.2, 0.0)
except RuntimeError as error:
    print("sideways", "straight only" in str(error))
blinking = ["ALAutonomousBlinking", "ALBackgroundMovement", "ALListeningMovement", "ALSpeakingMovement"]
for name in [*blinking, "ALBasicAwareness"]:
    session.service(name).setEnabled(False)
leds = session.service("ALLeds")
leds.fadeRGB("FaceLeds", 1.0, 0.5, 0.0, 0.1)
leds.setIntensity("ChestLeds", 0.5)
print("intensity", round(leds.getIntensity("ChestLeds"), 2))
motion.rest()
print("rested", posture.getPosture(), motion.robotIsWakeUp())
motion.wakeUp()
print("woke", posture.getPosture(), motion.robotIsWakeUp())
