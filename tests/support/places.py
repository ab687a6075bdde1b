"""Where things lie: the project, and the data beside it that a fresh clone does not have."""

from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
SHARED = PROJECT.parent / "shared"
"""Recorded replies and robots of others: where it is not there, the tests that read it are skipped."""
