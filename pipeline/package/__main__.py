"""Runs the command: `linkwright` and `python -m linkwright`."""

import sys

from . import own_path

# Before any other import, which could load a file of the working folder.
own_path.leave_out_working_folder()


def main() -> int:
    """Runs the command line and returns the exit status."""
    try:
        # Here, since Ctrl-C may come before anything is imported.
        from linkwright.pipeline import cli, interrupt
    except KeyboardInterrupt:
        print("error: interrupted", file=sys.stderr)
        return 130
    return interrupt.command(cli.main)


if __name__ == "__main__":
    sys.exit(main())
