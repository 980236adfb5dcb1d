"""The robot as a folder that model collections take as it is: MuJoCo Menagerie's layout, with URDF.

The shell is in `assets/`; the shapes that touch the world stay primitive, as in the emulated robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Final
from xml.etree import ElementTree as Xml

from bridge.body import Body
from bridge.errors import ConfigurationError
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.picture import Painter
from emulator.engine.mujoco.scene import FLOOR
from emulator.engine.values import PinholeCamera
from emulator.shell import ColouredMesh, shell

SCENE: Final = """\
<mujoco model="{name} scene">
  <include file="{name}.xml"/>
  <statistic center="0 0 0.25" extent="0.7"/>
  <visual>
    <headlight diffuse="0.5 0.5 0.5" ambient="0.35 0.35 0.35" specular="0.1 0.1 0.1"/>
    <global azimuth="150" elevation="-15"/>
  </visual>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.78 0.83 0.9" rgb2="1 1 1" width="512" height="512"/>
    <texture name="grid" type="2d" builtin="checker" rgb1="0.9 0.9 0.93" rgb2="0.8 0.83 0.87" width="300"
      height="300"/>
    <material name="grid" texture="grid" texrepeat="10 10" texuniform="true" reflectance="0.05"/>
  </asset>
  <worldbody>
    <light pos="0.6 -0.7 2" dir="-0.3 0.35 -1" directional="true"/>
    <geom name="drawn floor" type="plane" size="0 0 1" material="grid" contype="0" conaffinity="0"/>
  </worldbody>
</mujoco>
"""
README: Final = """\
# {name}

The humanoid robot NAO ({body}) for MuJoCo 3.7 or later and as URDF, exported by nao-hil.

| file | holds |
|---|---|
| `{name}.xml` | MJCF: {wear} drives with backlash and delay, soft soles, key frames `stand`, `one-leg` |
| `scene.xml` | the same on a floor with light |
| `{name}.urdf` | links, masses, joints, shapes |
| `assets/` | the shell: an own design, lofted from published dimensions |
| `test_{name}.py` | pytest: the model loads and stands |

Numbers are published or assumed as nao-hil's data sheet of the body says.
No file of the robot's vendor is in here. Licence: Apache-2.0.
"""
TEST: Final = '''\
"""The model loads, and stands for a second at its key frame."""

from pathlib import Path

import mujoco
import numpy as np


def test_the_robot_stands() -> None:
    model = mujoco.MjModel.from_xml_path(str(Path(__file__).parent / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("stand").id)
    for i, (samples, _) in enumerate(model.actuator_history):  # the delays begin with the key frame's requests
        if samples:
            mujoco.mj_initCtrlHistory(model, data, i, None, np.full((samples, 1), data.ctrl[i]))
    mujoco.mj_forward(model, data)
    height = data.body("Torso").xpos[2]
    mujoco.mj_step(model, data, round(1.0 / model.opt.timestep))
    assert abs(data.body("Torso").xpos[2] - height) < 0.02
'''


def model_folder(body: Body, wear: str, mjcf: str, urdf: str, licence: str) -> dict[str, str]:
    """Files of the folder: path -> text.

    Args:
        body: Data sheet.
        wear: Name of the drives' wear profile.
        mjcf: As `emulator.export.mjcf.to_mjcf` gives it.
        urdf: As `emulator.export.urdf.to_urdf` gives it.
        licence: Text of the licence.
    """
    name, parts = body.name.replace("-", "_").replace(".", "_"), shell(body)
    pieces = [(_mesh(link, i), part) for link, found in parts.items() for i, part in enumerate(found)]
    files = {f"assets/{mesh}.obj": _obj(part) for mesh, part in pieces}
    return files | {
        f"{name}.xml": _with_shell_mjcf(mjcf, parts),
        f"{name}.urdf": _with_shell_urdf(urdf, parts),
        "scene.xml": SCENE.format(name=name),
        "README.md": README.format(name=name, body=body.name, wear=wear),
        f"test_{name}.py": TEST,
        "LICENSE": licence,
    }


def draw_model(folder: Path) -> str:
    """Draw the scene's robot at its key frame `stand`; the picture's name, empty where MuJoCo cannot draw."""
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("stand").id)
    mujoco.mj_forward(model, data)
    painter, eye = Painter(), PinholeCamera((0.75, -0.55, 0.42), (0.0, 0.0, 0.26), 640, 720, math.radians(42.0))
    try:
        from PIL import Image

        Image.fromarray(painter.draw(model, data, eye)).save(folder / "nao.png")
    except (ConfigurationError, ModuleNotFoundError):
        return ""
    finally:
        painter.close()
    return "nao.png"


def _mesh(link: str, i: int) -> str:
    return f"{link}_{i}"


def _obj(part: ColouredMesh) -> str:
    vertices = "".join(f"v {x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in part.vertices.tolist())
    return vertices + "".join(f"f {a} {b} {c}\n" for a, b, c in (part.faces + 1).tolist())


def _rgba(part: ColouredMesh) -> str:
    return " ".join(f"{c / 255.0:.3f}" for c in part.colour) + " 1"


def _with_shell_mjcf(text: str, parts: Mapping[str, list[ColouredMesh]]) -> str:
    """The model with the shell drawn (group 2), and the shapes that touch the world in group 3."""
    root = Xml.fromstring(text, Xml.XMLParser(target=Xml.TreeBuilder(insert_comments=True)))
    compiler, asset = root.find("compiler"), root.find("asset")
    assert compiler is not None and asset is not None
    compiler.set("meshdir", "assets")
    for geom in root.iter("geom"):
        geom.set("group", "3")
    for body in root.iter("body"):
        if body.get("name") == FLOOR:
            continue
        for i, part in enumerate(parts.get(body.get("name", ""), [])):
            mesh = _mesh(body.get("name", ""), i)
            Xml.SubElement(asset, "mesh", name=mesh, file=f"{mesh}.obj")
            Xml.SubElement(
                body,
                "geom",
                {"type": "mesh", "mesh": mesh, "contype": "0", "conaffinity": "0"}
                | {"group": "2", "mass": "0", "rgba": _rgba(part)},
            )
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode") + "\n"


def _with_shell_urdf(text: str, parts: Mapping[str, list[ColouredMesh]]) -> str:
    root = Xml.fromstring(text, Xml.XMLParser(target=Xml.TreeBuilder(insert_comments=True)))
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for i, part in enumerate(parts.get(link.get("name", ""), [])):
            mesh, visual = _mesh(link.get("name", ""), i), Xml.SubElement(link, "visual")
            Xml.SubElement(Xml.SubElement(visual, "geometry"), "mesh", filename=f"assets/{mesh}.obj")
            colour = "_".join(map(str, part.colour))
            material = Xml.SubElement(visual, "material", name=f"colour_{colour}")
            Xml.SubElement(material, "color", rgba=_rgba(part))
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode", xml_declaration=True) + "\n"
