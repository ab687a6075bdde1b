"""Makes the snapshot of a subject: composes it, and builds its graph if no network is needed."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import chdir, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.config.compose import Composed, Composer, session
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.snapshots.figures import figures_of
from linkwright.pipeline.snapshots.offline import offline
from linkwright.pipeline.snapshots.subjects import (
    FOLDER,
    RobotRepository,
    SnapshotSubject,
    compose_subject,
    subjects,
)
from linkwright.pipeline.snapshots.text import snapshot_text

Environ = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A new snapshot of a subject, with the name of its robot and its text."""

    subject: SnapshotSubject
    name: str
    text: str

    @property
    def file(self) -> str:
        """The name of its file."""
        return file_of(self.name)


def file_of(name: str) -> str:
    """Returns the name of the file with the snapshot of a robot."""
    return f"{name}.txt"


@contextmanager
def inside(repository: RobotRepository, environ: Environ) -> Iterator[Composer]:
    """Yields a composer, and makes the repository's folder the working folder, from which relative paths of
    its robots start; the network cannot be used."""
    with (
        chdir(repository.folder),
        offline(),
        session(repository.config_dirs, environ=environ) as composer,
    ):
        yield composer


def all_subjects(repository: RobotRepository, environ: Environ) -> list[SnapshotSubject]:
    """Returns all subjects of a repository; raises ConfigError if there are none."""
    with inside(repository, environ) as composer:
        return subjects(composer, repository)


def names_of(
    repository: RobotRepository, chosen: Iterable[SnapshotSubject], environ: Environ
) -> dict[SnapshotSubject, str]:
    """Returns the name of each subject's robot, without subjects that cannot be composed."""
    names = {}
    with inside(repository, environ) as composer:
        for subject in chosen:
            with suppress(ConfigError):
                names[subject] = compose_subject(composer, subject).plan.name
    return names


def snapshot(repository: RobotRepository, subject: SnapshotSubject, environ: Environ) -> Snapshot:
    """Makes the snapshot of a subject; raises ConfigError if the subject cannot be composed, and
    LinkwrightError if it cannot be built."""
    with inside(repository, environ) as composer:
        subject_plan = compose_subject(composer, subject)
        bundle = _bundle(composer, subject, subject_plan)
    with chdir(repository.folder), offline():
        figures = figures_of(subject_plan.plan, bundle, environ)
    content = Secrets(environ, repository.folder).blanked(snapshot_text(subject, subject_plan, figures))
    return Snapshot(subject, subject_plan.plan.name, content)


def _bundle(composer: Composer, subject: SnapshotSubject, subject_plan: Composed) -> Path | None:
    """Returns the bundle beside a subject's snapshot: its own, or that of its robot if both have the same
    source."""
    bundle = Path(FOLDER) / f"{subject_plan.plan.name}.zip"
    if bundle.is_file():
        return bundle
    if not subject.experiment or subject_plan.robot == "bare":
        return None
    robot = compose_subject(composer, SnapshotSubject(subject_plan.robot)).plan
    shared = Path(FOLDER) / f"{robot.name}.zip"
    return shared if robot.source == subject_plan.plan.source and shared.is_file() else None
