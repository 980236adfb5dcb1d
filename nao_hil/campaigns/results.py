"""Questions to the data sets below a folder, in SQL."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, NamedTuple

from bridge.errors import ConfigurationError
from nao_hil.runs.store import Row

_SQL: Final = {"str": "VARCHAR", "int": "BIGINT", "float": "DOUBLE", "bool": "BOOLEAN"}
COLUMNS: Final = {name: _SQL.get(kind, "VARCHAR") for name, kind in Row.__annotations__.items()}
"""Columns of the view `walks`, besides `folder`, the data set that has the row."""


_READS: Final = ("SELECT", "CREATE")
"""Kinds of statements that change no file; a PIVOT creates a type in memory."""


class QueryResult(NamedTuple):
    """An answer."""

    columns: list[str]
    rows: list[tuple[Any, ...]]


def ask(query: str, folder: Path) -> QueryResult:
    """Answer a query about the view `walks`: every walk of every data set below a folder, each key once.

    `mcnemar(only_first, only_second)` is a function of the language.

    Args:
        query: SQL as DuckDB has it.
        folder: Searched with all below it; rows of campaigns that still run are seen too.

    Raises:
        ConfigurationError: DuckDB is not installed, there are no walks, or the query is wrong or
            no question.
    """
    try:
        import duckdb
    except ModuleNotFoundError:
        raise ConfigurationError("`results` needs duckdb; install nao-hil[campaign].") from None
    from nao_hil.analysis.statistics import mcnemar  # imported late: SciPy takes time

    parts = sorted(map(str, folder.rglob("part-*.parquet")))
    journals = sorted(str(path) for path in folder.rglob("journal/*.jsonl") if path.stat().st_size)
    if not parts and not journals:
        raise ConfigurationError(f"{folder}: no walks are kept there or below; give the folder of a campaign.")
    sources = []
    if parts:
        sources.append(f"SELECT {', '.join(COLUMNS)}, filename FROM read_parquet({parts}, filename = true)")
    if journals:
        kinds = "{" + ", ".join(f"'{name}': '{kind}'" for name, kind in COLUMNS.items()) + "}"
        sources.append(
            f"SELECT {', '.join(COLUMNS)}, filename FROM read_json({journals}, format = 'newline_delimited', "
            f"columns = {kinds}, ignore_errors = true, filename = true)"
        )
    view = (
        f"CREATE VIEW walks AS SELECT DISTINCT ON (key) * EXCLUDE filename, "
        f"regexp_replace(filename, '(/journal)?/[^/]*$', '') AS folder FROM ({' UNION ALL '.join(sources)}) "
        "WHERE key IS NOT NULL"
    )
    # Its threads spin while they wait: with fewer processors than threads a question takes minutes.
    with duckdb.connect(config={"threads": 1}) as connection:
        connection.create_function("mcnemar", mcnemar, ["BIGINT", "BIGINT"], "DOUBLE")
        try:
            connection.execute(view)
        except duckdb.Error as error:
            reason = str(error).splitlines()[0]
            raise ConfigurationError(
                f"{folder}: some walks cannot be read ({reason}); without that file they are walked again."
            ) from None
        try:
            statements = connection.extract_statements(query)
            if not statements:
                raise ConfigurationError("the query is empty; ask such as `SELECT count(*) FROM walks`.")
            asked = [statement.type.name for statement in statements]
            for kind in asked:
                if kind not in _READS:
                    raise ConfigurationError(f"the query is a {kind}; results only answers, ask with SELECT.")
            if asked.count("SELECT") > 1:
                raise ConfigurationError("the query asks more than once; only one SELECT is answered.")
            answer = connection.execute(query)
            columns = [column[0] for column in answer.description or []]
            return QueryResult(columns, answer.fetchall())
        except duckdb.Error as error:
            sentence = str(error).splitlines()[0]
            raise ConfigurationError(f"the query is wrong: {sentence}") from None
