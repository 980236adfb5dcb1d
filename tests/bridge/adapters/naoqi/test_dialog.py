"""ALDialog answers by the rules of its topics, as the vendor's pages on QiChat say."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from bridge.adapters.naoqi.interaction.qichat import Steps, captures, parse
from bridge.errors import NaoqiRefused
from tests.bridge.adapters.naoqi.served import Robot

TOPIC = (Path(__file__).parent / "data" / "mine.top").read_text()


@pytest.fixture
def robot() -> Robot:
    robot = Robot()
    name = robot.wait(robot.call("ALDialog", "loadTopicContent", TOPIC))
    assert name == "mine"
    robot.call("ALDialog", "activateTopic", name)
    robot.call("ALDialog", "subscribe", "me")
    return robot


def said(robot: Robot, words: str) -> str | None:
    """The answer to a sentence, once it was spoken."""
    return answer(robot, lambda: robot.call("ALDialog", "forceInput", words))


def answer(robot: Robot, talk: Callable[[], Any]) -> str | None:
    robot.events.clear()
    spoken = talk()
    if isinstance(spoken, Future):
        assert robot.wait(spoken, 20.0) is None
    found = [value for event, value in robot.events if event == "ALTextToSpeech/CurrentSentence" and value]
    return found[-1] if found else None


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("I want some chicken", "Sure! You must really like chicken."),
        ("I would like ice cream!", "Sure! You must really like ice cream."),
        ("How are you today?", "Hello human, I am fine thank you and you?"),
        ("help me with this", "I can help you."),
        ("help", "I can help you."),
    ],
)
def test_a_rule_answers_what_it_matches_as_a_whole(robot: Robot, words: str, expected: str) -> None:
    assert said(robot, words) == expected
    assert dict(robot.events)["Dialog/LastAnswer"] == expected
    assert dict(robot.events)["Dialog/MatchedTopic"] == "mine"


def test_rules_within_a_rule_come_after_it_only(robot: Robot) -> None:
    assert said(robot, "bad") is None or "Why" not in str(said(robot, "bad"))
    said(robot, "how are you today")
    assert said(robot, "bad") == "Why?"
    assert said(robot, "the weather") == "So the weather it is."


def test_a_touched_head_is_an_event_to_answer_when_it_is_touched_and_not_when_it_is_let_go(
    robot: Robot,
) -> None:
    def touch(value: float) -> None:
        robot.call("ALMemory", "raiseEvent", "FrontTactilTouched", value)
        robot.run(3.0)

    assert answer(robot, lambda: touch(1.0)) == "You touched my head!"
    assert ("Dialog/Tag", "touched") in robot.events
    assert answer(robot, lambda: touch(0.0)) is None
    robot.call("ALDialog", "unsubscribe", "me")
    assert answer(robot, lambda: touch(1.0)) is None


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ("u:(hi) hello", "this is no topic"),
        ("topic: ~a()\nu:(hi hello", r"line 2: \(\.\.\.\) is expected"),
        ("topic: ~a()\nu:([hi) hello", "line 2: '\\)' closes no bracket|is not closed|expected"),
        ("topic: ~a()\nu2:(hi) hello", "line 2: u2 has no rule above it"),
        ("topic: ~a()\nu:(" + "[" * 20 + "a" + "]" * 20 + ") hello", "too deep"),
        ("topic: ~a()\n" + "u:(a) b\n" * 1001, "more than 1000 rules"),
        ("x" * 70_000, "longer than 65536 letters"),
    ],
)
def test_what_is_no_topic_is_refused_with_its_line(robot: Robot, source: str, sentence: str) -> None:
    with pytest.raises(NaoqiRefused, match=sentence):
        robot.wait(robot.call("ALDialog", "loadTopicContent", source))


def matched(rule: str, words: str) -> tuple[tuple[str, ...] | None, int]:
    """What a rule keeps of a sentence, and the steps that it took."""
    topic, steps = parse(f"topic: ~a()\nconcept:(a) ~a\nu:({rule}) b"), Steps()
    pattern = topic.rules[0].pattern
    assert pattern is not None
    return captures(pattern, words, topic.concepts, steps), 20_000 - steps.left


def test_a_sentence_of_many_ways_to_match_takes_few_steps() -> None:
    """Wildcards after each other, of which a backtracking match would try 56^5 / 5! ways (4.6 million)."""
    kept, steps = matched("{*} " * 5 + "end", "word " * 55)
    assert kept is None and steps < 20_000
    kept, steps = matched("{*} " * 5 + "end", "word " * 55 + "end")
    assert kept == () and steps < 20_000


def test_a_match_that_takes_too_long_and_a_concept_of_itself_are_none() -> None:
    kept, steps = matched("{*} " * 500 + "end", "word " * 55 + "end")
    assert kept is None and steps > 20_000
    assert matched("~a", "a")[0] is None


def test_answers_that_lead_to_themselves_end(robot: Robot) -> None:
    topic = "topic: ~loop()\nu:(loop) ^goto(t)\nproposal: %t ^goto(t) again ^goto(t)"
    robot.call("ALDialog", "activateTopic", robot.wait(robot.call("ALDialog", "loadTopicContent", topic)))
    assert said(robot, "loop") == " ".join(["again"] * 20)


def loaded(robot: Robot, rules: str, language: str = "enu") -> None:
    """Activate one more topic."""
    topic = f"topic: ~more()\nlanguage: {language}\n{rules}"
    robot.call("ALDialog", "activateTopic", robot.wait(robot.call("ALDialog", "loadTopicContent", topic)))


def test_an_answer_plays_its_animations_and_waits_for_them(robot: Robot) -> None:
    loaded(
        robot,
        "u:(wave) ^start(animations/Stand/Gestures/Hey_1) Hi ^wait(animations/Stand/Gestures/Hey_1) there",
    )
    before, arm = robot.angle("RShoulderPitch"), []
    robot.events.clear()
    spoken = robot.call("ALDialog", "forceInput", "wave")
    for _ in range(60):
        robot.run(0.1)
        arm.append(robot.angle("RShoulderPitch"))
        if spoken.done():
            break
    assert spoken.done() and min(arm) < before - 0.5
    assert arm[-1] == pytest.approx(before, abs=0.2)  # the animation has ended as well
    assert dict(robot.events)["Dialog/LastAnswer"] == "Hi there"


@pytest.mark.parametrize(
    "answer_", ["^start(games/simon) ^wait(games/simon)", "Let us play. ^run(games/simon)"]
)
def test_a_behaviour_that_the_robot_does_not_have_is_an_event(robot: Robot, answer_: str) -> None:
    loaded(robot, f"u:(play) {answer_}")
    said(robot, "play")
    assert [value for event, value in robot.events if event == "NaoHil/StartBehavior"] == ["games/simon"]


def test_an_answer_leads_to_the_same_the_next_and_a_tagged_proposal(robot: Robot) -> None:
    loaded(
        robot,
        "proposal: %age How old are you?\n u1:(what) Listen. ^sameProposal\n u1:(ten) Fine. ^nextProposal\n"
        "proposal: Do you play chess?\n u1:(no) ^gotoReactivate(age)\nu:(talk to me) ^gotoRandom(age)",
    )
    assert said(robot, "talk to me") == "How old are you?"
    assert said(robot, "what") == "Listen. How old are you?"
    assert said(robot, "what") == "Listen. How old are you?"
    assert said(robot, "ten") == "Fine. Do you play chess?"
    assert said(robot, "no") == "How old are you?"


def test_options_before_the_words_of_a_rule_and_other_languages_are_read(robot: Robot) -> None:
    loaded(robot, "u:^private(hallo daar) goedendag", "dun")
    assert said(robot, "hallo daar") == "goedendag"
    assert robot.call("ALDialog", "getLoadedTopics", "Dutch") == ["more"]
    assert robot.call("ALDialog", "getLoadedTopics", "English") == ["mine"]


def test_a_variable_behind_words_is_set_after_them(robot: Robot) -> None:
    loaded(robot, "u:(leave) $left=1 Good bye to you all $onStopped=1 ^run(games/end) $ended=1")
    robot.events.clear()
    spoken = robot.call("ALDialog", "forceInput", "leave")
    robot.run(0.2)
    assert not spoken.done()
    assert dict(robot.events)["left"] == 1 and not {"onStopped", "ended"} & dict(robot.events).keys()
    robot.wait(spoken)
    assert dict(robot.events)["onStopped"] == 1 and dict(robot.events)["ended"] == 1
