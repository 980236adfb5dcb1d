"""The contract's messages as ROS 2 messages: of a running robot, and of a recording.

Frames: `odom`, in which the robot walks by its odometry; `base_footprint`, on the ground between the feet with
the heading of the walk; `Torso` and the links, named as in the exported URDF. Units and axes: REP 103.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import get_typestore

from bridge.adapters.ros.wire import DISTROS
from bridge.body import Body
from bridge.body.cameras import CAMERA_LINK, Camera, cameras
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS
from bridge.body.kinematics import LinkTransform, LinkTransforms
from bridge.body.quantities import absent_joints
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, WalkTelemetry
from bridge.planar import Pose2D
from bridge.recording.playback import read_recording
from bridge.rotations import R_pitch, quaternion
from bridge.types import Vec3

ODOM: Final = "odom"
FOOTPRINT: Final = "base_footprint"
TORSO: Final = "Torso"
JOINT_STATES, IMU, FSR, BUTTONS = "joint_states", "imu", "fsr", "buttons"
ODOMETRY, TF, DESCRIPTION = "odom", "tf", "robot_description"
TYPES: Final = {
    JOINT_STATES: "sensor_msgs/msg/JointState",
    IMU: "sensor_msgs/msg/Imu",
    FSR: "std_msgs/msg/Float32MultiArray",
    BUTTONS: "sensor_msgs/msg/Joy",
    ODOMETRY: "nav_msgs/msg/Odometry",
    TF: "tf2_msgs/msg/TFMessage",
    DESCRIPTION: "std_msgs/msg/String",
}
"""Topic -> type of its messages."""
IMAGE, CAMERA_INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
MESSAGE_CYCLES: Final = {JOINT_STATES: 1, IMU: 1, FSR: 2, BUTTONS: 10, ODOMETRY: 2, TF: 2}
"""Cycles of the robot from one message to the next."""
_FOREVER: Final = QosTime(9223372036, 854775807)
"""ROS 2's infinite duration."""
_QOS: Final = Qos(
    QosHistory.KEEP_LAST,
    10,
    QosReliability.RELIABLE,
    QosDurability.VOLATILE,
    _FOREVER,
    _FOREVER,
    QosLiveliness.AUTOMATIC,
    _FOREVER,
    avoid_ros_namespace_conventions=False,
)
_LATCHED: Final = _QOS._replace(depth=1, durability=QosDurability.TRANSIENT_LOCAL)
"""Quality of service of the description, which a later node receives too, as of the live topics (`wire.py`)."""
_UNKNOWN_COVARIANCE: Final = np.zeros(9)
"""An unknown covariance (REP of sensor_msgs)."""


_OPTICAL_AXES: Final = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""x of a picture to the right, y down, z along the camera's axis (REP 103)."""


def optical_frame(camera: Camera) -> str:
    """Name of a camera's frame with z along its axis."""
    return f"{camera.name}_optical_frame"


def _optical_frame(camera: Camera) -> LinkTransform:
    turn = quaternion(R_pitch(camera.pitch) @ _OPTICAL_AXES)
    return LinkTransform(CAMERA_LINK, optical_frame(camera), camera.place, turn)


class RosMessage(NamedTuple):
    """One message for a topic."""

    topic: str
    message: Any


class RosMessages:
    """Converts the messages of one robot to ROS messages.

    Args:
        body: data sheet of the robot.
        store: types, see `rosbags.typesys`.
    """

    def __init__(self, body: Body, store: Any) -> None:
        self._types = store.types
        self._links = LinkTransforms(body)
        absent = set(absent_joints(body))
        self._joints = [j for j in (*JOINTS, "RHipYawPitch") if j not in absent]
        self._slots = [INDEX_WITH_MIRROR[joint] for joint in self._joints]
        self._cameras = cameras(body)
        self._optical = [_optical_frame(camera) for camera in self._cameras]
        self._last: SensorFrame | None = None
        self._place: Vec3 = (0.0, 0.0, 0.0)
        self._last_place: tuple[float, Vec3] | None = None

    def make(self, type_name: str, **fields: Any) -> Any:
        """A message.

        Args:
            type_name: as `std_msgs/msg/String`.
            fields: all of its fields.
        """
        return self._types[type_name](**fields)

    def telemetry(self, message: WalkTelemetry) -> None:
        """Take the walker's odometry, for the following frames."""
        self._place = message.place

    def of_frame(self, frame: SensorFrame, stamp: int) -> Iterator[RosMessage]:
        """The messages of one cycle.

        Args:
            frame: of the robot.
            stamp: its time, ns.
        """
        due = {topic for topic, every in MESSAGE_CYCLES.items() if frame.seq % every == 0}
        if self._last is not None and frame.touch != self._last.touch:
            due.add(BUTTONS)
        if JOINT_STATES in due:
            yield RosMessage(JOINT_STATES, self._joint_states(frame, stamp))
        if IMU in due:
            yield RosMessage(IMU, self._imu(frame, stamp))
        if FSR in due:
            yield RosMessage(FSR, self._fsr(frame))
        if BUTTONS in due:
            yield RosMessage(BUTTONS, self._buttons(frame, stamp))
        if ODOMETRY in due:
            yield RosMessage(ODOMETRY, self._odometry(frame, stamp))
        if TF in due:
            yield RosMessage(TF, self._tf(frame, stamp))
        self._last = frame

    def description(self, urdf: str) -> RosMessage:
        """The robot's URDF."""
        return RosMessage(DESCRIPTION, self.make(TYPES[DESCRIPTION], data=urdf))

    def _header(self, stamp: int, frame: str) -> Any:
        seconds, nanoseconds = divmod(stamp, 1_000_000_000)
        time = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
        return self.make("std_msgs/msg/Header", stamp=time, frame_id=frame)

    def _vector(self, values: Sequence[float]) -> Any:
        x, y, z = values
        return self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def _quaternion(self, values: Sequence[float]) -> Any:
        x, y, z, w = values
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def _joint_states(self, frame: SensorFrame, stamp: int) -> Any:
        """Angles, speeds since the last frame, and currents as efforts."""
        position = np.array(frame.position)[self._slots]
        velocity = np.zeros(len(position))
        if self._last is not None and frame.time > self._last.time:
            before = np.array(self._last.position)[self._slots]
            velocity = (position - before) / (frame.time - self._last.time)
        return self.make(
            TYPES[JOINT_STATES],
            header=self._header(stamp, ""),
            name=self._joints,
            position=position,
            velocity=velocity,
            effort=np.zeros(0),
        )

    def _imu(self, frame: SensorFrame, stamp: int) -> Any:
        (roll, pitch), half = frame.angle, 0.5
        cr, sr, cp, sp = (
            math.cos(half * roll),
            math.sin(half * roll),
            math.cos(half * pitch),
            math.sin(half * pitch),
        )
        return self.make(
            TYPES[IMU],
            header=self._header(stamp, TORSO),
            orientation=self._quaternion((sr * cp, cr * sp, -sr * sp, cr * cp)),
            orientation_covariance=_UNKNOWN_COVARIANCE,
            angular_velocity=self._vector(frame.gyroscope),
            angular_velocity_covariance=_UNKNOWN_COVARIANCE,
            linear_acceleration=self._vector(frame.accelerometer),
            linear_acceleration_covariance=_UNKNOWN_COVARIANCE,
        )

    def _fsr(self, frame: SensorFrame) -> Any:
        size = self.make(
            "std_msgs/msg/MultiArrayDimension", label="LFL LFR LRL LRR RFL RFR RRL RRR", size=8, stride=8
        )
        layout = self.make("std_msgs/msg/MultiArrayLayout", dim=[size], data_offset=0)
        return self.make(TYPES[FSR], layout=layout, data=np.array(frame.fsr, dtype=np.float32))

    def _buttons(self, frame: SensorFrame, stamp: int) -> Any:
        pressed = np.array([value > 0.0 for value in frame.touch], dtype=np.int32)
        return self.make(
            TYPES[BUTTONS],
            header=self._header(stamp, TORSO),
            axes=np.zeros(0, dtype=np.float32),
            buttons=pressed,
        )

    def _odometry(self, frame: SensorFrame, stamp: int) -> Any:
        x, y, yaw = self._place
        point = self.make("geometry_msgs/msg/Point", x=x, y=y, z=0.0)
        turn = self._quaternion((0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)))
        pose = self.make("geometry_msgs/msg/Pose", position=point, orientation=turn)
        vx, vy, wz = self._velocity(frame.time)
        twist = self.make(
            "geometry_msgs/msg/Twist", linear=self._vector((vx, vy, 0.0)), angular=self._vector((0.0, 0.0, wz))
        )
        unknown = np.zeros(36)
        return self.make(
            TYPES[ODOMETRY],
            header=self._header(stamp, ODOM),
            child_frame_id=FOOTPRINT,
            pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=unknown),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=unknown),
        )

    def _velocity(self, now: float) -> Vec3:
        """Velocity of the footprint in its own frame since the last odometry, m/s, m/s, rad/s."""
        before, self._last_place = self._last_place, (now, self._place)
        if before is None or not now > before[0]:
            return 0.0, 0.0, 0.0
        passed, (x, y, yaw), (x0, y0, yaw0) = now - before[0], self._place, before[1]
        ahead, left = Pose2D(yaw=yaw).local(x - x0, y - y0)
        return ahead / passed, left / passed, math.remainder(yaw - yaw0, math.tau) / passed

    def _tf(self, frame: SensorFrame, stamp: int) -> Any:
        x, y, yaw = self._place
        walked = LinkTransform(
            ODOM, FOOTPRINT, (x, y, 0.0), (0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))
        )
        torso = self._links.torso_over_feet(FOOTPRINT, frame.position, frame.angle)
        transforms = [walked, torso, *self._links.of_joints(frame.position), *self._optical]
        return self.make(TYPES[TF], transforms=[self._transform(t, stamp) for t in transforms])

    def _transform(self, transform: LinkTransform, stamp: int) -> Any:
        return self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(stamp, transform.parent),
            child_frame_id=transform.child,
            transform=self.make(
                "geometry_msgs/msg/Transform",
                translation=self._vector(transform.translation),
                rotation=self._quaternion(transform.rotation),
            ),
        )

    def image(self, camera: int, width: int, pixels: bytes, stamp: int) -> tuple[Any, Any]:
        """A picture and its camera's parameters.

        Args:
            camera: 0 top, 1 bottom.
            width: columns; three rows for four columns.
            pixels: red, green and blue of each, row by row from above.
            stamp: its time, ns.
        """
        sheet, height = self._cameras[camera], 3 * width // 4
        header = self._header(stamp, optical_frame(sheet))
        picture = self.make(
            IMAGE,
            header=header,
            height=height,
            width=width,
            encoding="rgb8",
            is_bigendian=0,
            step=3 * width,
            data=np.frombuffer(pixels, dtype=np.uint8),
        )
        fx, fy = (0.5 * n / math.tan(0.5 * a) for n, a in zip((width, height), sheet.field, strict=True))
        cx, cy = 0.5 * (width - 1), 0.5 * (height - 1)
        info = self.make(
            CAMERA_INFO,
            header=header,
            height=height,
            width=width,
            distortion_model="plumb_bob",
            d=np.zeros(5),
            k=np.array([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]),
            r=np.eye(3).ravel(),
            p=np.array([fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]),
            binning_x=0,
            binning_y=0,
            roi=self.make(
                "sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
            ),
        )
        return picture, info


def write_bag(recording: Path, out: Path, body: Body, urdf: str, distro: str = "jazzy") -> dict[str, int]:
    """Write a recording as a bag (MCAP); times are robot time.

    Args:
        recording: file to read.
        out: folder to make.
        body: data sheet of the recorded robot.
        urdf: its description.
        distro: a key of `DISTROS`.

    Returns:
        Messages by topic.

    Raises:
        ConfigurationError: not a recording, or the folder is there already.
    """
    store = get_typestore(DISTROS[distro])
    messages, counts = RosMessages(body, store), dict.fromkeys(TYPES, 0)
    recorded = read_recording(recording)
    try:
        with Writer(out, version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP) as writer:
            connections = {
                topic: writer.add_connection(
                    f"/{topic}",
                    type_name,
                    typestore=store,
                    offered_qos_profiles=[_LATCHED if topic == DESCRIPTION else _QOS],
                )
                for topic, type_name in TYPES.items()
            }

            def write(topic: str, message: Any, stamp: int) -> None:
                writer.write(connections[topic], stamp, store.serialize_cdr(message, TYPES[topic]))
                counts[topic] += 1

            write(*messages.description(urdf), 0)
            for one in recorded:
                if isinstance(one.message, WalkTelemetry):
                    messages.telemetry(one.message)
                elif isinstance(one.message, SensorFrame):
                    stamp = round(1e9 * one.time)
                    for topic, message in messages.of_frame(one.message, stamp):
                        write(topic, message, stamp)
    except WriterError as error:
        raise ConfigurationError(
            f"{out}: a bag cannot be written there ({error}); give a new folder."
        ) from None
    return counts
