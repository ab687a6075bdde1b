"""Adds the tests that `pytest --linkwright` runs: one for each snapshot, and one for left-over snapshots."""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from linkwright.pipeline.errors import LinkwrightError
from linkwright.pipeline.snapshots.command import error_text
from linkwright.pipeline.snapshots.snapshot_folder import SnapshotFolder
from linkwright.pipeline.snapshots.subjects import (
    FOLDER,
    RobotRepository,
    SnapshotSubject,
    robots_and_experiments,
)

RENEWED = "linkwright snapshot"
"""The property of a test report with the text of a renewal."""


@pytest.hookimpl(tryfirst=True)  # before -k and -m choose among the tests
def pytest_collection_modifyitems(
    session: pytest.Session, config: pytest.Config, items: list[pytest.Item]
) -> None:
    """Adds the tests of the snapshots, wherever tests are collected from."""
    items.extend(session.genitems(Snapshots.from_parent(session, name=FOLDER, nodeid=FOLDER)))


def pytest_configure(config: pytest.Config) -> None:
    """Ends the run if there is no robot, before other processes begin."""
    try:
        robots_and_experiments(_repository(config))
    except (LinkwrightError, OSError) as error:
        raise pytest.UsageError(str(error)) from None


def _repository(config: pytest.Config) -> RobotRepository:
    folder = config.rootpath / str(config.getini("linkwright_folder") or "")
    # Absolute, since pytest's settings name folders from its root folder.
    config_dirs = (
        str(config.rootpath / config_dir) for config_dir in config.getini("linkwright_config_dirs")
    )
    return RobotRepository(folder, tuple(config_dirs))


class Snapshots(pytest.Collector):
    """The collector of the tests of snapshots."""

    def collect(self) -> Iterable[pytest.Item]:
        """Returns the tests in the order of the subjects. With --linkwright-update they renew the snapshots
        instead of comparing them."""
        snapshots = SnapshotFolder(_repository(self.config))
        update = self.config.getoption("linkwright_update")
        act = _renew if update else _check
        tests = [
            self._test(subject.title, partial(act, snapshots, subject), subject)
            for subject in snapshots.subjects
        ]
        act_on_left_over = (
            snapshots.remove_left_over_snapshots if update else partial(_check_left_over, snapshots)
        )
        # This test has no subject: it is about the folder.
        return [*tests, self._test("left over", act_on_left_over, SnapshotSubject())]

    def _test(self, name: str, act: Callable[[], list[str]], subject: SnapshotSubject) -> pytest.Item:
        return SnapshotTest.from_parent(self, name=name, act=act, subject=subject)


def _check(snapshots: SnapshotFolder, subject: SnapshotSubject) -> list[str]:
    snapshots.check(subject)
    return []


def _renew(snapshots: SnapshotFolder, subject: SnapshotSubject) -> list[str]:
    return [renewal.text] if (renewal := snapshots.renew(subject)) else []


def _check_left_over(snapshots: SnapshotFolder) -> list[str]:
    snapshots.check_left_over_snapshots()
    return []


class SnapshotTest(pytest.Item):
    """A test of a snapshot: `act` raises LinkwrightError for a wrong snapshot, and returns texts of
    renewals."""

    def __init__(self, *, act: Callable[[], list[str]], subject: SnapshotSubject, **options: Any) -> None:
        super().__init__(**options)
        self._act, self._subject = act, subject

    def runtest(self) -> None:
        self.user_properties += [(RENEWED, text) for text in self._act()]

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        if isinstance(excinfo.value, LinkwrightError):
            return error_text(excinfo.value, self._subject)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        return self.path, None, f"{FOLDER}::{self.name}"


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Prints which snapshots were renewed, by any process of the test run."""
    passed = terminalreporter.getreports("passed")
    texts = [text for report in passed for name, text in report.user_properties if name == RENEWED]
    if texts:
        terminalreporter.section("snapshots of robots", sep="-")
        for text in texts:
            terminalreporter.line(text)
