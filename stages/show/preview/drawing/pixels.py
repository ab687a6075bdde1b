"""Blurs, enlarges and reduces pixels; converts light for a screen."""

import numpy as np

from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices, Numbers, Pixels

_STEPS = 4095
"""Number of steps of the table from light to sRGB."""


def blur(values: Numbers, reach: int) -> Numbers:
    """Blurs values (height, width) by taking the mean over a square twice; `reach`: half the square's
    width."""
    for _ in range(2):
        for axis in range(2):
            widths = [(reach + 1, reach) if other == axis else (0, 0) for other in range(2)]
            padded = np.pad(values, widths, "edge")
            total = np.cumsum(padded, axis=axis)
            size = 2 * reach + 1
            after = np.take(total, np.arange(size, total.shape[axis]), axis=axis)
            before = np.take(total, np.arange(0, total.shape[axis] - size), axis=axis)
            values = (after - before) / size
    return values


def enlarge(values: Numbers, times: int) -> Numbers:
    """Enlarges values (height, width) `times` each way, interpolating between the centres."""
    for axis in range(2):
        count = values.shape[axis]
        position = np.clip((np.arange(count * times) + 0.5) / times - 0.5, 0, count - 1)
        low = np.minimum(position.astype(np.intp), max(count - 2, 0))
        share = (position - low).reshape([-1 if other == axis else 1 for other in range(2)])
        first, second = (np.take(values, np.minimum(low + i, count - 1), axis=axis) for i in range(2))
        values = first * (1 - share) + second * share
    return values


def pixel_shifts(rows: Indices, columns: Indices, turn: int = 0) -> Single:
    """Returns shifts (2, n) of up to half a pixel each way, different for neighbouring pixels: an ordered 4 x
    4 pattern (Bayer's matrix). `turn` chooses a variant of the pattern."""
    index = ((rows + turn) % 4) * 4 + (columns + 2 * turn) % 4
    pattern = (np.array([0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5]) / 15.0 - 0.5).astype(
        np.float32
    )
    return np.stack([pattern[index], pattern[(index * 7 + 3 + 5 * turn) % 16]])


def light_of_srgb(srgb: Numbers) -> Numbers:
    """Converts sRGB to linear light (IEC 61966-2-1)."""
    return np.asarray(np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4))


def srgb_of_light(light: Numbers) -> Numbers:
    """Converts linear light to sRGB; light near and above the picture's maximum is compressed."""
    compressed_light = np.where(
        light < 0.7, light, 0.7 + 0.3 * (1 - np.exp(-(np.maximum(light, 0.7) - 0.7) / 0.3))
    )
    steps = np.linspace(0.0, 1.0, _STEPS + 1)
    table = np.where(steps <= 0.0031308, 12.92 * steps, 1.055 * steps ** (1 / 2.4) - 0.055)
    srgb: Numbers = table[np.rint(np.clip(compressed_light, 0.0, 1.0) * _STEPS).astype(np.intp)]
    return srgb


def reduce_picture(pixels: Pixels, times: int) -> Pixels:
    """Reduces a picture `times` each way: each new pixel is the mean of the old pixels in it."""
    height, width = pixels.shape[0] // times, pixels.shape[1] // times
    blocks = pixels[: height * times, : width * times].reshape(height, times, width, times, 3)
    total = blocks.sum(axis=(1, 3), dtype=np.uint32)
    return np.asarray(((total + times * times // 2) // (times * times)).astype(np.uint8))
