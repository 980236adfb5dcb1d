"""Timed commands: each test is in a row of the tables in docs/dcm.md.

Most use a chest LED: its integers are 1/256, so that small fractions are exact.
"""

from __future__ import annotations

import math
from typing import Any

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.dcm import Dcm
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.errors import DcmRefused

LED, GREEN, BLUE = (f"ChestBoard/Led/{colour}/Actuator/Value" for colour in ("Red", "Green", "Blue"))
US = "US/Actuator/Value"
KNEE, KNEE_HARDNESS = "LKneePitch/Position/Actuator/Value", "LKneePitch/Hardness/Actuator/Value"
MEASURED = tuple(0.01 * i for i in range(25))
START = POSTURES["Stand"]
UPDATES = ("Merge", "ClearAll", "ClearAfter", "ClearBefore")


def new_dcm(**options: int) -> Dcm:
    return Dcm(load_body("nao-v3"), START, **options)


@pytest.fixture
def dcm() -> Dcm:
    return new_dcm()


def put(dcm: Dcm, name: str, update: str, *commands: tuple[float, int]) -> None:
    """`set` with times from now, ms."""
    dcm.set(set_request([name, update, [[value, dcm.clock.shown(later)] for value, later in commands]]))


def read(dcm: Dcm, name: str) -> float:
    return dcm.read([name], MEASURED)[0]


def run(dcm: Dcm, name: str = LED, cycles: int = 1) -> list[float]:
    """What is sent to an actuator in the next cycles."""
    sent = []
    for _ in range(cycles):
        dcm.run_cycle()
        sent.append(read(dcm, name))
    return sent


def times(dcm: Dcm, name: str = LED) -> list[int]:
    """Times waiting in a buffer, ms from now."""
    return [command.time - dcm.clock.now for command in dcm.waiting(name)]


def test_set_gives_each_actuator_of_an_alias_the_same_commands(dcm: Dcm) -> None:
    dcm.create_alias(alias_request(["leds", [LED, GREEN]]))
    put(dcm, "leds", "ClearAll", (0.25, 0), (0.75, 20))
    assert dcm.waiting(LED) == dcm.waiting(GREEN)
    run(dcm, cycles=3)
    assert (read(dcm, LED), read(dcm, GREEN), read(dcm, BLUE)) == (0.75, 0.75, 0.0)


def test_an_actuator_named_twice_in_an_alias_gets_both(dcm: Dcm) -> None:
    dcm.create_alias(alias_request(["twice", [LED, LED]]))
    dcm.set_alias(set_alias_request(["twice", "Merge", "time-mixed", [[[0.5, 20]], [[1.0, 40]]]]))
    assert times(dcm) == [20, 40]
    dcm.set_alias(set_alias_request(["twice", "ClearAll", "time-mixed", [[[0.5, 20]], [[1.0, 40]]]]))
    assert times(dcm) == [40]


def test_time_separate_has_times_for_all_and_values_for_each(dcm: Dcm) -> None:
    dcm.create_alias(alias_request(["leds", [LED, GREEN]]))
    values = [[0.25, 0.5], [0.75, 1.0]]
    dcm.set_alias(set_alias_request(["leds", "ClearAll", "time-separate", 0, [0, 10], values]))
    assert run(dcm, LED) == [0.25]
    assert read(dcm, GREEN) == 0.75
    assert run(dcm, LED) == [0.5]
    assert read(dcm, GREEN) == 1.0


def test_time_mixed_has_times_and_values_for_each(dcm: Dcm) -> None:
    dcm.create_alias(alias_request(["leds", [LED, GREEN]]))
    mixed = [[[0.25, 0], [0.5, 10]], [[1.0, 20]]]
    dcm.set_alias(set_alias_request(["leds", "ClearAll", "time-mixed", mixed]))
    assert times(dcm, LED) == [0, 10]
    assert times(dcm, GREEN) == [20]


def test_importance_is_accepted_and_ignored(dcm: Dcm) -> None:
    dcm.create_alias(alias_request(["leds", [LED]]))
    dcm.set(set_request([LED, "ClearAll", [[0.5, 0, 7]]]))
    assert run(dcm) == [0.5]
    dcm.set_alias(set_alias_request(["leds", "ClearAll", "time-mixed", [[[0.25, 0, 1]]]]))
    assert run(dcm) == [0.25]
    dcm.set_alias(set_alias_request(["leds", "ClearAll", "time-separate", 99, [0], [[0.75]]]))
    assert run(dcm) == [0.75]


def test_the_overload_takes_one_time_and_replaces_everything(dcm: Dcm) -> None:
    dcm.create_alias(alias_request(["leds", [LED, GREEN]]))
    put(dcm, "leds", "Merge", (1.0, 500))
    dcm.set_alias(set_alias_request(["leds", 0, [0.25, 0.75]]))
    assert run(dcm, cycles=3) == [0.25, 0.25, 0.25]
    assert read(dcm, GREEN) == 0.75


@pytest.mark.parametrize(
    ("update", "waiting", "new", "kept"),
    [
        ("Merge", (100, 300), (200, 50), [50, 100, 200, 300]),
        ("ClearAll", (100, 300), (200,), [200]),
        ("ClearAll", (100, 200), (), []),
        ("ClearAfter", (50, 100, 150, 400), (300, 120), [50, 100, 120, 300]),
        ("ClearBefore", (50, 100, 150, 400), (200, 120), [120, 200, 400]),
        *((update, (100,), (100,), [100, 100]) for update in ("ClearAfter", "ClearBefore")),
        *((update, (100, 200), (), [100, 200]) for update in ("Merge", "ClearAfter", "ClearBefore")),
    ],
)
def test_an_update_type_keeps_its_part_of_what_waits(
    dcm: Dcm, update: str, waiting: tuple[int, ...], new: tuple[int, ...], kept: list[int]
) -> None:
    put(dcm, LED, "Merge", *((0.5, time) for time in waiting))
    put(dcm, LED, update, *((1.0, time) for time in new))
    assert times(dcm) == kept


@pytest.mark.parametrize(
    ("idle", "requests", "sent"),
    [
        (0, [("ClearAll", (0.0, 0), (1.0, 40))], [0.0, 0.25, 0.5, 0.75, 1.0]),
        # from 0 up to 1 at 15 ms and down to 0 at 30 ms: cycles at 0, 10, 20 and 30 ms see 2/3 twice
        (0, [("ClearAll", (0.0, 0), (1.0, 15), (0.0, 30))], [0.0, 171 / 256, 171 / 256, 0.0]),
        (0, [("ClearAll", (0.5, 0))], [0.5] * 300),
        (50, [("ClearAll", (1.0, -300), (0.0, 30))], [0.75, 0.5, 0.25, 0.0]),
        (10, [("Merge", (0.25, -30), (0.75, -5), (0.5, -20))], [0.75, 0.75]),
        (
            0,
            [("ClearAll", (0.0, 0), (0.5, 40)), ("Merge", (1.0, 40))],
            [0.0, 0.125, 0.25, 0.375, 1.0, 1.0],
        ),
        *((3, [(update, (0.75, later))], [0.75]) for update in UPDATES for later in (0, -1, -10, -5000)),
    ],
)
def test_timed_commands_are_sent_at_their_times_and_interpolated_in_between(
    dcm: Dcm, idle: int, requests: list[tuple[Any, ...]], sent: list[float]
) -> None:
    """The first cycle after the request is the next one: a time not in the future means it."""
    run(dcm, cycles=idle)
    for update, *commands in requests:
        put(dcm, LED, update, *commands)
    assert run(dcm, cycles=len(sent)) == sent


def test_clear_all_with_nothing_keeps_the_last_value(dcm: Dcm) -> None:
    put(dcm, LED, "ClearAll", (1.0, 80))
    # The first line begins one cycle ago: 10 of 90 ms done in the first cycle.
    ramp = run(dcm, cycles=5)
    put(dcm, LED, "ClearAll")
    assert times(dcm) == []
    assert run(dcm, cycles=20) == [ramp[-1]] * 20
    assert 0.5 < ramp[-1] < 0.6


def test_the_way_to_a_future_command_begins_at_the_last_value_in_the_last_cycle(dcm: Dcm) -> None:
    put(dcm, LED, "ClearAll", (0.5, 0))
    run(dcm, cycles=100)
    for update in UPDATES:
        put(dcm, LED, "ClearAll", (0.5, 0))
        run(dcm)
        put(dcm, LED, update, (1.0, 30))
        # 10 ms have passed since the last cycle: the first value is a quarter of the way.
        assert run(dcm, cycles=4) == [0.625, 0.75, 0.875, 1.0]


def test_clear_all_on_the_way_turns_from_where_the_actuator_is(dcm: Dcm) -> None:
    put(dcm, LED, "ClearAll", (0.0, 0), (1.0, 100))
    assert run(dcm, cycles=6)[-1] == 0.5
    put(dcm, LED, "ClearAll", (0.0, 30))
    assert run(dcm, cycles=4) == [0.375, 0.25, 0.125, 0.0]


def test_the_sonar_gets_a_mode_once_at_its_time(dcm: Dcm) -> None:
    put(dcm, US, "Merge", (68.0, 25), (4.0, 50))
    sent = []
    for _ in range(8):
        dcm.run_cycle()
        sent.append(dict(dcm.modes_sent))
    assert sent == [{}, {}, {}, {US: 68.0}, {}, {US: 4.0}, {}, {}]
    assert read(dcm, US) == 4.0


@pytest.mark.parametrize(("options", "limit"), [({}, 512), ({"limit": 4096}, 4096)])
def test_a_buffer_takes_so_many_commands(options: dict[str, int], limit: int) -> None:
    dcm = new_dcm(**options)
    put(dcm, LED, "Merge", *((0.5, 1000 + i) for i in range(limit)))
    assert len(dcm.waiting(LED)) == limit
    put(dcm, LED, "ClearAll", *((0.5, 1000 + i) for i in range(limit)))
    with pytest.raises(DcmRefused, match=f"takes {limit} timed commands"):
        put(dcm, LED, "Merge", (0.5, 1))


def test_a_request_that_overflows_one_buffer_changes_none(dcm: Dcm) -> None:
    dcm.create_alias(alias_request(["leds", [GREEN, LED]]))
    put(dcm, LED, "Merge", *((0.5, 1000 + i) for i in range(512)))
    with pytest.raises(DcmRefused, match=LED):
        put(dcm, "leds", "Merge", (1.0, 1))
    assert dcm.waiting(GREEN) == ()
    assert len(dcm.waiting(LED)) == 512


def test_values_are_clipped_to_the_range_of_the_actuator(dcm: Dcm) -> None:
    sheet = load_body("nao-v3").joints["LKneePitch"]
    grid = 2.0 * math.pi / 65536
    for value, limit in ((1e300, sheet.upper), (-1e300, sheet.lower)):
        put(dcm, KNEE, "ClearAll", (value, 0))
        assert 0.0 <= abs(limit) - abs(run(dcm, KNEE)[0]) <= grid
    put(dcm, KNEE, "ClearAll", (1e300, 0), (0.0, 40))
    assert run(dcm, KNEE, 3)[-1] == pytest.approx(sheet.upper / 2, abs=grid)
    for value, limit in ((7.0, 1.0), (-7.0, -1.0)):
        put(dcm, KNEE_HARDNESS, "ClearAll", (value, 0))
        assert run(dcm, KNEE_HARDNESS) == [limit]
    for value, limit in ((7.0, 1.0), (-7.0, 0.0)):
        put(dcm, LED, "ClearAll", (value, 0))
        assert run(dcm) == [limit]


def test_a_led_at_0_4_reads_back_0_398(dcm: Dcm) -> None:
    put(dcm, LED, "ClearAll", (0.4, 0))
    assert f"{run(dcm)[0]:.3f}" == "0.398"


def test_slow_ramps_are_computed_finer_than_the_integers(dcm: Dcm) -> None:
    # One count in a second is a hundredth of a count per cycle: rounded each time it would never move.
    put(dcm, LED, "ClearAll", (0.0, 0), (1 / 256, 1000))
    sent = run(dcm, cycles=101)
    assert sent[:50] == [0.0] * 50
    assert sent[51:] == [1 / 256] * 50


def test_a_position_reads_the_sensor_while_the_joint_is_limp(dcm: Dcm) -> None:
    put(dcm, KNEE, "ClearAll", (0.5, 0))
    assert run(dcm, KNEE)[0] == pytest.approx(0.5, abs=5e-5)
    for stiffness in (0.0, -1.0):
        put(dcm, KNEE_HARDNESS, "ClearAll", (stiffness, 0))
        assert run(dcm, KNEE) == [MEASURED[INDEX["LKneePitch"]]]
    put(dcm, KNEE_HARDNESS, "ClearAll", (0.5, 0))
    assert run(dcm, KNEE)[0] == pytest.approx(0.5, abs=5e-5)


def test_stiffness_is_interpolated_too(dcm: Dcm) -> None:
    put(dcm, KNEE_HARDNESS, "ClearAll", (1.0, 0), (0.0, 40))
    assert run(dcm, KNEE_HARDNESS, 5) == [1.0, 0.75, 0.5, 0.25, 0.0]


def test_get_time_is_now_plus_the_offset(dcm: Dcm) -> None:
    first = dcm.clock.shown()
    run(dcm, cycles=7)
    assert dcm.clock.shown() == first + 70
    assert dcm.clock.shown(250) == first + 320
    assert read(dcm, "DCM/Time") == first + 70


def test_the_clock_is_a_signed_4_byte_integer_that_wraps() -> None:
    dcm = new_dcm(start=2**31 - 15)
    assert dcm.clock.shown() == 2**31 - 15
    assert dcm.clock.shown(14) == 2**31 - 1
    assert dcm.clock.shown(15) == -(2**31)
    run(dcm, cycles=2)
    assert dcm.clock.shown() == -(2**31) + 5


def test_commands_work_across_the_wrap_of_the_clock() -> None:
    dcm = new_dcm(start=2**31 - 20)
    put(dcm, LED, "ClearAll", (0.0, 0), (1.0, 40))
    assert times(dcm) == [0, 40]
    assert run(dcm, cycles=5) == [0.0, 0.25, 0.5, 0.75, 1.0]
    put(dcm, LED, "ClearAll", (0.5, -45))
    assert run(dcm) == [0.5]


def test_the_clock_goes_on_while_the_dcm_is_paused(dcm: Dcm) -> None:
    put(dcm, LED, "ClearAll", (0.0, 0), (1.0, 80))
    assert run(dcm, cycles=3) == [0.0, 0.125, 0.25]
    for _ in range(3):
        dcm.skip_cycle()
    assert read(dcm, LED) == 0.25
    assert dcm.clock.shown() == 60
    assert run(dcm, cycles=3) == [0.75, 0.875, 1.0]


def test_get_prefix_is_the_root_of_all_names(dcm: Dcm) -> None:
    assert dcm.prefixes() == ["Device/SubDeviceList/"]


def test_range_and_integers_of_an_actuator_can_be_read(dcm: Dcm) -> None:
    base = "Device/SubDeviceList/LKneePitch/Position/Actuator/"
    sheet = load_body("nao-v3").joints["LKneePitch"]
    assert read(dcm, base + "Min") == sheet.lower
    assert read(dcm, base + "Max") == sheet.upper
    put(dcm, KNEE, "ClearAll", (0.3, 0))
    counts = (run(dcm, KNEE)[0] - read(dcm, base + "Offset")) / read(dcm, base + "Gain")
    assert counts == pytest.approx(round(counts), abs=1e-6)
    assert read(dcm, "DCM/CycleTime") == read(dcm, "DCM/TargetCycleTime") == 10.0


@pytest.mark.parametrize(
    "key",
    ["", "DCM", "LKneePitch/Position/Sensor/Value", "LKneePitch/Position/Actuator/Ack", "Value", KNEE[:-5]],
)
def test_keys_that_the_dcm_does_not_answer_for_are_refused(dcm: Dcm, key: str) -> None:
    with pytest.raises(DcmRefused, match="is no key of an actuator"):
        read(dcm, key)


def frame(**angles: float) -> tuple[float, ...]:
    return tuple(angles.get(name, START[i]) for name, i in INDEX.items())


def test_an_actuator_frame_is_clear_all_at_the_time_of_now() -> None:
    """The same by `setAlias` and by a frame, whatever was waiting before."""
    by_frame, by_alias = new_dcm(), new_dcm()
    joints = [a.name for a in by_alias.table if "/Position/" in a.name]
    stiff = [name.replace("Position", "Hardness") for name in joints]
    slots = [INDEX[name.split("/")[0]] for name in joints]
    by_alias.create_alias(alias_request(["all", joints + stiff]))
    history: list[list[Any]] = [[], []]
    for k in range(60):
        position = tuple(0.4 * math.sin(0.1 * k + i) for i in range(25))
        stiffness = tuple(1.2 * math.cos(0.07 * k + i) for i in range(25))
        for dcm in (by_frame, by_alias):
            if k % 7 == 0:
                put(dcm, KNEE, "Merge", (0.2, 15), (0.9, 55))
                put(dcm, LED, "Merge", (k / 60, 35))
        if k % 3 == 0:
            by_frame.put_frame(position, stiffness)
            values = [[position[s]] for s in slots] + [[stiffness[s]] for s in slots]
            now = by_alias.clock.shown()
            by_alias.set_alias(set_alias_request(["all", "ClearAll", "time-separate", 0, [now], values]))
        for dcm, sent in zip((by_frame, by_alias), history, strict=True):
            sent.append((dcm.run_cycle(), read(dcm, LED), read(dcm, KNEE)))
    assert history[0] == history[1]


def test_a_frame_clears_what_waits_for_any_joint(dcm: Dcm) -> None:
    names = [a.name for a in dcm.table if "/Position/" in a.name or "/Hardness/" in a.name]
    for name in names:
        put(dcm, name, "Merge", (0.1, 500))
    dcm.put_frame(START, (1.0,) * 25)
    assert [name for name in names if dcm.waiting(name)] == []


def test_a_frame_leaves_leds_alone(dcm: Dcm) -> None:
    put(dcm, LED, "ClearAll", (0.0, 0), (1.0, 40))
    sent = []
    for _ in range(5):
        dcm.put_frame(START, (1.0,) * 25)
        sent += run(dcm)
    assert sent == [0.0, 0.25, 0.5, 0.75, 1.0]


def test_nobody_arbitrates_between_frames_and_commands(dcm: Dcm) -> None:
    put(dcm, KNEE, "ClearAll", (0.5, 0), (0.5, 1000))
    assert run(dcm, KNEE)[0] == pytest.approx(0.5, abs=5e-5)
    dcm.put_frame(frame(LKneePitch=0.2), (1.0,) * 25)
    assert run(dcm, KNEE, 3)[-1] == pytest.approx(0.2, abs=5e-5)
    put(dcm, KNEE, "Merge", (0.7, 0))
    assert run(dcm, KNEE, 3)[-1] == pytest.approx(0.7, abs=5e-5)
