"""A pull request's day: an assembly is edited, the robot built again, and the script of
docs/operate/changes.md says what is different, and that it is right."""

import os
import re
import subprocess

import pytest

from tests.fake_onshape.frames import frame
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, environment, linkwright, run_in
from tests.support.pages import code
from tests.support.users import write

pytestmark = pytest.mark.slow

GIT = ("git", "-c", "user.name=a", "-c", "user.email=a@b.c")
SCRIPT = next(text for text in code("docs/operate/changes.md", "sh") if "diff --markdown" in text)
LONGER = 0.004
"""m: how much further out the hand is on the wrist."""


def edited(document):
    """With a mass, a limit and a mate changed."""
    after = document.edited("Arm", "Desk arm")
    after.part("Forearm").density *= 1.5
    mates = {feature.name: feature for feature in after.root.features}
    mates["Wrist pitch"].limits = (-1.2, 1.6)
    palm, (wrist, flange) = mates["Wrist roll"].entities
    further = frame((0.046 + LONGER, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    assert abs(further - flange).max() == pytest.approx(LONGER)
    mates["Wrist roll"].entities = (palm, (wrist, further))
    after.changed()
    return after


def sh(here, environ, text):
    path = f"{COMMAND.parent}{os.pathsep}{environ['PATH']}"
    return run_in(here, "sh", "-c", text, environ={**environ, "PATH": path, "BASE": "HEAD"})


def test_a_pull_requests_day(tmp_path):
    document = sample_document()
    with OnshapeServer(document) as server:
        environ = environment(tmp_path, **server.environ)
        robot = "# @package _global_\ndefaults: [override /source: onshape, override /mesh: visual]\n"
        write(tmp_path, my_arm=f"{robot}source: {{url: '{server.document_url()}'}}\n")
        (tmp_path / ".gitignore").write_text("cache\nhome\n*.lock\n")
        linkwright(tmp_path, "robot=my_arm", "output=robots/my_arm", environ=environ, status=0)
        for arguments in (["init", "-q"], ["add", "robots", "robot"], ["commit", "-q", "-m", "one"]):
            subprocess.run([*GIT, *arguments], cwd=tmp_path, check=True)
        same = sh(tmp_path, environ, SCRIPT)
        assert same.returncode == 0, same.stdout + same.stderr
        assert "The same robot." in (tmp_path / "diff.md").read_text()
        server.edit(edited(document))
        done = sh(tmp_path, environ, SCRIPT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"^(\d+) of \1 checks passed$", done.stdout, re.MULTILINE)
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", (tmp_path / "diff.md").read_text(), re.MULTILINE)
    filled = [(name, text) for name, text in rows if text.strip()]
    names = {"my\\_arm", "forearm", "Forearm &lt;1&gt;", "wrist\\_pitch", "wrist\\_roll"}
    assert {name for name, _ in filled} == names
    text = "\n".join(f"{name}: {cell}" for name, cell in filled)
    limit, moved = "wrist\\_pitch: lower limit -1.6 → -1.2 rad", "wrist\\_roll: origin moved by 4 mm"
    assert [words for words in ("(+50 %)", limit, moved) if words not in text] == []
    assert "turned" not in text

    folder = tmp_path / "robots" / "my_arm"
    linkwright(tmp_path, "diff", "robots/my_arm", "robots/my_arm", environ=environ, status=0)
    linkwright(tmp_path, "diff", "HEAD:robots/my_arm", "robots/my_arm", environ=environ, status=3)
    urdf = (folder / "my_arm.urdf").read_text()
    (folder / "my_arm.urdf").write_text(urdf.replace('lower="-1.2"', 'lower="-1.6"'))
    wrong = sh(tmp_path, environ, SCRIPT.replace("linkwright robot=my_arm", ": linkwright robot=my_arm"))
    assert wrong.returncode == 3
    assert "wrist_pitch" in wrong.stdout
