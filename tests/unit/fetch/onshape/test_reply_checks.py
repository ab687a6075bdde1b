"""What a refused reply leaves behind."""

import tracemalloc

import pytest

from linkwright.stages.fetch.onshape.replies.checks import check
from linkwright.stages.robot.errors import ProtocolError

REQUEST = "/partstudios/d/a/m/b/e/c/massproperties?partId="
MANY = 200_000


def test_the_error_about_a_reply_does_not_keep_what_it_was_parsed_to() -> None:
    """Errors of several replies are kept until the build ends: together they would fill the memory."""
    body = b'{"bodies":[' + b"[]," * MANY + b"[]]}"
    tracemalloc.start()
    try:
        with pytest.raises(ProtocolError, match="has no bodies") as raised:
            check(REQUEST, body)
        held, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert raised.value.__traceback__
    assert peak > 50 * MANY  # an empty list takes 56 bytes
    assert held < MANY
