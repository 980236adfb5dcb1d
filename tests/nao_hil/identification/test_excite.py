"""The motion that shows the drives: what the guard says of it, who moves, and where it begins and ends."""

from __future__ import annotations

import numpy as np
import pytest

from bridge.body import BODIES, load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import absent_joints
from bridge.guard import Guard
from emulator.start import START_POSES
from nao_hil.arguments import actuator_frame
from nao_hil.cli.main import run
from nao_hil.identification.comparison_run import HANG
from nao_hil.identification.excitation import excitation
from tests.frames import standing_frame

LEGS = [INDEX[joint] for joint in JOINTS if "Hip" in joint or "Knee" in joint or "Ankle" in joint]


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("start", ["hang", "stand"])
def test_the_guard_lets_every_command_through(name: str, start: str) -> None:
    body = load_body(name)
    pose = START_POSES[HANG].angles if start == HANG else POSTURES["Stand"]
    commands = excitation(body, pose, 60.0, hanging=start == HANG)
    moved = np.ptp(commands, axis=0) > 0.3
    assert commands.shape == (round(60.0 / body.cycle), 25)
    assert moved[LEGS].all() if start == HANG else not np.ptp(commands[:, LEGS], axis=0).any()
    assert moved[INDEX["HeadYaw"]] and moved[INDEX["RElbowYaw"]]
    assert not moved[[INDEX[joint] for joint in absent_joints(body)]].any()
    present = [INDEX[joint] for joint in JOINTS if joint not in absent_joints(body)]
    # the hanging pose has elbows that are straighter than their range
    assert commands[-1, present] == pytest.approx(np.array(pose)[present], abs=0.035)
    guard, frame = Guard(body), standing_frame(position=pose)
    for number, position in enumerate(commands):
        wanted = actuator_frame(0, position, 1.0)
        command = guard.cycle(frame, guard.check(wanted, 0))
        assert command is not None
        changed = np.abs(np.subtract(command.position, wanted.position))[present]
        assert changed.max() < 1e-9, f"cycle {number}"


@pytest.mark.parametrize(
    ("options", "words"),
    [(("--duration", "10"), "60 s at least"), (("--start", "lie-back"), "known: hang, stand")],
)
def test_a_motion_that_there_is_not_is_refused(
    options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["excite", *options]) == 2
    assert words in capsys.readouterr().err
