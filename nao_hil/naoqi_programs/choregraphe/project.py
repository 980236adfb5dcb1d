"""A Choregraphe project as data: boxes, links and timelines of its `.xar` behaviours."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol

from bridge.errors import ConfigurationError
from bridge.files import read_limited
from bridge.validation import unknown_name

MAX_SIZE: Final = 20_000_000
"""bytes of a file"""
_START: Final = "2"
_STOP: Final = "3"
"""Natures of inputs."""
PARENT: Final = 0
"""Owner of a link's end that is the box around the diagram."""


@dataclass(frozen=True)
class BoxLink:
    """A link from an output of a box to an input of one; reversed for the box around the diagram."""

    source: int
    output: int
    target: int
    input: int


@dataclass(frozen=True)
class Diagram:
    """Boxes by their ids, and their links."""

    boxes: dict[int, Box]
    links: tuple[BoxLink, ...]
    frame: int = 1
    """Frame of the timeline around it, at which it is loaded."""
    layer: int = 0
    """Layer of the timeline; a later diagram of a layer replaces the earlier one."""
    label: str = ""
    """Name of its frame."""


@dataclass(frozen=True)
class Curve:
    """Keys of one actuator: frames and values, in degrees, or 0 to 1 of a hand."""

    actuator: str
    frames: tuple[float, ...]
    values: tuple[float, ...]


@dataclass(frozen=True)
class Box:
    """A box with its script, its diagrams and its curves."""

    name: str
    inputs: dict[int, str]
    outputs: dict[int, str]
    events: dict[str, str]
    """Input -> event of ALMemory that stimulates it."""
    starts: frozenset[str]
    """Inputs that start the box."""
    stops: frozenset[str]
    """Inputs that stop it."""
    parameters: dict[str, object]
    inherited: frozenset[str]
    """Parameters whose value is that of the box around it."""
    script: str
    dialog: str
    """File that names its topics, relative to the behaviour; or empty."""
    plugin: str
    timed: bool
    """Its timeline is on."""
    fps: float
    start: float = 0.0
    """Frame at which its timeline begins."""
    end: float | None = None
    """Frame at which it ends; None: at the last key."""
    diagrams: tuple[Diagram, ...] = ()
    curves: tuple[Curve, ...] = ()

    def diagrams_at(self, frame: float) -> set[int]:
        """Numbers of the diagrams that a frame of the timeline is in: the latest of each layer."""
        layers: dict[int, int] = {}
        for number, diagram in sorted(enumerate(self.diagrams), key=lambda item: item[1].frame):
            if diagram.frame <= frame:
                layers[diagram.layer] = number
        return set(layers.values())

    def frame_of(self, name: Any) -> float:
        """The frame of a name or a number.

        Raises:
            RuntimeError: no frame has this name.
        """
        labels = {diagram.label: diagram.frame for diagram in self.diagrams}
        if not isinstance(name, str) or name not in labels:
            try:
                return float(name)
            except ValueError:
                raise RuntimeError(
                    f"the box {self.name} has no {unknown_name('frame', name, labels)}"
                ) from None
        return labels[name]


class LiveBox(Protocol):
    """A box that is played, for its script, its timeline and its dialogue."""

    player: Any
    box: Box
    parent: Any
    timeline: Any
    module_name: str

    def emit(self, output: str, value: Any = None) -> None:
        """Leave the box through an output."""

    def parameter(self, name: str) -> Any:
        """The value of a parameter."""

    def enter(self, number: int) -> None:
        """Load a diagram."""

    def follow(self, number: int, source: int, output: str, value: Any) -> None:
        """Stimulate inputs that an output is linked to."""


def behaviours(path: Path) -> list[Path]:
    """The `.xar` files of a project: itself, those that its `.pml` names, or those in the folder.

    Raises:
        ConfigurationError: there is none.
    """
    if path.is_dir():
        projects = sorted(path.glob("*.pml")) or sorted(path.rglob("*.xar"))
        if not projects:
            raise ConfigurationError(f"{path}: no .pml and no .xar is there; name a Choregraphe project.")
        return behaviours(projects[0])
    if path.suffix == ".xar":
        return [path]
    if path.suffix != ".pml":
        raise ConfigurationError(f"{path}: a Choregraphe project is a .pml, a .xar, or the folder of one.")
    named = [e for e in parsed(path).iter() if _tag(e) == "BehaviorDescription"]
    files = [path.parent / e.get("src", "") / e.get("xar", "behavior.xar") for e in named]
    if not files:
        raise ConfigurationError(f"{path}: it names no behaviour; is it a Choregraphe project?")
    return files


def read_behaviour(path: Path) -> Box:
    """The outermost box of a `.xar` file.

    Raises:
        ConfigurationError: no such file, not XML, or not a behaviour.
    """
    for element in parsed(path):
        if _tag(element) == "Box":
            return _box(element, path)
    raise ConfigurationError(f"{path}: it has no box; a behaviour of Choregraphe (.xar) is expected.")


def parsed(path: Path) -> ET.Element:
    """The outermost element of a file.

    Raises:
        ConfigurationError: it cannot be read, or declares a document type.
    """
    try:
        data = read_limited(path, MAX_SIZE, f"give a file of a Choregraphe project of at most {MAX_SIZE} bytes")
        text = data.decode("utf-8-sig")
        if "<!DOCTYPE" in text.upper() or "<!ENTITY" in text.upper():  # entities could expand without end
            raise ConfigurationError(f"{path}: it declares a document type, which Choregraphe's files do not.")
        return ET.fromstring(text)
    except (OSError, UnicodeDecodeError, ET.ParseError, RecursionError) as error:
        raise ConfigurationError(f"{path}: it cannot be read ({error}); is it a Choregraphe project?") from None


def _tag(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]


def _children(element: ET.Element, *tags: str) -> Iterator[ET.Element]:
    """Descendants of the first tag along a path of tags."""
    for child in element:
        if _tag(child) == tags[0]:
            if len(tags) == 1:
                yield child
            else:
                yield from _children(child, *tags[1:])


def _box(element: ET.Element, path: Path) -> Box:
    try:
        timelines = list(_children(element, "Timeline"))
        timed = any(t.get("enable") == "1" for t in timelines)
        start = max((float(t.get("start_frame", "1")) for t in timelines), default=1.0)
        end = max((float(t.get("end_frame", "-1")) for t in timelines), default=-1.0)
        diagrams = [_diagram(d, path) for d in _children(element, "Diagram")]
        curves: list[Curve] = []
        layers = [layer for timeline in timelines for layer in _children(timeline, "BehaviorLayer")]
        for number, layer in enumerate(layers, start=1):
            for keyframe in _children(layer, "BehaviorKeyframe"):
                frame, label = max(1, int(keyframe.get("index", "1"))), keyframe.get("name", "")
                for diagram in _children(keyframe, "Diagram"):
                    made = _diagram(diagram, path)
                    diagrams.append(Diagram(made.boxes, made.links, frame, number, label))
        if timed:
            elements = [c for t in timelines for c in _children(t, "ActuatorList", "ActuatorCurve")]
            curves = [_curve(c, end if end > 0.0 else math.inf) for c in elements]
        inputs, parameters = list(_children(element, "Input")), list(_children(element, "Parameter"))
        scripts = [c.text or "" for c in _children(element, "script", "content")]
        return Box(
            name=element.get("name", "box"),
            inputs={int(e.get("id", "0")): e.get("name", "") for e in inputs},
            events={e.get("name", ""): e.get("stm_value_name", "") for e in inputs if e.get("stm_value_name")},
            starts=frozenset(e.get("name", "") for e in inputs if e.get("nature") == _START) | {"onStart"},
            stops=frozenset(e.get("name", "") for e in inputs if e.get("nature") == _STOP) | {"onStop"},
            outputs={int(e.get("id", "0")): e.get("name", "") for e in _children(element, "Output")},
            parameters={e.get("name", ""): _value(e) for e in parameters},
            inherited=frozenset(
                e.get("name", "") for e in parameters if e.get("inherits_from_parent") in ("1", "true")
            ),
            script="\n".join(scripts).strip(),
            dialog=next((e.text or "" for e in _children(element, "dialogFile")), "").strip(),
            plugin=element.get("plugin", ""),
            timed=timed,
            fps=max((float(t.get("fps", "25")) for t in timelines), default=25.0),
            start=start if start > 1.0 else 0.0,
            end=end if end > 0.0 else None,
            diagrams=tuple(diagrams),
            curves=tuple(curve for curve in curves if curve.frames),
        )
    except ValueError as error:
        raise ConfigurationError(f"{path}: box `{element.get('name')}` cannot be read ({error}).") from None


def _diagram(element: ET.Element, path: Path) -> Diagram:
    ends = ("outputowner", "indexofoutput", "inputowner", "indexofinput")
    links = [BoxLink(*(int(e.get(end, "0")) for end in ends)) for e in _children(element, "Link")]
    boxes = {int(e.get("id", "-1")): _box(e, path) for e in _children(element, "Box")}
    return Diagram(boxes, tuple(links))


def _curve(element: ET.Element, end: float) -> Curve:
    """A curve up to a frame, where it is cut on the line between two keys."""
    keys = sorted((float(k.get("frame", "0")), float(k.get("value", "0"))) for k in _children(element, "Key"))
    if element.get("mute") == "1":
        keys = []
    beyond = next((i for i, (frame, _) in enumerate(keys) if frame > end), None)
    if beyond is not None:
        (before, first), (after, last) = keys[max(0, beyond - 1)], keys[beyond]
        keys = keys[:beyond]
        if before < end:
            keys.append((end, first + (last - first) * (end - before) / (after - before)))
    return Curve(element.get("actuator", ""), tuple(f for f, _ in keys), tuple(v for _, v in keys))


def _value(element: ET.Element) -> object:
    """A parameter by its content type: 0 bool, 1 int, 2 float, others text."""
    text, kind = element.get("value", ""), element.get("content_type", "3")
    if kind == "0":
        return text.lower() in ("1", "true")
    if kind in ("1", "2") and text:
        return int(text) if kind == "1" else float(text)
    return text
