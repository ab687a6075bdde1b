"""Runs pickled tasks, such as improving a collider, in a guest process."""

import pickle


def answer(request: bytes) -> bytes:
    """Runs the pickled task of a request, and returns its reply as bytes. An empty request, which is sent
    only to start the process early, has an empty reply."""
    if not request:
        return b""
    # Safe: requests come only from the parent process, never from a file.
    task = pickle.loads(request)
    reply: bytes = task.reply()
    return reply
