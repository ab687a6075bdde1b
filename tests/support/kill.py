"""A process that is killed at a chosen step."""

import os
import signal
import sys


def killed_at(step, work):
    """Runs `work` in a child that dies by kill -9 at its step-th touch of the file system.

    False where it came to its end before that step. Linux and macOS only (fork).
    """
    child = os.fork()
    if child == 0:
        seen = 0

        def hook(event, _arguments):
            nonlocal seen
            if event == "open" or event.startswith(("os.", "shutil.", "tempfile.")):
                seen += 1
                if seen == step:
                    os.kill(os.getpid(), signal.SIGKILL)

        try:
            sys.addaudithook(hook)
            work()
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])
