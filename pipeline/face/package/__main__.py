"""The command: `linkwright` and `python -m linkwright`."""

import sys

from .shadows import shadows


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
