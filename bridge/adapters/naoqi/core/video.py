"""ALVideoDevice: subscriptions to the two cameras, and their pictures (vendor's page on ALVideoDevice)."""

from __future__ import annotations

import logging
import math
import threading
import time
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.core.memory import stamp
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import OneOf, Own, Range, Vector, offers, text
from bridge.body.cameras import cameras
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)

RESOLUTIONS: Final = {0: 160, 1: 320, 2: 640, 3: 1280, 4: 2560, 7: 80, 8: 40}
"""Columns by NAOqi's number; three rows for four columns."""
PIXEL_BYTES: Final = {**dict.fromkeys(range(9), 1), 9: 2, 10: 3, 11: 3, 12: 3, 13: 3}
"""Bytes for a pixel by NAOqi's number of the colour space."""
MAX_RATE: Final = 30
"""Pictures a second."""
MAX_PER_NAME: Final = 6
"""Subscriptions of one name (vendor's page)."""
MAX_SUBSCRIPTIONS: Final = 100
PARAMETERS: Final = {
    **{0: 55, 1: 32, 2: 128, 3: 0, 6: 32, 7: 0, 8: 0, 11: 1, 12: 1, 13: 0, 17: 100},
    **{22: 1, 24: 0, 33: 4000, 34: 1, 35: 0, 40: 0, 43: 0},
}
"""Default by NAOqi's number; of 13, 17, 33, 40 and 43 assumed."""
_CAMERA_SELECT_ID: Final = 18
"""`kCameraSelectID`"""
NO_VALUE: Final = 233493508
"""Result of `getParameter` for an unknown parameter (vendor's page)."""
_MODELS: Final = {640: 1, 1280: 2, 2560: 3}
"""OV7670 of V3, MT9M114 of V4 and V5, OV5640 of V6, by the top camera's largest picture."""


@dataclass
class _CameraSubscription:
    camera: int
    resolution: int
    space: int
    rate: int
    due: float = 0.0
    """Earliest time of the next picture, this machine's clock, s."""


_CAMERA: Final = OneOf("camera", (0, 1))
CameraNumber = Annotated[int, _CAMERA]
"""0 top, 1 bottom."""
ColourSpace = Annotated[int, OneOf("colour space", PIXEL_BYTES)]
Rate = Annotated[int, Range(1, MAX_RATE)]
Pair = Annotated[list[float], Vector("x, y", -10.0, 10.0)]
Handle = Annotated[_CameraSubscription, Own("_subscription")]
"""Handle of a subscription, by its handle or name."""


class VideoDevice(Service):
    """Methods of `ALVideoDevice`."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._cameras, self._feed = cameras(robot.body), robot.feed
        self._subscriptions: dict[str, _CameraSubscription] = {}
        self._active = 0
        self._parameters: tuple[dict[int, int], dict[int, int]] = (dict(PARAMETERS), dict(PARAMETERS))

    @offers("ALVideoDevice.subscribeCamera")
    def subscribe_camera(
        self, name: str, camera: CameraNumber, resolution: Any, space: ColourSpace, rate: Rate
    ) -> str:
        """Subscribe to pictures; the handle of the subscription.

        Args:
            name: of the subscriber; the handle is this and a number.
            camera: 0 top, 1 bottom.
            resolution: a key of `RESOLUTIONS`.
            space: a key of `PIXEL_BYTES`.
            rate: pictures a second, 1 to 30.
        """
        method = "ALVideoDevice.subscribeCamera"
        size = self._resolution(resolution, camera, method)
        for i in range(MAX_PER_NAME):
            handle = f"{name}_{i}"
            if handle not in self._subscriptions and len(self._subscriptions) < MAX_SUBSCRIPTIONS:
                self._subscriptions[handle] = _CameraSubscription(camera, size, space, rate)
                return handle
        raise NaoqiRefused(
            f"{method}: {name!r:.40} has {MAX_PER_NAME} subscriptions already; unsubscribe some."
        )

    @offers("ALVideoDevice.subscribe")
    def subscribe(self, name: str, resolution: Any, space: ColourSpace, rate: Rate) -> str:
        """As `subscribe_camera`, to the active camera."""
        return self.subscribe_camera(name, self._active, resolution, space, rate)

    @offers("ALVideoDevice.unsubscribe")
    def unsubscribe(self, handle: str) -> bool:
        """End a subscription; False: there is none."""
        return any(self._subscriptions.pop(known, None) for known in (handle, f"{handle}_0"))

    @offers("ALVideoDevice.getImageRemote", "ALVideoDevice.getImageLocal")
    def image(self, handle: Handle) -> Future[Any] | None:
        """The picture of a subscription, the 12 entries of the vendor's page; waits for the next one's time.

        None: no such handle.
        """
        if handle.rate <= 0:
            logger.warning("ALVideoDevice: a program without a subscription gets no picture")
            return None
        camera, width = self._cameras[handle.camera], RESOLUTIONS[handle.resolution]
        height = 3 * width // 4
        done: Future[Any] = Future()

        def took(picture: Future[Any]) -> None:
            """Pass the picture, or its error, to the caller."""
            error = picture.exception()
            if error is not None:
                done.set_exception(error)
                return
            moment, data = picture.result()
            across, down = 0.5 * camera.field[0], 0.5 * camera.field[1]
            head = [width, height, PIXEL_BYTES[handle.space], handle.space, *stamp(moment), data, handle.camera]
            done.set_result([*head, across, -down, -across, down])

        def take() -> None:
            try:
                self._feed.picture(handle.camera, width, height, handle.space).add_done_callback(took)
            except NaoqiRefused as error:
                done.set_exception(error)

        now = time.monotonic()
        wait, handle.due = handle.due - now, max(handle.due, now) + 1.0 / handle.rate
        if wait <= 0.0:
            take()
        else:
            timer = threading.Timer(wait, take)
            timer.daemon = True
            timer.start()
        return done

    def _subscription(self, handle: Any) -> _CameraSubscription:
        """The subscription of a handle or a name, or a new one without effect."""
        name = text(handle, "ALVideoDevice: handle")
        found = self._subscriptions.get(name) or self._subscriptions.get(f"{name}_0")
        return found or _CameraSubscription(self._active, -1, -1, -1)

    @offers("ALVideoDevice.setCameraParameter")
    def _set_of(self, handle: Any, parameter: Any, value: Annotated[float, Range(-1e6, 1e6)] | None) -> bool:
        """`setCameraParameter`, also before a subscription; `kCameraSelectID` chooses the camera."""
        if parameter == _CAMERA_SELECT_ID:
            known = {h for h in (handle, f"{handle}_0") if h in self._subscriptions}
            return self._set_active(known.pop(), value) if known else self._set_active(value)
        return self._set_parameter(self._subscription(handle).camera, parameter, value)

    def _resolution(self, resolution: Any, camera: int, method: str) -> int:
        there = [k for k, v in RESOLUTIONS.items() if v <= self._cameras[camera].largest]
        return int(OneOf("resolution", there)(resolution, f"{method}: resolution"))

    @offers("ALVideoDevice.getActiveCamera")
    def _get_active(self, handle: Any = None) -> int:
        return self._active if handle is None else self._subscription(handle).camera

    @offers("ALVideoDevice.setActiveCamera")
    def _set_active(self, first: Any, camera: Any = None) -> bool:
        """`(camera)` for all subscriptions by `subscribe`, or `(handle, camera)`."""
        number = _CAMERA(first if camera is None else camera, "ALVideoDevice.setActiveCamera: camera")
        if camera is not None:
            self._subscription(first).camera = number
            return True
        self._active = number
        for subscription in self._subscriptions.values():
            subscription.camera = number
        return True

    @offers("ALVideoDevice.setResolution")
    def _set_resolution(self, handle: Handle, resolution: Any) -> bool:
        handle.resolution = self._resolution(resolution, handle.camera, "ALVideoDevice.setResolution")
        return True

    @offers("ALVideoDevice.setColorSpace")
    def _set_space(self, handle: Handle, space: ColourSpace) -> bool:
        handle.space = space
        return True

    @offers("ALVideoDevice.setFrameRate")
    def _set_rate(self, handle: Handle, rate: Rate) -> bool:
        handle.rate = rate
        return True

    @offers(
        *(f"ALVideoDevice.{done}Camera" for done in ("open", "close", "start", "stop")),
    )
    @offers("ALVideoDevice.isCameraOpen", "ALVideoDevice.isCameraStarted")
    def _is_there(self, camera: CameraNumber) -> bool:
        return True

    @offers("ALVideoDevice.getCameraName")
    def _camera_name(self, camera: CameraNumber) -> str:
        return self._cameras[camera].name

    @offers("ALVideoDevice.getCameraModel")
    def _camera_model(self, camera: CameraNumber) -> int:
        return _MODELS[self._cameras[0].largest]

    @offers("ALVideoDevice.getHorizontalFOV", axis=0)
    @offers("ALVideoDevice.getVerticalFOV", axis=1)
    def _field(self, camera: CameraNumber, *, axis: int) -> float:
        return self._cameras[camera].field[axis]

    @offers("ALVideoDevice.getParameter")
    def _get_parameter(self, camera: CameraNumber, parameter: Any) -> int:
        return self._parameters[camera].get(parameter, NO_VALUE) if isinstance(parameter, int) else NO_VALUE

    @offers("ALVideoDevice.setParameter")
    def _set_parameter(
        self, camera: CameraNumber, parameter: Any, value: Annotated[float, Range(-1e6, 1e6)] | None = None
    ) -> bool:
        """Store a parameter, without a value its default; False: there is none."""
        if not isinstance(parameter, int) or parameter not in PARAMETERS:
            return False
        self._parameters[camera][parameter] = PARAMETERS[parameter] if value is None else round(value)
        return True

    @offers("ALVideoDevice.setParam")
    def _old_set(self, parameter: Any, value: Annotated[float, Range(-1e6, 1e6)] | None) -> bool:
        """`setParam` of the active camera; `kCameraSelectID` chooses it."""
        if parameter == _CAMERA_SELECT_ID:
            return self._set_active(value)
        return self._set_parameter(self._active, parameter, value)

    @offers("ALVideoDevice.unsubscribeAllInstances")
    def _unsubscribe_all(self, name: str) -> None:
        for handle in [h for h in self._subscriptions if name in (h, h.rpartition("_")[0])]:
            del self._subscriptions[handle]

    @offers("ALVideoDevice.setAllParametersToDefault")
    def _reset(self, camera: CameraNumber) -> bool:
        self._parameters[camera].update(PARAMETERS)
        return True

    @offers("ALVideoDevice.getAngularPositionFromImagePosition")
    def _angles(self, camera: CameraNumber, position: Pair) -> list[float]:
        """Angles to the left and down, rad, of a place in the picture, 0 to 1 from its upper left corner."""
        across, down = self._tangents(camera)
        x, y = position
        return [math.atan((1.0 - 2.0 * x) * across), math.atan((2.0 * y - 1.0) * down)]

    @offers("ALVideoDevice.getImagePositionFromAngularPosition")
    def _place(self, camera: CameraNumber, angles: Pair) -> list[float]:
        across, down = self._tangents(camera)
        left, below = angles
        return [0.5 - 0.5 * math.tan(left) / across, 0.5 + 0.5 * math.tan(below) / down]

    @offers("ALVideoDevice.getAngularSizeFromImageSize")
    def _angular_size(self, camera: CameraNumber, size: Pair) -> list[float]:
        return [2.0 * math.atan(s * t) for s, t in zip(size, self._tangents(camera), strict=True)]

    @offers("ALVideoDevice.getImageSizeFromAngularSize")
    def _image_size(self, camera: CameraNumber, size: Pair) -> list[float]:
        return [math.tan(0.5 * a) / t for a, t in zip(size, self._tangents(camera), strict=True)]

    def _tangents(self, camera: int) -> tuple[float, float]:
        """Tangents of half the fields of view."""
        across, down = self._cameras[camera].field
        return math.tan(0.5 * across), math.tan(0.5 * down)

    @offers("ALVideoDevice.getParam")
    def _get_param(self, parameter: Any) -> Any:
        return self._active if parameter == _CAMERA_SELECT_ID else self._get_parameter(self._active, parameter)

    @offers("ALVideoDevice.setParameterToDefault")
    def _set_parameter_to_default(self, camera: CameraNumber, parameter: Any) -> Any:
        return self._set_parameter(camera, parameter)

    @offers("ALVideoDevice.getCameraParameter")
    def _get_camera_parameter(self, handle: Handle, parameter: Any) -> Any:
        return self._get_parameter(handle.camera, parameter)

    @offers("ALVideoDevice.setAllCameraParametersToDefault")
    def _set_all_camera_parameters_to_default(self, handle: Handle) -> Any:
        return self._reset(handle.camera)

    _get_subscribers = offers("ALVideoDevice.getSubscribers")(lambda self: list(self._subscriptions))

    @offers("ALVideoDevice.releaseImage")
    def _release_image(self, handle: Handle) -> bool:
        return handle.rate > 0

    @offers("ALVideoDevice.getResolution", quantity="resolution")
    @offers("ALVideoDevice.getColorSpace", quantity="space")
    @offers("ALVideoDevice.getFrameRate", quantity="rate")
    def _get(self, handle: Handle, *, quantity: str) -> Any:
        return getattr(handle, quantity)
