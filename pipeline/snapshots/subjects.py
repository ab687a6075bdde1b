"""Finds the robots and experiments of a repository."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from linkwright.pipeline import observed
from linkwright.pipeline.config.compose import Composed, Composer, lacks_a_robot
from linkwright.pipeline.config.hydra.node import quote_text
from linkwright.pipeline.config.messages import EXPERIMENT
from linkwright.pipeline.config.presets import Presets
from linkwright.pipeline.errors import ConfigError

FOLDER = "snapshots"
"""The folder of the snapshots, beside `robot/`."""


@dataclass(frozen=True, slots=True)
class RobotRepository:
    """A repository: the `folder` that contains `robot/`, and in which its robots are built; `config_dirs`:
    folders with more robots, relative to `folder`."""

    folder: Path
    config_dirs: tuple[str, ...] = ()

    @property
    def snapshots(self) -> Path:
        """The folder of the snapshots."""
        return self.folder / FOLDER


@dataclass(frozen=True, slots=True, order=True)
class SnapshotSubject:
    """The subject of a snapshot: a robot, an experiment that chooses its robot, or a robot with an
    experiment."""

    robot: str = ""
    experiment: str = ""

    @property
    def chosen_options(self) -> dict[str, str]:
        """The options that the subject chooses, by group."""
        options = {"robot": self.robot, EXPERIMENT: self.experiment}
        return {group: option for group, option in options.items() if option}

    @property
    def overrides(self) -> list[str]:
        """The overrides that build the subject."""
        return [f"{group}={quote_text(option)}" for group, option in self.chosen_options.items()]

    @property
    def title(self) -> str:
        """The name of the subject in messages."""
        return " ".join(f"{group}={option}" for group, option in self.chosen_options.items())


def compose_subject(composer: Composer, subject: SnapshotSubject) -> Composed:
    """Composes a subject; raises ConfigError with all problems."""
    overrides, problems = composer.read(subject.overrides)
    return composer.compose([override.hydra for override in overrides], problems)


def subjects(composer: Composer, repository: RobotRepository) -> list[SnapshotSubject]:
    """Returns all subjects of a repository, sorted: each robot, each experiment that chooses its robot or its
    source, and each robot with each of the other experiments. Raises ConfigError if there are none."""
    robots, experiments = robots_and_experiments(repository)
    all_subjects = [SnapshotSubject(robot) for robot in robots]
    for experiment in experiments:
        experiment_subject = SnapshotSubject(experiment=experiment)
        if _chooses_no_robot(composer, experiment_subject):
            all_subjects += [SnapshotSubject(robot, experiment) for robot in robots]
        else:
            all_subjects.append(experiment_subject)
    return sorted(all_subjects)


def robots_and_experiments(repository: RobotRepository) -> tuple[list[str], list[str]]:
    """Returns the robots and the experiments of a repository; raises ConfigError if there are none."""
    presets = Presets(repository.config_dirs, repository.folder)
    robots, experiments = _own_options(presets, "robot"), _own_options(presets, EXPERIMENT)
    if not robots and not experiments:
        msg = "there is no robot: no robot/NAME.yaml, and no experiment/NAME.yaml"
        raise ConfigError(msg, "snapshot", "run it where robot/ is, or name that folder")
    return robots, experiments


def _own_options(presets: Presets, group: str) -> list[str]:
    """Returns the user's own options of a group; names that begin with an underscore are parts of other
    options."""
    names: set[str] = set()
    for folder in presets.own:
        names |= {path.removesuffix(".yaml") for path in observed.yaml_files_below(folder / group)}
    return sorted(name for name in names if not _is_part(PurePosixPath(name).parts))


def _is_part(names: Iterable[str]) -> bool:
    return any(name.startswith("_") for name in names)


def _chooses_no_robot(composer: Composer, experiment: SnapshotSubject) -> bool:
    """Tells whether an experiment fits any robot; false if it cannot be composed."""
    overrides, problems = composer.read(experiment.overrides)
    tree = composer.with_params(overrides, problems).tree
    return tree is not None and lacks_a_robot(tree)
