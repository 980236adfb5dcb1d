"""ALBehaviorManager on a robot on which no behaviour is installed."""

from __future__ import annotations

from typing import Any, NoReturn

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused


def behavior_methods() -> Table:
    """Methods of `ALBehaviorManager`: the lists are empty, and to run one fails as the vendor's page says."""

    def absent(method: str) -> Any:
        """A method that refuses a behaviour by its name."""

        def fail(name: Any, *_: Any) -> NoReturn:
            behavior = text(name, f"ALBehaviorManager.{method}: name")
            raise NaoqiRefused(
                f"ALBehaviorManager.{method}: the behaviour {behavior!r:.60} is not installed; none is on an "
                "emulated robot, and programs that move the joints themselves run."
            )

        return fail

    def installed(name: Any) -> bool:
        text(name, "ALBehaviorManager: name")
        return False

    def ignored(name: Any) -> None:
        text(name, "ALBehaviorManager: name")

    def by_tag(tag: Any) -> list[str]:
        text(tag, "ALBehaviorManager.getBehaviorsByTag: tag")
        return []

    lists = (
        *("getInstalledBehaviors", "getBehaviorNames", "getSystemBehaviorNames", "getUserBehaviorNames"),
        *("getRunningBehaviors", "getLoadedBehaviors", "getDefaultBehaviors", "getTagList"),
    )
    return {
        **{name: _nothing for name in lists},
        **{f"isBehavior{what}": installed for what in ("Installed", "Present", "Running", "Loaded")},
        **{
            name: absent(name)
            for name in (
                *("runBehavior", "startBehavior", "preloadBehavior", "addDefaultBehavior"),
                *("getBehaviorTags", "getBehaviorNature", "resolveBehaviorName", "removeBehavior"),
            )
        },
        "stopBehavior": ignored,
        "removeDefaultBehavior": ignored,
        "stopAllBehaviors": lambda: None,
        "playDefaultProject": lambda: None,
        "getBehaviorsByTag": by_tag,
    }


def _nothing() -> list[str]:
    return []
