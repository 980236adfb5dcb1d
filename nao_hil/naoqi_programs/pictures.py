"""Pictures as a robot gives them: qi's package for Python sends no bytes, so the server sends text for them."""

from __future__ import annotations

from typing import Any

SERVICE = "ALVideoDevice"
_METHODS = ("getImageRemote", "getImageLocal")


class VideoProxy:
    """The service with the bytes of its pictures as a `bytearray`.

    Args:
        service: qi's object.
    """

    def __init__(self, service: Any) -> None:
        self._service = service

    def __getattr__(self, method: str) -> Any:
        call = getattr(self._service, method)
        return (lambda *a, **options: _with_bytes(call(*a, **options))) if method in _METHODS else call


def _with_bytes(image: Any) -> Any:
    if hasattr(image, "andThen"):  # a future
        return image.andThen(_with_bytes)
    return [bytearray(part, "latin-1") if isinstance(part, str) else part for part in image]
