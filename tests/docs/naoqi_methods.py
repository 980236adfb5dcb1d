"""The table of the vendor's methods in `docs/naoqi-methods.md`, from the services themselves.

`python -m tests.docs.naoqi_methods` writes it.
"""

from __future__ import annotations

from pathlib import Path
from threading import RLock
from typing import Any, Final

from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.adapters.naoqi.core.sensing import QUIET_SERVICES
from bridge.adapters.naoqi.core.served import ServedRobot
from bridge.adapters.naoqi.core.walking import WalkingMethods
from bridge.adapters.naoqi.declared import Method
from bridge.adapters.naoqi.services import NAO_HIL_SERVICE, Services
from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.body.postures import POSTURES
from bridge.messages import SensorFrame

PAGE: Final = Path(__file__).parents[2] / "docs" / "naoqi-methods.md"
BEGIN: Final = "<!-- begin of the table by tests.docs.naoqi_methods -->\n"
END: Final = "<!-- end of the table -->\n"
EXTRACTORS: Final = (
    "ALSonar",
    "ALTouch",
    "ALSensors",
    "ALSpeechRecognition",
    "ALFaceDetection",
    "ALLandMarkDetection",
    "ALRedBallDetection",
    "ALVisualCompass",
    *QUIET_SERVICES,
)
"""Services whose common methods the table has once."""
_STANDING: Final = SensorFrame(
    seq=0,
    time=0.0,
    position=POSTURES["StandInit"],
    stiffness=(1.0,) * N_JOINTS,
    current=(0.0,) * N_JOINTS,
    temperature=(30.0,) * N_JOINTS,
    fsr=(5.0,) * 8,
    accelerometer=(0.0, 0.0, 9.81),
    gyroscope=(0.0, 0.0, 0.0),
    angle=(0.0, 0.0),
    touch=(0.0,) * 14,
    battery=(1.0, 0.0, 0.0, 25.0),
    sonar=(2.55, 2.55),
)


class _NoWalker:
    """In place of the hand-over to a walker: its methods are listed and not called."""

    has_robot = False

    def __getattr__(self, name: str) -> Any:
        return lambda *_: None


def services() -> Services:
    """The services of a V5 without a walker."""
    walking: Any = WalkingMethods
    robot = ServedRobot(
        RobotConfig(load_body("nao-v5"), "nao"),
        _STANDING,
        RLock(),
        walking(_NoWalker(), (1.0, 1.0, 1.0)),
        lambda *_: None,
        Path("/nonexistent"),
    )
    return Services(robot, lambda: None, lambda: None)


def answers() -> dict[str, dict[str, str]]:
    """Service -> method -> `yes`, `partly` or `no`; methods of every service are under `ALModule`."""
    found = {name: {m: _answer(of) for m, of in table.items()} for name, table in services().table().items()}
    del found[NAO_HIL_SERVICE]
    common = set.intersection(*({m for m, answer in of.items() if answer != "no"} for of in found.values()))
    module = {m: found["ALSystem"][m] for m in common}
    found = {name: {m: a for m, a in of.items() if m not in common} for name, of in found.items()}
    found["ALMemory"]["subscriber"] = "yes"
    return {"ALModule": module, **found}


def _answer(method: Method) -> str:
    return "no" if method.refuses else "partly" if method.partly else "yes"


def _names(methods: list[str]) -> str:
    return " ".join(f"`{method}`" for method in methods)


def method_table() -> str:
    """The tables, as Markdown."""
    found = answers()
    count = {
        kind: sum(list(of.values()).count(kind) for of in found.values()) for kind in ("yes", "partly", "no")
    }
    modules = [of for name, of in found.items() if name != "ALModule"]
    offering = sum(any(answer != "no" for answer in of.values()) for of in modules)
    common = set.intersection(*({m for m, a in found[name].items() if a == "yes"} for name in EXTRACTORS))
    lines = [
        f"{offering} services offer methods. Of {sum(count.values())} methods {count['yes']} are "
        f"offered, {count['partly']} partly (second table), and {count['no']} refuse with one sentence. "
        f"`ALModule` are those of every service; *extractor* stands for {_names(sorted(common))}.",
        "",
        "| service | yes | no |",
        "|---|---|---|",
    ]
    refused = [service for service, of in found.items() if set(of.values()) == {"no"}]
    for service, of in found.items():
        if service in refused:
            continue
        yes, no = (_names(sorted(m for m in of if of[m] == kind)) for kind in ("yes", "no"))
        if service in EXTRACTORS:
            yes = f"*extractor* {_names(sorted(m for m in of if of[m] == 'yes' and m not in common))}".strip()
        lines.append(f"| `{service}` | {yes} | {no} |")
    lines += [
        "",
        *([f"All methods are refused by {_names(refused)}.", ""] if refused else []),
        "| left out or assumed | methods that are offered partly |",
        "|---|---|",
    ]
    by_reason: dict[str, list[str]] = {}
    for service, table in services().table().items():
        reasons: dict[str, list[str]] = {}
        for name, method in table.items():
            if method.partly and name in found.get(service, {}):
                reasons.setdefault(method.partly, []).append(name)
        for reason, methods in reasons.items():
            by_reason.setdefault(reason, []).append(f"`{service}`: {_names(sorted(methods))}")
    lines += [f"| {reason} | {'; '.join(methods)} |" for reason, methods in by_reason.items()]
    return "\n".join(lines) + "\n"


def page() -> str:
    """The page with the table of now."""
    text = PAGE.read_text()
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{method_table()}\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(page())
