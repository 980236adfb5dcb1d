"""Recordings as ROS 2 bags, by the same messages as a running robot's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import get_typestore

from bridge.adapters.ros.messages import TYPES, RosMessages
from bridge.adapters.ros.wire import DISTROS
from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, WalkTelemetry
from bridge.recording.playback import read_recording


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
                topic: writer.add_connection(f"/{topic}", type_name, typestore=store)
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
