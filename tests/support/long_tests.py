"""`python -m pytest -n auto -p tests.support.long_tests`: writes `long_tests.txt` from how long tests took.

The file names the test functions whose items take as long as a build. `tests/conftest.py` marks them `e2e`,
so that the others are a loop of a minute or two. Functions that did not run stay as they are in the file.
"""

import ast
from collections import defaultdict
from pathlib import Path

from tests.support.places import PROJECT

LIST = Path(__file__).with_name("long_tests.txt")

LIMIT = 0.08
"""Mean duration [s] of the items of a function, set-up included, above which it is long."""

_durations: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
"""Function -> item -> duration [s]."""


def function_of(nodeid):
    """The item's id without its parameters."""
    return nodeid.partition("[")[0]


def long_tests():
    """The functions that the file names."""
    return frozenset(LIST.read_text(encoding="utf-8").split())


def all_tests():
    """The ids of all test functions, by the texts of their modules."""
    return {
        "::".join((module.relative_to(PROJECT).as_posix(), *names))
        for module in (PROJECT / "tests").rglob("test_*.py")
        for names in _names(ast.parse(module.read_text(encoding="utf-8")))
    }


def _names(tree):
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            yield from ((node.name, *names) for names in _names(node))
        elif isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            yield (node.name,)


def pytest_runtest_logreport(report):
    _durations[function_of(report.nodeid)][report.nodeid] += report.duration


def pytest_sessionfinish(session):
    if hasattr(session.config, "workerinput"):
        return
    means = {function: sum(items.values()) / len(items) for function, items in _durations.items()}
    kept = (long_tests() - means.keys()) & all_tests()
    named = kept | {function for function, mean in means.items() if mean > LIMIT and "/e2e/" not in function}
    LIST.write_text("".join(f"{function}\n" for function in sorted(named)), encoding="utf-8")
