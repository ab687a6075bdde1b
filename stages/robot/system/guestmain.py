"""Runs in a guest process (see `guest`) and answers its requests. It imports our modules only after it has
read their folder."""

import importlib
import json
import os
import signal
import sys
import types


def main() -> None:
    """Answers requests until the input ends, and ends the process."""
    # Replies and requests have streams of their own: all other output goes to the error output, and there is
    # no other input.
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    requests = os.fdopen(os.dup(0), "rb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    head = json.loads(requests.readline())
    _end_with(head["parent"])
    _end_after(head["seconds"])
    # Environment variables needed only at start-up are removed before guest code runs.
    for name in set(os.environ) - set(head["environ"]):
        del os.environ[name]
    sys.path[:] = head["path"]
    # Our modules are imported without the package's `__init__`, wherever they are installed.
    package = sys.modules["linkwright"] = types.ModuleType("linkwright")
    package.__path__ = [head["package"]]
    errors = importlib.import_module("linkwright.stages.robot.errors")
    guest = importlib.import_module(head["module"])
    while length := requests.read(8):
        request = requests.read(int.from_bytes(length, "big"))
        _end_after(head["seconds"])
        try:
            kind, body = b"R", guest.answer(request)
        except errors.LinkwrightError as error:
            fields = {"message": error.message, "where": error.where, "hint": error.hint}
            fields["kind"] = "ConfigError" if isinstance(error, errors.ConfigError) else "SourceError"
            kind, body = b"E", json.dumps(fields).encode()
        _end_after(0)
        replies.write(kind + len(body).to_bytes(8, "big"))
        replies.write(body)
        replies.flush()
    # At once, without the clean-up of libraries: the system frees everything.
    os._exit(0)


def _end_after(seconds: float) -> None:
    """Makes the kernel end this process after this time [s], or never for 0; does nothing on Windows."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, seconds)


def _end_with(parent: int) -> None:
    """Makes the kernel (Linux) end this process when the process `parent` ends, whatever code runs here, and
    keeps crashes (not on Windows) from writing core files."""
    if hasattr(signal, "setitimer"):
        # Late: POSIX only.
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        # Late: Linux only.
        import ctypes

        ctypes.CDLL(None).prctl(1, int(signal.SIGKILL))  # PR_SET_PDEATHSIG
        # The parent may have ended before this call.
        if os.getppid() != parent:
            os._exit(1)


if __name__ == "__main__":
    main()
