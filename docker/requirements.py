"""Requirements of nao-hil with the extras named, one a line, and the lock's versions as constraints.

Usage: requirements.py FOLDER [EXTRA ...] writes FOLDER/requirements.txt and FOLDER/constraints.txt.
"""

import re
import sys
from pathlib import Path

import tomllib

HERE = Path(__file__).parent
ROOT = HERE if (HERE / "pyproject.toml").exists() else HERE.parent


def main(folder: Path, *extras: str) -> None:
    """Write both."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    of = project["optional-dependencies"]
    lines = [*project["dependencies"], *(line for extra in extras for line in of[extra])]
    (folder / "requirements.txt").write_text("\n".join(lines))
    # Constraints have no extras.
    lock = (ROOT / "requirements.lock").read_text()
    pins = re.findall(r"^([a-z0-9-]+)(?:\[.*\])?(==[^\\]*)", lock, re.MULTILINE)
    (folder / "constraints.txt").write_text("\n".join(name + pin.rstrip() for name, pin in pins))


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
