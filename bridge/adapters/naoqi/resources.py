"""ALResourceManager: resources that programs reserve among themselves (vendor's page)."""

from __future__ import annotations

from typing import Any, Final

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused
from bridge.validation import unknown_name

_SERVICE: Final = "ALResourceManager"
FREE: Final = "Free"
"""Owner of a resource that nobody has (assumed)."""
MAX_RESOURCES: Final = 1000


class Resources:
    """Methods of the service; not thread-safe, the caller locks."""

    def __init__(self) -> None:
        self._parents: dict[str, str] = {}
        """Resource -> the one that it is part of, or nothing."""
        self._owners: dict[str, str] = {}

    def _known(self, name: Any) -> str:
        resource = text(name, f"{_SERVICE}: resource")
        if resource not in self._parents:
            raise NaoqiRefused(f"{_SERVICE}: {unknown_name('resource', resource, self._parents)}.")
        return resource

    def _all(self, names: Any) -> list[str]:
        if not isinstance(names, list):
            raise NaoqiRefused(f"{_SERVICE}: {names!r:.60} was given; a list of resources is expected.")
        return [self._known(name) for name in names]

    def _create(self, name: Any, parent: Any) -> None:
        resource = text(name, f"{_SERVICE}.createResource: resource")
        above = self._known(parent) if parent != "" else ""
        if len(self._parents) >= MAX_RESOURCES:
            raise NaoqiRefused(f"{_SERVICE}.createResource: {MAX_RESOURCES} resources are there; delete some.")
        if self._within(above, resource):
            raise NaoqiRefused(f"{_SERVICE}.createResource: {above!r} is part of {resource!r} already.")
        self._parents[resource] = above

    def _create_all(self, names: Any, parent: Any) -> None:
        for name in names if isinstance(names, list) else [names]:
            self._create(name, parent)

    def _delete(self, name: Any, *_: Any) -> None:
        resource = self._known(name)
        for one in [one for one in self._parents if self._within(one, resource)]:
            del self._parents[one]
            self._owners.pop(one, None)

    def _within(self, resource: str, group: str) -> bool:
        """Whether a resource is a group, or part of it."""
        while resource and resource != group:
            resource = self._parents.get(resource, "")
        return bool(resource)

    def _free(self, name: Any) -> bool:
        """Whether nobody has a resource, a part of it, or what it is part of."""
        wanted = self._known(name)
        return not any(self._within(one, wanted) or self._within(wanted, one) for one in self._owners)

    def _acquire(self, names: Any, owner: Any, *_: Any) -> None:
        who = text(owner, f"{_SERVICE}.acquireResource: module")
        wanted = self._all(names if isinstance(names, list) else [names])
        for one in wanted:
            if self._owners.get(one) != who and not self._free(one):
                raise NaoqiRefused(f"{_SERVICE}.acquireResource: {one} is not free; {self._owner(one)} has it.")
        self._owners.update(dict.fromkeys(wanted, who))

    def _owner(self, wanted: str) -> str:
        near = (
            who for one, who in self._owners.items() if self._within(one, wanted) or self._within(wanted, one)
        )
        return next(near, FREE)

    def _release(self, names: Any, owner: Any) -> None:
        who = text(owner, f"{_SERVICE}.releaseResource: owner")
        for one in self._all(names if isinstance(names, list) else [names]):
            if self._owners.get(one) == who:
                del self._owners[one]

    def _owned(self, names: Any, owner: Any) -> bool:
        return all(self._owners.get(one) == owner for one in self._all(names))

    def methods(self) -> Table:
        """Methods of the service."""
        return {
            "createResource": self._create,
            "createResourcesList": self._create_all,
            "deleteResource": self._delete,
            "getResources": lambda: list(self._parents),
            "isInGroup": lambda group, name: self._within(self._known(name), self._known(group)),
            "isResourceFree": self._free,
            "areResourcesFree": lambda names: all(map(self._free, self._all(names))),
            "areResourcesOwnedBy": self._owned,
            "ownersGet": lambda: [[one, self._owner(one)] for one in self._parents],
            "acquireResource": self._acquire,
            "acquireResourcesTree": self._acquire,
            "waitForResource": self._acquire,
            "waitForResourcesTree": self._acquire,
            "releaseResource": self._release,
            "releaseResources": self._release,
        }
