"""CI for hardware (docs/operate/ci.md): the files to copy, run as GitHub would run them."""

import base64
import json
import os
import re
import sys

import pytest
import yaml

from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, environment, run_in
from tests.support.kit import Kit, hinged
from tests.support.places import PROJECT
from tests.support.users import put
from tests.support.workflows import check_pins, check_steps, check_workflow

PAGE = PROJECT / "docs" / "operate" / "ci.md"
FILES = PAGE.with_suffix("")
ROBOT = """\
# @package _global_
defaults: [override /source: onshape, override /mesh: visual]
source: {{url: '{}'}}
"""
GH = """\
#!{python}
import json, pathlib, sys
words = sys.argv[1:]
log = pathlib.Path("{log}")
if words[0] == "api":
    body = pathlib.Path(words[words.index("--input") + 1]).read_text()
    path = words[3].partition("/contents/")[2]
    print(json.dumps({{"content": {{"html_url": f"https://github.com/us/robots/blob/pictures/{{path}}"}}}}))
else:
    body = pathlib.Path(words[words.index("--body-file") + 1]).read_text()
with log.open("a") as file:
    file.write(json.dumps([words, body]) + "\\n")
"""
"""A stand-in for GitHub's command, which notes what it is told."""


class Runner:
    """A machine of GitHub, with the state that is kept from run to run."""

    def __init__(self, here, server):
        self._here, self._log, self._outputs = here, here / "gh.log", here / "outputs.txt"
        put(here, {"robot/my_arm.yaml": ROBOT.format(server.document_url())})
        put(here / "bin", {"gh": GH.format(python=sys.executable, log=self._log)})
        (here / "bin" / "gh").chmod(0o755)
        self._environ = environment(here, **server.environ, LINKWRIGHT_PAGE="whole") | {
            "PATH": os.pathsep.join([str(here / "bin"), str(COMMAND.parent), os.environ["PATH"]]),
            "STATE": str(here / "state"), "GITHUB_OUTPUT": str(self._outputs), "ISSUE": "7",
            "GITHUB_REPOSITORY": "us/robots", "GITHUB_RUN_ID": "42", "GITHUB_SHA": "0" * 40,
            "GITHUB_REF": "refs/heads/main", "PAGE": "https://github.com/us/robots/actions/runs/42",
        }  # fmt: skip

    def build(self, status=0):
        """Runs the first step; gives its outputs."""
        self._outputs.write_text("")
        self._run("build", status)
        return dict(line.split("=") for line in self._outputs.read_text().splitlines())

    def post(self):
        """Runs the last step; gives what it said to GitHub, as (words, body)."""
        self._run("post", 0)
        return [json.loads(line) for line in self._log.read_text().splitlines()]

    @property
    def posted(self):
        return self._log.exists()

    def _run(self, verb, status):
        done = run_in(
            self._here, sys.executable, FILES / "hardware.py", verb, "my_arm", environ=self._environ
        )
        assert done.returncode == status, done.stdout + done.stderr


def document(limits=(-1, 1)):
    kit = Kit()
    hinged(kit)
    kit.root.features[-1].limits = limits
    return kit.document


def edited(before, **mate):
    after = before.edited("Robot")
    for name, value in mate.items():
        setattr(after.root.features[-1], name, value)
    after.changed()
    return after


@pytest.mark.slow
def test_a_robot_is_built_and_a_change_is_posted(tmp_path):
    before = document()
    with OnshapeServer(before) as server:
        runner = Runner(tmp_path, server)
        assert runner.build() == {"changed": "false", "status": "0"}
        server.reset()
        assert runner.build() == {"changed": "false", "status": "0"}
        assert server.count == 1
        assert not runner.posted
        server.edit(edited(before, limits=(-0.5, 1), value=0.9))
        assert runner.build() == {"changed": "true", "status": "0"}
    branch, old, new, sarif, (words, text) = runner.post()
    assert json.loads(branch[1]) == {"ref": "refs/heads/linkwright-pictures", "sha": "0" * 40}
    pictures = [base64.b64decode(json.loads(body)["content"]) for _, body in (old, new)]
    assert all(picture.startswith(b"\x89PNG") for picture in pictures)
    assert pictures[0] != pictures[1]
    assert {"commit_sha", "ref", "sarif"} == json.loads(sarif[1]).keys()
    assert words[:6] == ["issue", "comment", "7", "--repo", "us/robots", "--body-file"]
    for word in ("before", "after"):
        assert f"![{word}](https://github.com/us/robots/blob/pictures/my_arm/42/{word}.png?raw=true)" in text
    assert text.endswith("\n\n[The page of the robot](https://github.com/us/robots/actions/runs/42)\n")
    # It is the comment that the page shows.
    (shown,) = re.findall(r"```markdown\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert re.fullmatch(re.escape(shown).replace(r"\.\.\.", ".+"), text)


@pytest.mark.slow
def test_document_without_a_build_fails_and_keeps_the_last(tmp_path):
    before = document()
    with OnshapeServer(before) as server:
        runner = Runner(tmp_path, server)
        runner.build()
        loose = edited(before)
        loose.root.features.clear()
        loose.changed()
        server.edit(loose)
        assert runner.build(status=1) == {}
        after = loose.edited("Robot")
        after.root.features = list(edited(before, limits=(-0.5, 1)).root.features)
        after.changed()
        server.edit(after)
        assert runner.build() == {"changed": "true", "status": "0"}


def test_the_action_and_its_workflow_are_sound():
    text = (FILES / "action.yml").read_text()
    action = yaml.safe_load(text)
    check_pins(text)
    check_steps(action["runs"]["steps"])
    needed = {name for name, entry in action["inputs"].items() if entry.get("required")}
    workflow = check_workflow(FILES / "hardware.yml")
    (job,) = workflow["jobs"].values()
    used = next(step for step in job["steps"] if step["uses"].startswith("./"))
    assert used["with"].keys() == needed
    assert job["permissions"] == {"contents": "write", "issues": "write", "security-events": "write"}
