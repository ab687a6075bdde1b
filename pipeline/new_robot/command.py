"""Surveys a source, writes the robot's file, and prints what it found."""

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import yaml

from linkwright.pipeline.api.arguments import plan_of
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError, OutputError, reason, refusal
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.json_documents.findings import worst
from linkwright.pipeline.json_documents.new import NewDocument, NewJointDocument
from linkwright.pipeline.new_robot import robot_file
from linkwright.pipeline.new_robot.choices import choose
from linkwright.pipeline.new_robot.joint_table import joint_table
from linkwright.pipeline.new_robot.peer_config import PeerConfig, read
from linkwright.pipeline.new_robot.peer_options import PEER_KEYS, converted
from linkwright.pipeline.new_robot.robot_file import NewRobot
from linkwright.pipeline.new_robot.source_keys import robot_name, source_keys
from linkwright.pipeline.new_robot.survey import (
    FetchedMechanism,
    MechanismSurvey,
    fetch_mechanism,
    survey_mechanism,
)
from linkwright.pipeline.run.preflight import plan_problems
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal import pasted
from linkwright.pipeline.terminal.display import progress_for
from linkwright.pipeline.terminal.output import say
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.show.graph_view.labels import kilograms


@dataclass(frozen=True, slots=True)
class NewRequest:
    """The arguments of the verb."""

    source: str
    """The address of an assembly, or the path of a file; "" for that of `peer`."""
    name: str = ""
    peer: str = ""
    """The path of a configuration of onshape-to-robot."""
    deep: bool = False
    trust: bool = False
    """Whether a xacro file may run."""
    cache: str | None = None
    config_dir: str = ""
    json: bool = False


def run(request: NewRequest, environ: Mapping[str, str] = os.environ) -> int | CommandDocument:
    """Writes the robot's file, prints the result, and returns the exit status, or returns a document.

    Raises ConfigError if that is known before the source is read, OutputError if the file exists or cannot be
    written, and the errors of a fetch.
    """
    if request.config_dir and not Path(request.config_dir).is_dir():
        raise ConfigError(f"there is no folder {request.config_dir}", "--config-dir", "make it first")
    peer = read(request.peer) if request.peer else None
    source = peer.source(request.source) if peer else source_keys(request.source)
    name = request.name or (peer.name if peer else "")
    draft = robot_name(name, source)
    if name:
        _require_free(request, draft)
    plan = _plan(request, {"name": draft, "source": source, "until": "graph"})
    problems = plan_problems(plan, environ)
    if problems:
        raise refusal(problems)
    progress = progress_for(sys.stderr)
    try:
        mechanism = fetch_mechanism(
            plan, environ, lambda line: progress.detail("fetch", line), with_masses=request.deep
        )
    finally:
        progress.close()
    name = robot_name(name, source, mechanism.title)
    path = _require_free(request, name)
    robot = complete_robot(request, NewRobot(name, source), mechanism, peer)
    text = robot_file.text(robot)
    Secrets(environ).check({str(path): text.encode()})
    _write(path, text)
    if request.json:
        return as_document(robot, path, mechanism)
    say(as_text(robot, path, mechanism))
    return 0


def complete_robot(
    request: NewRequest, draft: NewRobot, mechanism: FetchedMechanism, peer: PeerConfig | None
) -> NewRobot:
    """Returns the draft with all that its file says. Its problems are those of the finished file: the text is
    composed, and the graph stage runs with it."""
    tree = {"name": draft.name, "source": draft.source, **(PEER_KEYS if peer else {})}
    survey = survey_mechanism(mechanism, _plan(request, tree))
    robot = replace(
        draft, problems=survey.problems, studios=0 if mechanism.has_masses else mechanism.studio_count
    )
    if survey.robot:
        robot = _with_findings(robot, survey, mechanism, peer)
    elif peer:
        remark = (
            f"{peer.place}: its options are converted once these problems are solved: write the file again"
        )
        robot = replace(robot, converted=PEER_KEYS, remarks=[remark])
    final_survey = survey_mechanism(
        mechanism, _plan(request, {"name": robot.name, **yaml.safe_load(robot_file.text(robot))})
    )
    return replace(robot, problems=final_survey.problems)


def _with_findings(
    draft: NewRobot, survey: MechanismSurvey, mechanism: FetchedMechanism, peer: PeerConfig | None
) -> NewRobot:
    """Returns a robot with its joints, the choices for it, and the keys of another tool's configuration."""
    assert survey.robot is not None
    has_masses = mechanism.has_masses and not survey.problems
    kind = mechanism.bundle.kind
    rows = joint_table(survey.robot, kind)
    choices = choose(survey.robot, rows, kind, has_masses=has_masses, for_peer=peer is not None)
    robot = replace(draft, rows=rows, choices=choices, summary=_summary(survey.robot, has_masses))
    if peer is None:
        return robot
    conversion = converted(peer, survey.robot, rows)
    return replace(
        robot,
        converted=conversion.keys,
        remarks=conversion.remarks,
        export=conversion.export,
        collider=conversion.collider,
    )


def _summary(robot: Robot, has_masses: bool) -> str:
    counts = {"link": len(robot.links), "joint": len(robot.joints), "loop": len(robot.loops)}
    nouns = [count(number, noun) for noun, number in counts.items() if number or noun != "loop"]
    mass = [kilograms(sum(link.inertial.mass for link in robot.links))] if has_masses else []
    return ", ".join([*nouns, *mass])


def as_document(robot: NewRobot, path: Path, mechanism: FetchedMechanism) -> NewDocument:
    """Returns the document of the result."""
    names = [field.name for field in fields(NewJointDocument)]
    joints = (NewJointDocument(**{name: getattr(row, name) for name in names}) for row in robot.rows)
    return NewDocument(
        exit_status=0,
        path=str(path),
        name=robot.name,
        source=robot.source,
        joints=tuple(joints),
        problems=worst(robot.problems, whole=True),
        remarks=tuple(robot.remarks),
        weighed=mechanism.has_masses,
        calls={"made": mechanism.call_count, "saved": mechanism.saved_call_count},
    )


def as_text(robot: NewRobot, path: Path, mechanism: FetchedMechanism) -> str:
    """Returns the result for people."""
    lines = [f"{path}: {count(len(robot.rows), 'joint')}, {count(mechanism.call_count, 'API call')}"]
    for problem in robot.problems:
        place = f" {problem.where}:" if problem.where else ""
        lines += [
            f"{problem.code or 'error'}{place} {problem.message}",
            *([f"    → {problem.hint}"] if problem.hint else []),
        ]
    if robot.remarks:
        lines.append(f"{count(len(robot.remarks), 'remark')} about the other tool's options: see the file")
    if robot.problems:
        lines.append(
            f"solve {count(len(robot.problems), 'problem')}, which the file explains; then build it:"
        )
    folder = path.parent.parent
    options = [] if folder == Path() else ["--config-dir", str(folder)]
    lines.append(f"  → {pasted.line(['linkwright', *options, f'robot={robot.name}'])}")
    return "\n".join(lines)


def _plan(request: NewRequest, tree: Mapping[str, Any]) -> Plan:
    cache = {"cache": {"dir": request.cache}} if request.cache else {}
    return plan_of([{**tree, **cache}], request.trust, (), None, ())


def _require_free(request: NewRequest, name: str) -> Path:
    """Returns the path of the robot's file; raises ConfigError if there is a robot of this name."""
    folders = [Path(), *([Path(request.config_dir)] if request.config_dir else [])]
    for folder in folders:
        path = folder / "robot" / f"{name}.yaml"
        if os.path.lexists(path):
            msg = "there is a robot of this name already, and no file is replaced"
            hint = f"{pasted.line(['linkwright', 'new', request.source, f'{name}_2'])}, or remove {path}"
            raise ConfigError(msg, str(path), hint)
    return path


def _write(path: Path, text: str) -> None:
    """Writes a file that does not exist yet."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise OutputError(f"it cannot be written: {reason(error)}", str(path)) from None
