"""What a command prints stays as it is."""

import pytest

from nao_hil.cli.console import open_console


@pytest.mark.parametrize(
    "text",
    [
        "82:93:CD:AB:71",  # `:CD:` and `:AB:` are names of emoji
        "/data/[a]/run",  # `[a]` is no style
        "pip install 'nao-hil[view]'",
    ],
)
def test_text_is_neither_emoji_nor_markup(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    open_console().print(text)
    assert capsys.readouterr().err == text + "\n"
