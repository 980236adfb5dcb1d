"""espeak-ng, where it is installed: the sound of the robot's voice on this machine."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Final

from bridge.errors import NaoqiRefused

PROGRAM: Final = "espeak-ng"
_WORDS_PER_MINUTE: Final = 150
LANGUAGES: Final = {
    "English": "en",
    "French": "fr",
    "German": "de",
    "Italian": "it",
    "Spanish": "es",
    "Dutch": "nl",
    "Japanese": "ja",
    "Chinese": "cmn",
    "Portuguese": "pt",
    "Brazilian": "pt-br",
    "Polish": "pl",
    "Czech": "cs",
    "Danish": "da",
    "Finnish": "fi",
    "Norwegian": "nb",
    "Swedish": "sv",
    "Greek": "el",
    "Turkish": "tr",
    "Russian": "ru",
    "Arabic": "ar",
    "Korean": "ko",
}
"""Language as NAOqi names it -> espeak-ng's voice."""


class Voice:
    """Speaks through espeak-ng; silent where it is not installed."""

    def __init__(self) -> None:
        self._program = shutil.which(PROGRAM)

    def speak(self, text: str, language: str, speed: float, volume: float) -> subprocess.Popen[bytes] | None:
        """Begin to speak; the process ends with the sound. None: there is no voice.

        Args:
            text: without marks.
            language: one of `LANGUAGES`.
            speed: per cent.
            volume: 0 to 1.
        """
        if self._program is None or not text:
            return None
        options = self._options(language, speed, volume)
        return subprocess.Popen(
            [self._program, *options, "--", text], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

    def write(self, text: str, language: str, speed: float, volume: float, path: Path) -> None:
        """Write the speech to a WAV file.

        Raises:
            NaoqiRefused: there is no voice, or the file cannot be written.
        """
        if self._program is None:
            raise NaoqiRefused(f"ALTextToSpeech.sayToFile needs {PROGRAM}, which is not installed.")
        command = [self._program, *self._options(language, speed, volume), "-w", str(path), "--", text]
        done = subprocess.run(command, capture_output=True, timeout=60.0, check=False)
        if done.returncode or not path.is_file():
            raise NaoqiRefused(f"ALTextToSpeech.sayToFile: {path} cannot be written.")

    def _options(self, language: str, speed: float, volume: float) -> list[str]:
        rate = round(_WORDS_PER_MINUTE * speed / 100.0)
        return ["-v", LANGUAGES[language], "-s", str(rate), "-a", str(round(100.0 * volume))]
