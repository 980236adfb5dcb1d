"""Transforms by almath, an arm along a path, the head's camera, and poses on the floor."""

import sys

import almath
import motion
from naoqi import ALProxy


def main(robot_ip):
    proxy = ALProxy("ALMotion", robot_ip, 9559)
    effector, frame = "LArm", motion.FRAME_TORSO
    start = almath.Transform(proxy.getTransform(effector, frame, False))
    target = almath.Transform(start)
    target.r1_c4 += 0.03
    target.r3_c4 += 0.03
    proxy.transformInterpolations([effector], frame, [list(target.toVector())], [motion.AXIS_MASK_VEL], [[0.5]])
    reached = almath.Transform(proxy.getTransform(effector, frame, False))
    error = almath.position3DFromTransform(reached) - almath.position3DFromTransform(target)
    print("near", error.norm() < 0.003)
    camera = almath.Transform(proxy.getTransform("CameraTop", motion.FRAME_ROBOT, True))
    print("camera up", 0.3 < camera.r3_c4 < 0.6)
    begin = almath.Pose2D(proxy.getRobotPosition(False))
    moved = almath.pose2DInverse(begin) * almath.Pose2D(proxy.getRobotPosition(False))
    print("moved", moved.toVector())
    print("half turn", round(almath.modulo2PI(3.0 * almath.PI) * almath.TO_DEG))


if __name__ == "__main__":
    main(sys.argv[1])
