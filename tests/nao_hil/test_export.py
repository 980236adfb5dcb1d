"""The exported robot in simulators that know nothing of this project."""

import math
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from bridge.body import TORSO, joint_tree, load_body
from nao_hil.cli.main import run
from nao_hil.experiments import torso_step
from nao_hil.experiments.context import Context
from nao_hil.experiments.torso_responses import fit_plant, read_shape
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig

mujoco = pytest.importorskip("mujoco")
PAGE = Path(__file__).parents[2] / "docs/how-to/export.md"


@pytest.fixture(params=["mjcf", "urdf"])
def exported(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    file = tmp_path / "nao.xml"
    assert run(["export", request.param, "--robot", "nao-v6", "--wear", "worn", "--out", str(file)]) == 0
    return file


def test_masses_and_places_of_the_links_are_the_data_sheets(exported: Path) -> None:
    body = load_body("nao-v6")
    spec = mujoco.MjSpec.from_file(str(exported))
    spec.compiler.fusestatic = False
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    assert "Apache License" in exported.read_text()
    where = {TORSO: data.xpos[model.body("HeadYaw").parentid[0]]}
    for name, joint in joint_tree(body).items():
        where[name] = where[joint.parent] + joint.offset
        np.testing.assert_allclose(data.body(name).xpos, where[name], atol=1e-6)
        assert model.body(name).mass[0] == pytest.approx(body.links[name].mass)
        np.testing.assert_allclose(data.joint(name).xaxis, joint.axis, atol=1e-6)
    com = sum(link.mass * (where[name] + link.com) for name, link in body.links.items() if name in where)
    place = sum(model.body(name).mass[0] * data.body(name).xipos for name in where if name != TORSO)
    torso = body.links[TORSO]
    place += torso.mass * (where[TORSO] + torso.com)
    np.testing.assert_allclose(com, place, atol=1e-5)


def test_the_mujoco_model_stands_without_a_key_frame(tmp_path: Path) -> None:
    assert run(["export", "mjcf", "--robot", "nao-v6", "--out", str(tmp_path / "nao.xml")]) == 0
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "nao.xml"))
    data = mujoco.MjData(model)
    begin = data.qpos[2]
    mujoco.mj_step(model, data, 1000)
    assert data.qpos[2] == pytest.approx(begin, abs=0.01)


def test_the_page_s_torso_step_is_the_emulated_robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["export", "mjcf", "--robot", "nao-v3", "--out", "nao.xml"]) == 0
    program = re.search(r'```python title="torso_step.py"\n(.*?)```', PAGE.read_text(), re.DOTALL)
    assert program is not None
    found: dict[str, object] = {}
    exec(program[1], found)
    response = np.array(found["step"])[11::12]
    time = 0.012 * np.arange(1, len(response) + 1)
    with Campaign(cluster="inline") as campaign:
        context = Context(campaign, tmp_path, (1,), RunConfig(engine="mujoco"))
        ours = torso_step.quantities(torso_step.measure(context, math.radians(1.5)))  # the page's
    frequency = fit_plant(time, response)[0].natural_frequency_rad_s
    assert frequency == pytest.approx(ours["true"].natural_frequency_rad_s, rel=0.1)
    assert read_shape(time, response).peak == pytest.approx(ours["true_shape"].peak, rel=0.1)
    # and the page's own reading
    assert found["frequency"] == pytest.approx(ours["true"].natural_frequency_rad_s, rel=0.1)


def test_a_file_in_the_place_of_the_folder_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "model").touch()
    assert run(["export", "folder", "--out", str(tmp_path / "model")]) == 2
    assert "is a file" in capsys.readouterr().err


def test_the_folder_s_model_stands_and_both_its_forms_are_the_data_sheets(tmp_path: Path) -> None:
    assert run(["export", "folder", "--robot", "nao-v6", "--out", str(tmp_path)]) == 0
    body = load_body("nao-v6")
    test: dict[str, Any] = {"__file__": str(tmp_path / "test_nao_v6.py")}
    exec((tmp_path / "test_nao_v6.py").read_text(), test)
    test["test_the_robot_stands"]()
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert (model.body_inertia[1:] >= 0.0).all()
    assert (tmp_path / "LICENSE").read_text().count("Apache License") >= 1
    urdf = ElementTree.parse(tmp_path / "nao_v6.urdf").getroot()
    for name in joint_tree(body):
        sheet, limit = body.joints[name], urdf.find(f"joint[@name='{name}']/limit")
        assert limit is not None
        assert (float(limit.get("lower", "")), float(limit.get("upper", ""))) == pytest.approx(
            (sheet.lower, sheet.upper)
        )
    for link in urdf.iter("link"):
        mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
        assert mass is not None and inertia is not None
        assert float(mass.get("value", "")) == pytest.approx(body.links[link.get("name", "")].mass)
        xx, xy, xz, yy, yz, zz = (float(inertia.get(k, "")) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
        assert np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).min() > 0.0
        for mesh in link.findall("visual/geometry/mesh"):
            assert (tmp_path / mesh.get("filename", "")).is_file()
