"""The command: `linkwright` and `python -m linkwright`."""

import sys

from . import own_path

own_path.leave_out_working_folder()

from .shadows import shadows  # noqa: E402 (the working folder must be off the path)


def main() -> int:
    """Runs the command line and returns the exit status."""
    message = shadows()
    if message:
        print(f"error: {message}", file=sys.stderr)
        return 2
    from pipeline import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
