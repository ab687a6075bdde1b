"""Only PNG files that MuJoCo reads are carried."""

import struct
import zlib

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats import png
from tests.support.textures import chunk, image

CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
ADAM7 = (0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)
"""Left, top and steps of the passes of an interlaced image."""


def accepted(data):
    """Whether MuJoCo loads a model with this image."""
    text = '<mujoco><asset><texture name="t" type="2d" file="t.png"/></asset></mujoco>'
    try:
        mujoco.MjModel.from_xml_string(text, assets={"t.png": data})
    except ValueError:
        return False
    return True


def made(width, height, depth, colour, interlace=0, short=0):
    """A black image; `short`: bytes that its pixels lack."""
    bits = depth * CHANNELS[colour]
    size = 0
    for left, top, right, down in ADAM7 if interlace else [(0, 0, 1, 1)]:
        columns, rows = len(range(left, width, right)), len(range(top, height, down))
        size += rows * (1 + (columns * bits + 7) // 8) if columns else 0
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, interlace)
    palette = chunk(b"PLTE", bytes(6)) if colour == 3 else b""
    packed = zlib.compress(bytes(size - short))
    content = [chunk(b"IDAT", piece) for piece in (packed[:5], packed[5:])]
    return b"".join([png.SIGNATURE, chunk(b"IHDR", header), palette, *content, chunk(b"IEND", b"")])


@pytest.mark.parametrize("interlace", [0, 1])
@pytest.mark.parametrize(("colour", "depth"), [(c, d) for c, depths in DEPTHS.items() for d in depths])
def test_carried_images_are_those_that_mujoco_reads(colour, depth, interlace):
    for width, height in ((1, 1), (3, 5), (5, 2), (8, 8), (17, 9)):
        good = made(width, height, depth, colour, interlace)
        assert (png.problem(good), accepted(good)) == ("", True)
        bad = made(width, height, depth, colour, interlace, short=1)
        assert (png.problem(bad), accepted(bad)) == ("it is damaged: its pixels are incomplete", False)


def test_bit_that_flips_is_seen_before_mujoco_sees_it():
    good = image()
    for place in range(len(good)):
        bad = good[:place] + bytes([good[place] ^ 4]) + good[place + 1 :]
        assert png.problem(bad)


def test_bomb_is_not_inflated():
    stream = zlib.compressobj()
    packed = b"".join([*(stream.compress(bytes(1 << 20)) for _ in range(8)), stream.flush()])
    header = struct.pack(">IIBBBBB", 4, 4, 8, 2, 0, 0, 0)
    bomb = b"".join([png.SIGNATURE, chunk(b"IHDR", header), chunk(b"IDAT", packed), chunk(b"IEND", b"")])
    assert png.problem(bomb) == "it is damaged: its pixels are incomplete"


def test_our_own_images_are_read():
    pixels = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    assert (png.problem(png.encode(pixels)), accepted(png.encode(pixels))) == ("", True)
