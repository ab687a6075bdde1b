"""Writes an animated WebP; the only module that uses pillow."""

import io
from collections.abc import Sequence

from PIL import Image

from linkwright.stages.show.raster import Pixels

QUALITY = 90


def encode(frames: Sequence[Pixels], duration: int) -> bytes:
    """Encodes pictures of the same size as an animation in a loop; `duration`: the time [ms] of each
    picture."""
    images = [Image.fromarray(frame) for frame in frames]
    file = io.BytesIO()
    images[0].save(
        file,
        format="WEBP",
        save_all=True,
        append_images=images[1:],
        duration=duration,
        loop=0,
        quality=QUALITY,
        method=4,
    )
    return file.getvalue()
