"""Adds `--linkwright` to pytest: it compares the snapshots of a repository's robots.

Every run of pytest imports this module, so it imports nothing; the modules of the tests are loaded only if
the option is given.
"""

TYPE_CHECKING = False
"""Type checkers take this for true; `typing` is not imported."""

if TYPE_CHECKING:
    import pytest


def pytest_addoption(parser: "pytest.Parser") -> None:
    group = parser.getgroup("linkwright", "snapshots of robots")
    group.addoption(
        "--linkwright",
        action="store_true",
        help="compare the snapshots of the robots in robot/, without the network",
    )
    group.addoption(
        "--linkwright-update", action="store_true", help="renew the snapshots in place of comparing them"
    )
    parser.addini(
        "linkwright_folder", "the folder that holds robot/ and snapshots/; default: the root folder"
    )
    parser.addini(
        "linkwright_config_dirs", "folders with more robots, as --config-dir of linkwright", "linelist", []
    )


def pytest_configure(config: "pytest.Config") -> None:
    if config.getoption("linkwright") or config.getoption("linkwright_update"):
        config.pluginmanager.import_plugin("linkwright.pipeline.snapshots.pytest_items")
