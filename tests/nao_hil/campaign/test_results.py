"""Questions in SQL: the ten of the docs, rows that are not in a part yet, and mistakes in one sentence."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from bridge.errors import ConfigurationError
from nao_hil.campaigns.results import ask
from nao_hil.runs.config import RunConfig
from nao_hil.runs.dataset import Dataset
from nao_hil.runs.walk import Ending, Walk, WalkOutcome
from tests.made_walks import NO_TRACK, walk_end

PAGE = (Path(__file__).parents[3] / "docs/results.md").read_text()
QUESTIONS = re.findall(r"```sql\n(.*?)```", PAGE, re.DOTALL)


def outcome(seed: int, wear: str, ending: Ending) -> WalkOutcome:
    task = Walk(name=wear, config=RunConfig(seed=seed, wear=wear), duration=9.0, keep_track=False)
    return WalkOutcome(task, walk_end(ending, 1.0 + seed), NO_TRACK)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nominal robots walk on, worn ones fall but the first; the last is still in a journal."""
    found = tmp_path_factory.mktemp("runs")
    kept = Dataset(found / "a" / "walks")
    for seed in range(4):
        kept.put(outcome(seed, "nominal", "walked"), 0.5)
    kept.close()
    kept = Dataset(found / "b" / "walks", rows=4)
    for seed in range(4):
        kept.put(outcome(seed, "worn", "fell" if seed else "walked"), 0.5)
    other = Dataset(found / "c")
    other.put(outcome(7, "worn", "fell"), 0.5)
    other.put(outcome(0, "worn", "walked"), 0.5)  # walked before, elsewhere
    (journal,) = (found / "c" / "journal").iterdir()
    text = journal.read_bytes()
    other.close()
    for part in (found / "c").glob("part-*"):
        part.unlink()
    journal.write_bytes(text + b'{"key": "half')
    return found


@pytest.mark.parametrize("query", QUESTIONS)
def test_each_question_of_the_page_has_an_answer(query: str, folder: Path) -> None:
    assert ask(query, folder).rows


def test_each_walk_is_a_row_once_wherever_it_is_kept(folder: Path) -> None:
    (row,) = ask("SELECT count(*), sum(survived::int), count(DISTINCT folder) FROM walks", folder).rows
    assert row == (9, 5, 3)


def test_mistakes_are_one_sentence(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"the query is wrong: .*hight"):
        ask("SELECT hight FROM walks", folder)
    with pytest.raises(ConfigurationError, match="the query is empty"):
        ask("", folder)
    with pytest.raises(ConfigurationError, match="only one SELECT"):
        ask("SELECT 1; SELECT 2", folder)
    with pytest.raises(ConfigurationError, match="no walks are kept there"):
        ask("SELECT 1", tmp_path)
    kept = Dataset(tmp_path / "walks")
    kept.put(outcome(0, "nominal", "walked"), 0.5)
    kept.close()
    (part,) = (tmp_path / "walks").rglob("part-*.parquet")
    part.write_bytes(part.read_bytes()[:100])
    with pytest.raises(ConfigurationError, match=part.name):
        ask("SELECT count(*) FROM walks", tmp_path)


@pytest.mark.parametrize(
    "query", ["COPY (SELECT * FROM walks) TO '{file}'", "SELECT 1; EXPORT DATABASE '{file}'"]
)
def test_a_query_writes_no_file(query: str, folder: Path, tmp_path: Path) -> None:
    file = tmp_path / "written"
    with pytest.raises(ConfigurationError, match=r"the query is a (COPY|EXPORT); .* SELECT"):
        ask(query.format(file=file), folder)
    assert not file.exists()
    assert len(ask("PIVOT walks ON wear USING count(*) GROUP BY seed", folder).columns) == 3


def test_pairs_of_the_page_are_those_of_common_seeds(folder: Path) -> None:
    """Four seeds walked in both wears: the fifth worn walk has no partner; p = 2 / 2^3."""
    assert ask(next(q for q in QUESTIONS if "mcnemar" in q), folder).rows == [(4, 3, 0, 0.25)]
