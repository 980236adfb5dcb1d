"""The doctor's verdicts, each from a value given to it, and one look at this machine as it is."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

import pytest

from bridge.histogram import Percentiles
from emulator.timing import CycleTimes
from nao_hil.cli import doctor
from nao_hil.cli.main import run


def times(p99: float, skipped: int = 0) -> CycleTimes:
    late = Percentiles(count=100, p50=1e-4, p99=p99, max=2 * p99)
    return CycleTimes(cycles=100, skipped=skipped, lateness=late, work=late)


@pytest.mark.parametrize(
    ("finding", "verdict", "word"),
    [
        (doctor.python_finding((3, 10, 0)), "good", "3.10.0"),
        (doctor.python_finding((3, 9, 18)), "bad", "3.9.18"),
        (doctor.cores_finding(2), "good", "2"),
        (doctor.cores_finding(1), "warning", "1"),
        (doctor.timer_finding(times(4e-4)), "good", "400 us (p99)"),
        (doctor.timer_finding(times(4e-3)), "warning", "4000 us (p99)"),
        (doctor.timer_finding(times(4e-4, skipped=3)), "warning", "3 of 103 cycles skipped"),
        (doctor.timer_finding(None), "warning", "not measured"),
        (doctor.real_time_finding(True), "good", "permitted"),
        (doctor.real_time_finding(False), "warning", "not permitted"),
        (doctor.package_finding("dev", "pytest"), "good", version("pytest")),
        (doctor.package_finding("emulator", "no-such-package-of-any-kind"), "warning", "not installed"),
    ],
)
def test_verdicts(finding: doctor.Finding, verdict: str, word: str) -> None:
    assert finding.verdict == verdict
    assert word in finding.value
    assert finding.advice


def test_findings_that_keep_it_from_working_have_exit_code_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = doctor.python_finding((3, 9, 0))
    monkeypatch.setattr(doctor, "diagnose", lambda: [bad, doctor.cores_finding(1)])
    assert run(["doctor"]) == 3
    printed = capsys.readouterr().out
    assert "bad" in printed and "warning" in printed
    monkeypatch.setattr(doctor, "diagnose", lambda: [doctor.cores_finding(1)])
    assert run(["doctor"]) == 0


@pytest.mark.parametrize(
    ("name", "python", "machine", "word"),
    [
        ("pybullet", (3, 13, 0), "x86_64", "Python 3.11 or older on x86-64 has one"),
        ("qi", (3, 13, 0), "x86_64", "Python 3.12 or older on x86-64 has one"),
        ("qi", (3, 11, 0), "aarch64", "Python 3.12 or older on x86-64 has one"),
        ("qi", (3, 12, 0), "x86_64", "pip install 'nao-hil[naoqi]'"),
    ],
)
def test_no_package_is_advised_that_there_is_not(
    name: str, python: tuple[int, ...], machine: str, word: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(_: str) -> str:
        raise PackageNotFoundError

    monkeypatch.setattr(doctor, "version", missing)
    monkeypatch.setattr(doctor.sys, "version_info", python)
    monkeypatch.setattr(doctor.platform, "machine", lambda: machine)
    extra = next(extra for extra, names in doctor.EXTRAS.items() if name in names)
    finding = doctor.package_finding(extra, name)
    assert word in finding.advice
    assert ("pip install" in finding.advice) == ("pip install" in word)
