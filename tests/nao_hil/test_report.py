"""The report and the command that makes it."""

import base64
import json
import re
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from nao_hil.analysis.report.render import Claim, Picture, Report, ReportPage, ReportTable, write_report
from nao_hil.cli.main import run
from tests.loops import TIMEOUT, until

PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


def test_one_file_holds_claims_figures_and_verdicts_and_loads_nothing(tmp_path: Path) -> None:
    picture = tmp_path / "curve.png"
    picture.write_bytes(PNG)
    page = ReportPage(
        name="made-up",
        title="Made up",
        source="Thesis, figure 4.1",
        setup=(("gait", "static"),),
        claims=(Claim("With it x < 5 & more", "4 of 5", True), Claim("Without it", "none", False)),
        pictures=(Picture(picture, "Figure 4.1", "A curve"),),
        tables=(ReportTable("Conditions", ("condition", "n"), (("with", "5"),)),),
        findings=("It leans.",),
    )
    report = Report("Title", [page], [("robot", "nao-v3")], 'torso = "robust"', [("slope", "interrupted")])
    write_report(tmp_path / "report.html", report)
    html = (tmp_path / "report.html").read_text()
    assert "With it x &lt; 5 &amp; more" in html
    assert base64.b64encode(PNG).decode() in html
    assert "does not hold" in html and "not confirmed" in html and "not done" in html
    assert "It leans." in html and "1 of 2" in html
    assert replace(page, claims=()).verdict == "measured"
    links = re.findall(r'(?:src|href)="([^"]*)"', html)
    assert links and all(link.startswith(("data:", "#")) for link in links)
    assert "<script" not in html and "@import" not in html and "url(" not in html


def test_an_experiment_ends_with_its_json_and_leaves_a_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        run(["experiment", "spring", "--seeds", "2", "--first-seed", "5", "--out", str(tmp_path), "--json"])
        == 0
    )
    data = json.loads(capsys.readouterr().out)
    assert data["name"] == "spring" and data["passed"] is True
    assert (data["seeds"], data["first_seed"], data["wear"]) == (2, 5, "nominal")
    assert data["pole_m"] == pytest.approx(0.0329, abs=1e-4)
    assert json.loads((tmp_path / "spring.json").read_text())["n"] == 2
    assert json.loads((tmp_path / "summary.json").read_text()) == data
    assert "32.9 mm" in (tmp_path / "report.html").read_text()


def test_ctrl_c_ends_with_a_report_on_what_is_there(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [
        sys.executable,
        "-m",
        "nao_hil.cli",
        "experiment",
        "obstacle",
        "--seeds",
        "200",
        "--out",
        str(out),
    ]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            until(lambda: process.poll() is not None or (out / "walks").exists(), "the first walk")
            process.send_signal(signal.SIGINT)
            error = process.communicate(timeout=TIMEOUT)[1]
        finally:
            process.kill()
    assert process.returncode == 130, error
    assert "Interrupted" in error and "Traceback" not in error
    assert "not done" in (out / "report.html").read_text()
    assert json.loads((out / "summary.json").read_text())["passed"] is False
