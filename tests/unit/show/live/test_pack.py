"""The bytes of a pack."""

import gzip
import json
import struct

from linkwright.stages.show.live.pack import Buffers, packed, unpacked


def test_pack_is_a_compressed_length_a_header_and_aligned_buffers():
    buffers = Buffers()
    places = [buffers.add(b"abc"), buffers.add(b"defgh"), buffers.add(b"abc")]
    assert places == [0, 4, 0]
    whole = gzip.decompress(packed({"name": "</script>é"}, buffers))
    (length,) = struct.unpack("<I", whole[:4])
    assert length % 4 == 0
    assert json.loads(whole[4 : 4 + length]) == {"name": "</script>é"}
    assert whole[4 + length :] == b"abc\0defgh\0\0\0"


def test_packs_are_read_back_and_equal_packs_are_equal_bytes():
    buffers = Buffers()
    buffers.add(b"1234")
    assert unpacked(packed({"a": [1, 2.5]}, buffers)) == ({"a": [1, 2.5]}, b"1234")
    assert packed({"a": 1}, Buffers()) == packed({"a": 1}, Buffers())
