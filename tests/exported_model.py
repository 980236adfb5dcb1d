"""Loads an exported robot by three programs of others and compares masses, inertias and joint limits.

`python tests/exported_model.py FOLDER`, where mujoco, yourdfpy and pin (Pinocchio) are installed.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import yourdfpy

Limits = dict[str, tuple[float, float]]


def by_mujoco(file: Path) -> tuple[float, Limits, list[np.ndarray]]:
    """Mass, kg; limits of the hinges, rad; principal moments of each link with mass, kg m^2."""
    model = mujoco.MjModel.from_xml_path(str(file))
    hinges = [i for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_HINGE]
    limits = {model.joint(i).name: tuple(model.jnt_range[i]) for i in hinges}
    moments = [model.body_inertia[i] for i in range(model.nbody) if model.body_mass[i] > 0.0]
    return float(model.body_mass.sum()), limits, moments


def by_yourdfpy(file: Path) -> tuple[float, Limits, list[np.ndarray]]:
    """As `by_mujoco`."""
    model = yourdfpy.URDF.load(str(file), load_meshes=False, build_scene_graph=False)
    limits = {
        joint.name: (joint.limit.lower, joint.limit.upper)
        for joint in model.robot.joints
        if joint.type == "revolute"
    }
    inertial = [link.inertial for link in model.robot.links if link.inertial is not None]
    moments = [np.linalg.eigvalsh(each.inertia) for each in inertial if each.mass]
    return sum(each.mass for each in inertial), limits, moments


def by_pinocchio(file: Path) -> tuple[float, Limits, list[np.ndarray]]:
    """As `by_mujoco`, with the base free."""
    model = pinocchio.buildModelFromUrdf(str(file), pinocchio.JointModelFreeFlyer())
    limits = {
        name: (model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q])
        for name, joint in zip(model.names, model.joints, strict=True)
        if joint.nq == 1
    }
    moments = [np.linalg.eigvalsh(each.inertia) for each in model.inertias if each.mass]
    return pinocchio.computeTotalMass(model), limits, moments


def main(folder: Path) -> None:
    """Raise AssertionError where two programs disagree, or an inertia is not of a solid."""
    (mjcf,) = [file for file in folder.glob("*.xml") if file.name != "scene.xml"]
    (urdf,) = folder.glob("*.urdf")
    loaded = {
        "mujoco": by_mujoco(mjcf),
        "yourdfpy": by_yourdfpy(urdf),
        "pinocchio": by_pinocchio(urdf),
    }
    mass, limits, _ = loaded["mujoco"]
    for name, (other_mass, other_limits, moments) in loaded.items():
        assert math.isclose(other_mass, mass, rel_tol=1e-5), f"{name}: {other_mass} kg, mujoco {mass} kg"
        shared = limits.keys() & other_limits.keys()
        assert len(shared) >= 21, f"{name}: joints {sorted(other_limits)}"
        for joint in shared:
            assert np.allclose(other_limits[joint], limits[joint], atol=1e-5), f"{name}: {joint}"
        for a, b, c in map(sorted, moments):
            assert a > 0.0 and a + b >= c * (1.0 - 1e-6), f"{name}: moments {a}, {b}, {c}"
        print(f"{name}: {other_mass:.3f} kg, {len(shared)} joints with equal limits, {len(moments)} inertias")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
