"""Pixels: blurred, enlarged and reduced; light as a screen shows it."""

import numpy as np

from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices, Numbers, Pixels

_STEPS = 4095


def blurred(values: Numbers, reach: int) -> Numbers:
    """Twice the mean over a square."""
    for _ in range(2):
        for axis in range(2):
            padded = np.pad(
                values, [(reach + 1, reach) if one == axis else (0, 0) for one in range(2)], "edge"
            )
            total = np.cumsum(padded, axis=axis)
            size = 2 * reach + 1
            after = np.take(total, np.arange(size, total.shape[axis]), axis=axis)
            before = np.take(total, np.arange(0, total.shape[axis] - size), axis=axis)
            values = (after - before) / size
    return values


def enlarged(values: Numbers, times: int) -> Numbers:
    """Each value `times` as large each way, with straight slopes between the middles."""
    for axis in range(2):
        count = values.shape[axis]
        at = np.clip((np.arange(count * times) + 0.5) / times - 0.5, 0, count - 1)
        low = np.minimum(at.astype(np.intp), max(count - 2, 0))
        share = (at - low).reshape([-1 if one == axis else 1 for one in range(2)])
        first, second = (np.take(values, np.minimum(low + i, count - 1), axis=axis) for i in range(2))
        values = first * (1 - share) + second * share
    return values


def scattered(rows: Indices, columns: Indices, turn: int = 0) -> Single:
    """(2, n): shifts of up to half a pixel each way, which neighbours have different: a 4 x 4 pattern, one of
    several by the `turn`."""
    place = ((rows + turn) % 4) * 4 + (columns + 2 * turn) % 4
    pattern = (np.array([0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5]) / 15.0 - 0.5).astype(
        np.float32
    )
    return np.stack([pattern[place], pattern[(place * 7 + 3 + 5 * turn) % 16]])


def linear(srgb: Numbers) -> Numbers:
    """Light from sRGB (IEC 61966-2-1)."""
    return np.asarray(np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4))


def shown(light: Numbers) -> Numbers:
    """sRGB of light; what is brighter than the picture can be rolls off."""
    soft = np.where(light < 0.7, light, 0.7 + 0.3 * (1 - np.exp(-(np.maximum(light, 0.7) - 0.7) / 0.3)))
    steps = np.linspace(0.0, 1.0, _STEPS + 1)
    table = np.where(steps <= 0.0031308, 12.92 * steps, 1.055 * steps ** (1 / 2.4) - 0.055)
    found: Numbers = table[np.rint(np.clip(soft, 0.0, 1.0) * _STEPS).astype(np.intp)]
    return found


def reduced(pixels: Pixels, times: int) -> Pixels:
    """A picture, `times` as small each way: each pixel the mean of those that were there."""
    height, width = pixels.shape[0] // times, pixels.shape[1] // times
    whole = pixels[: height * times, : width * times].reshape(height, times, width, times, 3)
    total = whole.sum(axis=(1, 3), dtype=np.uint32)
    return np.asarray(((total + times * times // 2) // (times * times)).astype(np.uint8))
