"""What LoLA's messages hold: keys, their order on the wire, and lengths.

LoLA is the server on a unix stream socket of the robot. Every 12 ms it sends one msgpack map of sensor values;
a client answers with maps of any of the actuator keys. Joints are in the order of `bridge.body.joints.JOINTS`.
Source: the vendor's page on LoLA (NAOqi SDK 2.8.5) and two captured packets of V6 robots.
"""

from __future__ import annotations

from typing import Final

from bridge.body.joints import N_JOINTS

CYCLE: Final = 0.012
"""s (confirmed: vendor's page on LoLA)."""

DEFAULT_SOCKET: Final = "/tmp/robocup"
"""Of the robot (confirmed: every team's code)."""

SENSOR_BYTES: Final = 896
"""Length of every sensor packet (confirmed: teams read exactly that many)."""

IDENTIFIERS: Final = 4
"""Elements of `RobotConfig`: body id (20 characters) and version, head id and version."""

SENSORS: Final = {
    "RobotConfig": IDENTIFIERS,
    "Accelerometer": 3,
    "Angles": 2,
    "Battery": 4,
    "Current": N_JOINTS,
    "FSR": 8,
    "Gyroscope": 3,
    "Position": N_JOINTS,
    "Sonar": 2,
    "Stiffness": N_JOINTS,
    "Temperature": N_JOINTS,
    "Touch": 14,
    "Status": N_JOINTS,
}
"""Length of each array, in the order of the wire; float 32 but for `RobotConfig` (text) and `Status` (int)."""

ACTUATORS: Final = {
    "Position": N_JOINTS,
    "Stiffness": N_JOINTS,
    "REar": 10,
    "LEar": 10,
    "Chest": 3,
    "LEye": 24,
    "REye": 24,
    "LFoot": 3,
    "RFoot": 3,
    "Skull": 12,
    "Sonar": 2,
}
"""Length of each array; all are float 32 but `Sonar` (bool). A map may hold any of them in any order."""
