"""The entry point of a guest process (see `guest`). It imports none of our modules until it knows their
folder."""

import importlib
import json
import os
import signal
import sys


def main() -> None:
    # The reply has a stream of its own: whatever else is printed is a complaint.
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    head = json.loads(sys.stdin.buffer.readline())
    _end_with(head["parent"], head["seconds"])
    # What the loader and Python have read by now is none of the guest's.
    for name in set(os.environ) - set(head["environ"]):
        del os.environ[name]
    sys.path[:] = head["path"]
    errors = importlib.import_module("stages.robot.errors")
    guest = importlib.import_module(head["module"])
    request = sys.stdin.buffer.read()
    try:
        kind, body = b"R", guest.answer(request)
    except errors.LinkwrightError as error:
        fields = {"message": error.message, "where": error.where, "hint": error.hint}
        fields["kind"] = "ConfigError" if isinstance(error, errors.ConfigError) else "SourceError"
        kind, body = b"E", json.dumps(fields).encode()
    replies.write(kind + len(body).to_bytes(8, "big"))
    replies.write(body)
    replies.close()
    # Nothing is left to do: what a library would tidy up, the system does.
    os._exit(0)


def _end_with(parent: int, seconds: float) -> None:
    """The kernel ends this process after `seconds`, and with the `parent` process (Linux), whatever code
    runs in it by then; a crash leaves no file."""
    if hasattr(signal, "setitimer"):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, seconds)
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(1, int(signal.SIGKILL))  # PR_SET_PDEATHSIG
        if os.getppid() != parent:
            os._exit(1)


if __name__ == "__main__":
    main()
