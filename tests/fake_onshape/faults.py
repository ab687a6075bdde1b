"""What can go wrong between a server and its client, and how it is put on the wire."""

import os
import socket
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

PIECE = 512
"""A slow body comes in pieces of this many bytes."""


@dataclass(frozen=True)
class Fault:
    """What a fault hook puts in place of a reply.

    `body`: None stands for the true reply's own, with its own status. `cut`: only so many bytes of
    the body are sent (as packed), then the connection ends; `claimed`: what is added to the true
    Content-Length; `reset`: the connection ends with a reset instead of an orderly close; `pause_s`:
    waited before each piece of the body; `silent`: nothing at all is sent, so nothing is billed;
    `endless`: the body is sent again and again, in chunks, until the client hangs up.
    """

    status: int = 200
    body: bytes | None = b""
    headers: Mapping[str, str] = field(default_factory=dict)
    cut: int | None = None
    claimed: int = 0
    reset: bool = False
    pause_s: float = 0.0
    silent: bool = False
    endless: bool = False

    @property
    def ends(self):
        """Whether the connection ends with this reply."""
        return self.cut is not None or bool(self.claimed) or self.reset or self.silent or self.endless


FaultHook = Callable[[str, str, int], Fault | None]


def send(handler, status, headers, body, fault):
    """Writes a reply as `fault` has it; a client that has hung up meanwhile is no error."""
    try:
        if not fault.silent:
            _write(handler, status, headers, body, fault)
        if fault.reset:
            _reset(handler.connection)
    except OSError:
        handler.close_connection = True
    if fault.ends:
        handler.close_connection = True


def _write(handler, status, headers, body, fault):
    handler.send_response_only(status)
    if fault.endless:
        _repeat(handler, headers, body)
        return
    handler.send_header("Content-Length", str(len(body) + fault.claimed))
    for name, value in {"Date": handler.date_time_string(), **headers}.items():
        handler.send_header(name, value)
    # One write: header and body in one packet keeps small replies quick.
    handler._headers_buffer.append(b"\r\n")
    sent = body if fault.cut is None else body[: fault.cut]
    if not fault.pause_s:
        handler._headers_buffer.append(sent)
        handler.flush_headers()
        return
    handler.flush_headers()
    for start in range(0, len(sent), PIECE):
        time.sleep(fault.pause_s)
        handler.wfile.write(sent[start : start + PIECE])
        handler.wfile.flush()


def _repeat(handler, headers, body):
    for name, value in {**headers, "Transfer-Encoding": "chunked"}.items():
        handler.send_header(name, value)
    handler.end_headers()
    while True:
        handler.wfile.write(b"%x\r\n%b\r\n" % (len(body), body))


def _reset(connection):
    # With this set, closing throws away what is unsent and sends a reset.
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    # What was written is given time to arrive, so that the reset comes within the body.
    time.sleep(0.005)
    os.close(connection.detach())
