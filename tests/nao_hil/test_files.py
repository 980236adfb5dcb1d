"""Files that are written whole or not at all."""

from __future__ import annotations

import os
from itertools import count
from pathlib import Path

import pytest
from matplotlib import legend
from matplotlib.figure import Figure

from nao_hil.cli.main import run
from nao_hil.files import atomic_path, save_figure, write_text


def test_a_file_is_there_whole_once_the_block_has_ended(tmp_path: Path) -> None:
    file = tmp_path / "plan.toml"
    file.write_text("old")
    with atomic_path(file) as temporary:
        assert (temporary.parent, temporary.suffix) == (file.parent, file.suffix)
        temporary.write_text("new")
        assert file.read_text() == "old"
    assert file.read_text() == "new"
    assert list(tmp_path.iterdir()) == [file]


def test_a_fault_midway_leaves_the_folder_as_it_was(tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"

    def write() -> None:
        with atomic_path(file) as temporary:
            temporary.write_text("<muj")
            raise ValueError("the exporter broke")

    with pytest.raises(ValueError, match="broke"):
        write()
    assert not list(tmp_path.iterdir())
    file.write_text("old")
    with pytest.raises(ValueError, match="broke"):
        write()
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_a_link_stays_one_and_a_device_is_written_to(tmp_path: Path) -> None:
    file, link = tmp_path / "file", tmp_path / "link"
    link.symlink_to(file)
    write_text(link, "text")
    assert link.is_symlink() and file.read_text() == "text"
    write_text(Path(os.devnull), "text")
    assert not Path(os.devnull).is_file()


def test_an_export_to_a_full_disk_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk takes the name of the file and no byte of it."""
    opened = Path.open

    def full(path: Path, mode: str = "r", *others: object, **options: object) -> object:
        if "w" not in mode:
            return opened(path, mode, *others, **options)  # type: ignore[call-overload]
        path.touch()
        return opened(Path("/dev/full"), mode, *others, **options)  # type: ignore[call-overload]

    monkeypatch.setattr(Path, "open", full)
    code = run(["export", "urdf", "--robot", "nao-v6", "--out", str(tmp_path / "nao.urdf")])
    assert code == 3
    assert capsys.readouterr().err.splitlines() == [
        "error: nothing more can be written (No space left on device); make room, or write elsewhere."
    ]
    assert not list(tmp_path.iterdir())


def test_a_figure_whose_legend_takes_a_busy_machine_seconds_is_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Matplotlib warns where its search takes a second by the clock; these tests make errors of warnings."""
    seconds = count()
    monkeypatch.setattr(legend.time, "perf_counter", lambda: float(next(seconds)) * 2.0)
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0.0, 1.0], label="a line")
    axes.legend()
    assert save_figure(figure, tmp_path / "figure.png").stat().st_size > 0
