"""Requirements of nao-hil with the extras named, one a line, and the lock's versions as constraints.

Usage: requirements.py [EXTRA ...] > requirements.txt; requirements.py --constraints > constraints.txt
"""

import re
import sys
from pathlib import Path

import tomllib

HERE = Path(__file__).parent
ROOT = HERE if (HERE / "pyproject.toml").exists() else HERE.parent


def main(arguments: list[str]) -> None:
    """Print what was asked for."""
    if arguments == ["--constraints"]:
        lock = (ROOT / "requirements.lock").read_text()
        # Constraints have no extras.
        pins = re.findall(r"^([a-z0-9-]+)(?:\[.*\])?(==[^\\]*)", lock, re.MULTILINE)
        print("\n".join(name + pin.rstrip() for name, pin in pins))
        return
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for line in project["dependencies"]:
        print(line)
    for extra in arguments:
        for line in project["optional-dependencies"][extra]:
            print(line)


if __name__ == "__main__":
    main(sys.argv[1:])
