"""`linkwright skill`: its commands run, its YAML makes robots, and its codes exist."""

import json
import re
import shlex
from functools import cache
from pathlib import Path

import pytest
import yaml

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.reference import SKILL
from linkwright.pipeline.reference.codes import explanations
from linkwright.pipeline.reference.exit_status import MEANINGS
from linkwright.stages.graph import build_robot
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.building import bundle_of
from tests.support.command import COMMAND, environment, run_in
from tests.support.users import GLOBAL, write

TEXT = SKILL.read_text(encoding="utf-8")
URL = "https://cad.onshape.com/documents/.../w/.../e/..."
FROM_SAMPLE = f"{GLOBAL}defaults: [override /source: sample, override /actuators: position]\n"


def code(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)


ROBOT, *SNIPPETS = code("yaml")


@cache
def sample_bundle():
    return bundle_of(sample_document())


def test_it_is_a_skill_as_agents_read_them(capsys):
    head = yaml.safe_load(re.fullmatch(r"---\n(.*?)\n---\n.*", TEXT, re.DOTALL)[1])
    assert head.keys() == {"name", "description"}
    assert head["name"] == SKILL.parent.name
    assert re.fullmatch(r"[a-z0-9-]{1,64}", head["name"])
    assert len(head["description"]) <= 1024
    assert len(TEXT.encode()) <= 10_000
    assert run(["skill"]) == 0
    assert capsys.readouterr().out == TEXT
    assert run(["skill", "--path"]) == 0
    assert Path(capsys.readouterr().out.strip()).read_text(encoding="utf-8") == TEXT


def test_twenty_findings_have_codes_and_statuses_that_exist():
    section = TEXT.partition("## The likeliest findings")[2].partition("\n## ")[0]
    findings = [line for line in section.splitlines() if line.startswith("**")]
    assert len(findings) == 20
    assert all(re.match(r"\*\*[EWC]-[A-Z-]+\*\*", line) for line in findings)
    codes = set(re.findall(r"\b[EWIC]-[A-Z][A-Z0-9-]+\b", TEXT))
    assert codes - explanations().keys() == set()
    table = dict(re.findall(r"^\| (\d) \| (.+) \|$", TEXT, re.MULTILINE))
    assert table.keys() == {str(status) for status in MEANINGS["build"]}


@pytest.mark.parametrize("text", SNIPPETS, ids=lambda text: text.partition(":")[0])
def test_each_snippet_makes_a_robot(text, tmp_path):
    """A robot of the sample, whose names it has; that of a URDF is only composed."""
    tree = yaml.safe_load(text)
    if "source" in tree:
        (tmp_path / "arm.urdf").write_text("<robot name='arm'><link name='a'/></robot>")
        plan = compose_plan(["robot=my_arm"], (), write(tmp_path, my_arm=GLOBAL + text)).plan
        assert plan.source.packages == tree["source"]["packages"]
        return
    plan = compose_plan(["robot=my_arm"], (), write(tmp_path, my_arm=FROM_SAMPLE + text)).plan
    robot = build_robot(sample_bundle(), plan)
    for glob, values in tree.get("joints", {}).items():
        dofs = [dof for joint in robot.joints for dof in joint.dofs if glob in ("*", dof.name)]
        assert dofs
        limits = values.get("limits")
        assert limits is None or [dofs[0].limits.lower, dofs[0].limits.upper] == limits


def test_the_file_is_a_robot(tmp_path):
    url = URL.replace("...", "0123456789abcdef01234567")
    plan = compose_plan(["robot=my_arm"], (), write(tmp_path, my_arm=ROBOT.replace(URL, url))).plan
    assert (plan.name, plan.source.kind) == ("my_arm", "onshape")


@pytest.mark.slow
@pytest.mark.e2e
def test_the_commands_run_and_print_documents(tmp_path):
    (commands,) = code("sh")
    lines = commands.splitlines()
    assert len(lines) == 10
    with OnshapeServer(sample_document()) as server:
        environ = environment(tmp_path, **server.environ)
        for line in lines:
            name, *arguments = shlex.split(line.replace(URL, server.document_url()))
            assert name == COMMAND.name
            done = run_in(tmp_path, COMMAND, *arguments, environ=environ)
            document = json.loads(done.stdout)
            assert document["format"] != "linkwright-error", f"{line}\n{done.stderr}"
            assert document["exit_status"] == done.returncode, line
            assert done.returncode == 0 or "doctor" in line, f"{line}\n{done.stdout}"
        packed = ["--json", "source=bundle", "source.path=my_arm.zip", "until=graph"]
        assert json.loads(run_in(tmp_path, COMMAND, *packed, environ=environ).stdout)["calls"]["made"] == 0
