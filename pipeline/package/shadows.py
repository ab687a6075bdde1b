"""Checks that Python finds linkwright's own top-level packages."""

import importlib.util
import sys
from collections.abc import Iterable
from pathlib import Path

PACKAGES = ("conf", "pipeline", "stages")


def shadows(names: Iterable[str] = PACKAGES) -> str:
    """The message about the first of `names` that is not linkwright's package, or ""."""
    for name in names:
        spec = importlib.util.find_spec(name)
        places = [Path(place).resolve() for place in (spec.submodule_search_locations or ())] if spec else []
        if spec and spec.origin and not places:
            places = [Path(spec.origin).resolve()]
        home = _home()
        if home is None or home / name not in places:
            found = str(places[0]) if places else "nothing"
            expected = str(home / name) if home else "nowhere on Python's path: install linkwright again"
            return (
                f"the package `{name}` is not linkwright's\n"
                f"  found: {found}\n  expected: {expected}\n"
                "  → run from another folder, or remove the other package from PYTHONPATH or this environment"
            )
    return ""


def _home() -> Path | None:
    """The folder that holds our packages; None if there is none."""
    # Installed from a wheel they lie beside this one; an editable install puts their folder on the path.
    beside = Path(__file__).resolve().parents[1]
    for place in (beside, *map(Path, sys.path)):
        if (place / "pipeline" / "face" / "__init__.py").is_file():
            return place.resolve()
    return None
