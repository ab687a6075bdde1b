"""A pull request's day: an assembly is edited, the robot built again, and the script of the README says what
is different, and that it is right."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, environment, linkwright
from tests.support.places import PROJECT

pytestmark = pytest.mark.slow

GIT = ("git", "-c", "user.name=a", "-c", "user.email=a@b.c")
LONGER = 0.004
"""m: how much further out the hand is on the wrist."""


def script() -> str:
    text = (PROJECT / "README.md").read_text(encoding="utf-8")
    (found,) = re.findall(r"^<!-- pull_request -->\n```sh\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return found


def edited(document: Document) -> Document:
    """With a mass, a limit and a mate changed."""
    after = document.edited("Arm", "Desk arm")
    after.part("Forearm").density *= 1.5
    mates = {one.name: one for one in after.root.features}
    mates["Wrist pitch"].limits = (-1.2, 1.6)
    palm, (wrist, flange) = mates["Wrist roll"].entities
    further = frame((0.046 + LONGER, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    assert abs(further - flange).max() == pytest.approx(LONGER)
    mates["Wrist roll"].entities = (palm, (wrist, further))
    after.changed()
    return after


def sh(here: Path, environ: dict[str, str], text: str) -> subprocess.CompletedProcess[str]:
    path = f"{COMMAND.parent}{os.pathsep}{environ['PATH']}"
    return subprocess.run(
        ["sh", "-c", text],
        cwd=here,
        env={**environ, "PATH": path, "BASE": "HEAD"},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


def test_a_pull_requests_day(tmp_path: Path) -> None:
    document = sample_document()
    with OnshapeServer(document) as server:
        environ = environment(tmp_path, **server.environ)
        (tmp_path / "robot").mkdir()
        (tmp_path / "robot" / "my_arm.yaml").write_text(
            "# @package _global_\n"
            "defaults:\n  - override /source: onshape\n  - override /mesh: visual\n"
            f"source:\n  url: '{server.document_url()}'\n"
        )
        (tmp_path / ".gitignore").write_text("cache\nhome\n*.lock\n")
        first = linkwright(tmp_path, "robot=my_arm", "output=robots/my_arm", environ=environ)
        assert first.returncode == 0, first.stdout + first.stderr
        for arguments in (["init", "-q"], ["add", "robots", "robot"], ["commit", "-q", "-m", "one"]):
            subprocess.run([*GIT, *arguments], cwd=tmp_path, check=True)
        same = sh(tmp_path, environ, script())
        assert same.returncode == 0, same.stdout + same.stderr
        assert "The same robot." in (tmp_path / "diff.md").read_text()
        server.edit(edited(document))
        done = sh(tmp_path, environ, script())
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"^(\d+) of \1 checks passed$", done.stdout, re.MULTILINE)
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", (tmp_path / "diff.md").read_text(), re.MULTILINE)
    told = [(name, text) for name, text in rows if text.strip()]
    assert {name for name, _ in told} == {
        "my\\_arm",
        "forearm",
        "Forearm &lt;1&gt;",
        "wrist\\_pitch",
        "wrist\\_roll",
    }
    text = "\n".join(f"{name}: {what}" for name, what in told)
    assert "(+50 %)" in text
    assert "wrist\\_pitch: lower limit -1.6 → -1.2 rad" in text
    assert "wrist\\_roll: origin moved by 4 mm" in text
    assert "turned" not in text

    folder = tmp_path / "robots" / "my_arm"
    assert linkwright(tmp_path, "diff", "robots/my_arm", "robots/my_arm", environ=environ).returncode == 0
    assert (
        linkwright(tmp_path, "diff", "HEAD:robots/my_arm", "robots/my_arm", environ=environ).returncode == 3
    )
    urdf = (folder / "my_arm.urdf").read_text()
    (folder / "my_arm.urdf").write_text(urdf.replace('lower="-1.2"', 'lower="-1.6"'))
    wrong = sh(tmp_path, environ, script().replace("linkwright robot=my_arm", ": linkwright robot=my_arm"))
    assert wrong.returncode == 3
    assert "wrist_pitch" in wrong.stdout
