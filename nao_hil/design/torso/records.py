"""From the shipped inputs of a gait to new designs, as the records that the walker loads."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec

from bridge.config import from_dict
from nao_hil.design.torso.assembly import TorsoDesign
from nao_hil.design.torso.robust import robust_design
from nao_hil.design.torso.thesis import thesis_design
from nao_hil.design.torso.transfer import transfer_function
from nao_hil.files import write_text
from walker.mechanisms.torso_control import (
    RobustRecord,
    RobustSpecification,
    ThesisRecord,
    ThesisSpecification,
    TorsoDesigns,
    TorsoPlant,
)
from walker.parameters import controller_parameters

CYCLES: Final = (0.010, 0.012)
"""Cycle times of the shipped bodies, s."""


class DesignInputs(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The plant and the specifications of both methods."""

    plant: TorsoPlant = TorsoPlant()
    thesis: ThesisSpecification = ThesisSpecification()
    robust: RobustSpecification = RobustSpecification()


class DesignedTorso(NamedTuple):
    """The designs of both methods by cycle time, s."""

    inputs: DesignInputs
    thesis: dict[float, TorsoDesign]
    robust: dict[float, TorsoDesign]

    @property
    def records(self) -> TorsoDesigns:
        """The numbers for the walker, with their inputs."""
        plant = self.inputs.plant
        return TorsoDesigns(
            thesis=tuple(
                ThesisRecord(plant=plant, specification=self.inputs.thesis, controller=design.controller)
                for design in self.thesis.values()
            ),
            robust=tuple(
                RobustRecord(plant=plant, specification=self.inputs.robust, controller=design.controller)
                for design in self.robust.values()
            ),
        )


def shipped_inputs(gait: str, changes: Mapping[str, Any]) -> DesignInputs:
    """The inputs of the shipped designs of a gait, or the defaults for a gait without designs.

    Args:
        gait: name.
        changes: values that differ, by dotted names such as `thesis.rise_time`.

    Raises:
        ConfigurationError: unknown gait, unknown name, or a value outside its bounds.
    """
    shipped = controller_parameters(gait).torso_design
    inputs = DesignInputs()
    if shipped.thesis:
        inputs = msgspec.structs.replace(
            inputs, plant=shipped.thesis[0].plant, thesis=shipped.thesis[0].specification
        )
    if shipped.robust:
        inputs = msgspec.structs.replace(inputs, robust=shipped.robust[0].specification)
    tables = msgspec.to_builtins(inputs)
    for name, value in changes.items():
        table, _, key = name.partition(".")
        if key and isinstance(tables.get(table), dict):
            tables[table] = {**tables[table], key: value}
        else:
            tables[name] = value
    return from_dict(tables, "torso design", DesignInputs)


def design_torso(inputs: DesignInputs, cycles: Iterable[float] = CYCLES) -> DesignedTorso:
    """Design the controllers of both methods.

    Args:
        inputs: plant and specifications.
        cycles: cycle times of the robots, s.

    Raises:
        ConfigurationError: the specification cannot be met on this plant; with the reason.
    """
    plant = transfer_function(inputs.plant)
    cycles = tuple(cycles)
    return DesignedTorso(
        inputs,
        {cycle: thesis_design(plant, inputs.thesis, cycle) for cycle in cycles},
        {cycle: robust_design(plant, inputs.robust, cycle) for cycle in cycles},
    )


def write_designs(file: Path, designs: TorsoDesigns, command: str) -> None:
    """Write designs as a file for `--config`.

    Args:
        file: TOML, overwritten.
        designs: with their inputs.
        command: that made them, for the first line.

    Raises:
        ConfigurationError: the file cannot be written.
    """
    table = msgspec.toml.encode({"controller": {"torso_design": designs}}).decode()
    # Arrays on one line.
    table = re.sub(r"\[\n([^\[\]]*),\n\]", lambda found: f"[{' '.join(found[1].split())}]", table)
    write_text(file, f"# Torso controllers, written by `{command}`.\n{table}")
