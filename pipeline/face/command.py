"""The command: `linkwright` and `python -m linkwright`.

The wheel ships this module as `linkwright/__main__.py`.
"""

import sys

from .shadows import shadows


def main() -> int:
    """Runs the command line and returns the exit status."""
    # The command itself looks at the other packages; it cannot look at the one that it is in.
    message = shadows(["pipeline"])
    if message:
        print(f"error: {message}", file=sys.stderr)
        return 2
    from pipeline import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
