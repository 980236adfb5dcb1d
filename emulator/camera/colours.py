"""NAOqi's colour spaces by number: bytes of a picture, row by row (vendor's page on ALVideoDevice)."""

from __future__ import annotations

from io import BytesIO
from typing import Final

import numpy as np
from numpy.typing import NDArray

_YUV: Final = np.array(((0.299, 0.587, 0.114), (-0.168736, -0.331264, 0.5), (0.5, -0.418688, -0.081312)))
"""Full range (ITU-R BT.601, as JFIF has it); which range the robot's has is assumed."""


def encode_picture(rgb: NDArray[np.uint8], space: int) -> bytes:
    """The bytes of a picture in a colour space.

    Args:
        rgb: (height, width, 3), with an even width.
        space: 0 to 8 one channel (Y, U, V, R, G, B, H, S, Y), 9 YUV 4:2:2, 10 YUV, 11 RGB, 12 HSY, 13 BGR.
    """
    if space == 11:
        return rgb.tobytes()
    if space == 13:
        return rgb[..., ::-1].tobytes()
    if space in (3, 4, 5):
        return rgb[..., space - 3].tobytes()
    if space in (6, 7):
        return np.ascontiguousarray(_hue_saturation(rgb)[..., space - 6]).tobytes()
    yuv = _yuv(rgb)
    if space in (0, 8):
        return yuv[..., 0].tobytes()
    if space in (1, 2):
        return yuv[..., space].tobytes()
    if space == 9:
        pairs = np.empty((*rgb.shape[:2], 2), dtype=np.uint8)
        pairs[..., 0] = yuv[..., 0]
        mean = yuv[..., 1:].reshape(rgb.shape[0], -1, 2, 2).mean(axis=2)
        pairs[:, 0::2, 1], pairs[:, 1::2, 1] = mean[..., 0], mean[..., 1]
        return pairs.tobytes()
    if space == 12:
        return np.concatenate((_hue_saturation(rgb), yuv[..., :1]), axis=2).tobytes()
    return yuv.tobytes()


def picture_file(rgb: NDArray[np.uint8], space: int, kind: str) -> bytes:
    """A picture as a file, grey in a colour space of one channel.

    Args:
        rgb: (height, width, 3).
        space: see `encode_picture`.
        kind: `bmp`, `jpeg`, `png`, `ppm` or `tiff`.
    """
    from PIL import Image  # imported late: pictures that are not files do without

    grey = space < 9
    pixels = _yuv(rgb)[..., 0] if grey else rgb
    file = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, kind)
    return file.getvalue()


def _yuv(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    shifted = rgb.astype(np.float32) @ _YUV.T.astype(np.float32) + (0.0, 128.0, 128.0)
    whole: NDArray[np.uint8] = np.clip(shifted + 0.5, 0.0, 255.0).astype(np.uint8)
    return whole


def _hue_saturation(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Hue (a turn is 256) and saturation, as HSV has them."""
    c = rgb.astype(np.float32)
    high, low = c.max(axis=2), c.min(axis=2)
    span = np.maximum(high - low, 1e-6)
    r, g, b = c[..., 0], c[..., 1], c[..., 2]
    sixth = np.where(
        high == r, (g - b) / span % 6.0, np.where(high == g, (b - r) / span + 2.0, (r - g) / span + 4.0)
    )
    hue, saturation = sixth * (256.0 / 6.0), 255.0 * (high - low) / np.maximum(high, 1e-6)
    out: NDArray[np.uint8] = np.stack((hue, saturation), axis=2).astype(np.uint8)
    return out
