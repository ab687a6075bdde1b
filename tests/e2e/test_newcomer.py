"""A newcomer's first hour: an empty folder, the wheel, and the commands of the README and of `docs/start` in
their order, against the local Onshape, each with the output that the page shows.

Nothing of the checkout is on the path: what runs is what pip installed. Blocks are run as those of all
documents are (`tests/docs`).
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs import blocks
from tests.docs.session import Session, run
from tests.support.places import PROJECT, copy_source

pytestmark = pytest.mark.slow

START = sorted(path.relative_to(PROJECT).as_posix() for path in (PROJECT / "docs" / "start").glob("*.md"))

STANDS = """
import mujoco, numpy as np
model = mujoco.MjModel.from_xml_path("outputs/my_arm/scene.xml")
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
home = data.qpos.copy()
mujoco.mj_step(model, data, nstep=1000)
print("stands", np.abs(data.qpos - home).max() < 0.1, sum(data.warning.number) == 0)
data.ctrl[model.actuator("lift").id] += 0.02
before = data.joint("lift").qpos[0]
mujoco.mj_step(model, data, nstep=1000)
print("moves", abs(data.joint("lift").qpos[0] - before - 0.02) < 0.005)
"""


def made(*words, **options):
    """Runs a command that must succeed."""
    done = subprocess.run(words, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of the checkout, built from a copy, so that the checkout stays as it is."""
    folder = tmp_path_factory.mktemp("wheel")
    copy_source(folder / "source")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    done = subprocess.run([*pip, "./source"], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"pip cannot build the wheel here: {done.stderr[-300:]}")
    (file,) = folder.glob("*.whl")
    return file


class Newcomer(Session):
    """A session whose only Linkwright is what the README's first command installed."""

    def __init__(self, root, cache, wheel):
        super().__init__(root, cache)
        self.wheel = wheel

    def __enter__(self):
        super().__enter__()
        (self.root / "bin").mkdir()
        (self.root / "bin" / "python3").symlink_to(Path(sys.base_prefix) / "bin" / "python3")
        checkout = str(Path(sys.executable).parent)
        rest = [place for place in self.environ["PATH"].split(os.pathsep) if place != checkout]
        self.environ["PATH"] = os.pathsep.join([str(self.root / "bin"), *rest])
        self.environ |= {name: text for name, text in os.environ.items() if name.startswith("PIP_")}
        self.environ["HOME"] = os.environ["HOME"]  # with the settings and the cache of pip
        return self

    def install(self):
        """Runs the README's first command with the wheel in place of the checkout, and activates its
        environment, as the README says."""
        (block,) = [block for block in blocks.blocks("README.md") if "build" in block.marks]
        assert "pip install -q . " in block.text
        block.text = block.text.replace("install -q . ", f"install -q {self.wheel} ")
        output = self.shell(block)
        block.text = ". .venv/bin/activate"
        self.shell(block)
        return output

    def python(self, block):
        return self.shown(self.printed(self.filled(block.text)))

    def called(self, folder, block, *arguments):
        made("linkwright", *arguments, cwd=folder, env={**self.environ, "LINKWRIGHT_PAGE": "plain"})

    def printed(self, code):
        """What code prints in the newcomer's environment."""
        return made("python", "-c", code, cwd=self.here, env=self.environ)


def test_newcomer_gets_from_nothing_to_a_robot_that_moves(tmp_path, shared_cache, wheel):
    with Newcomer(tmp_path, shared_cache, wheel) as newcomer:
        output = newcomer.install()
        assert re.search(r"^(\d+) of \1 checks passed\nsample: outputs/sample ", output, re.MULTILINE)
        place = Path(newcomer.printed("import linkwright; print(linkwright.__file__)"))
        assert place.is_relative_to(newcomer.here / ".venv")
        run(newcomer, blocks.blocks("README.md"))
        assert newcomer.printed(STANDS) == "stands True True\nmoves True\n"
        for page in START:
            newcomer.begin_folder()
            run(newcomer, blocks.blocks(page))
