"""An animated WebP of pictures: the one place that needs pillow."""

import io
from collections.abc import Sequence

from PIL import Image

from linkwright.stages.show.raster import Pixels

QUALITY = 90


def encode(frames: Sequence[Pixels], shown: int) -> bytes:
    """The file of pictures of one size, each `shown` for so many milliseconds, over and over."""
    images = [Image.fromarray(frame) for frame in frames]
    file = io.BytesIO()
    images[0].save(
        file,
        format="WEBP",
        save_all=True,
        append_images=images[1:],
        duration=shown,
        loop=0,
        quality=QUALITY,
        method=4,
    )
    return file.getvalue()
