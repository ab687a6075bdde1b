"""Imports run one way: pipeline → a stage → show → mujoco → formats → robot; heavy libraries have homes."""

import json
import re
import subprocess
import sys
from importlib.util import find_spec

import pytest

from tests.support.imports import imported, modules, name_of
from tests.support.places import PROJECT, ROOMS

HOMES = {
    "httpx": ("stages/fetch/onshape/api/",),
    "stamina": ("stages/fetch/onshape/api/",),
    "dotenv": ("stages/fetch/onshape/api/",),
    "mujoco": (
        "stages/validate/", "stages/fetch/mjcf/", "stages/mujoco/", "stages/mesh/contacts/", "stages/show/",
        "stages/export/amend/compiled.py",
    ),
    "numpy": ("stages/",),
    "trimesh": ("stages/mesh/", "stages/fetch/urdf/"),
    "coal": ("stages/robot/contact/clearance.py",),
    "fcl": ("stages/robot/contact/clearance.py",),
    "coacd": ("stages/mesh/decompose/coacd_pieces.py",),
    "xacro": ("stages/fetch/urdf/",),
    "collada": (),
    "pxr": ("stages/export/usd/layer.py", "stages/validate/usd/"),
    "networkx": ("stages/graph/", "stages/robot/motion/loop_groups.py"),
    "jinja2": ("stages/formats/templates.py",),
    "markupsafe": ("stages/formats/templates.py", "pipeline/page/"),
    "lxml": ("stages/formats/xml.py",),
    "hydra": ("pipeline/config/", "pipeline/sweep/launch.py", "pipeline/sweep/launchers/"),
    "omegaconf": ("pipeline/config/", "pipeline/sweep/launch.py", "pipeline/sweep/launchers/"),
    "rich": ("pipeline/",),
    "filelock": ("pipeline/",),
    "platformdirs": ("pipeline/",),
    "joblib": (),
    "submitit": ("pipeline/sweep/launchers/submitit_jobs.py",),
    "pin": (),
    "PIL": ("stages/show/preview/webp.py",),
    "pinocchio": ("stages/validate/dynamics/in_pinocchio.py",),
}  # fmt: skip
"""Library → the only places that may import it, at any depth of a module."""

PYDANTIC = ("pipeline/", "stages/fetch/", "stages/robot/quantity_keys.py")
"""The borders, beside the `section.py` of every stage."""


BELOW = ("robot", "targets", "formats", "mujoco", "show")
"""The floors below the stages, from the ground: each imports those before it."""


def breaches(path, source):
    """What a module imports that it must not, with the reason."""
    place = path.relative_to(PROJECT).as_posix()
    folders = place.split("/")
    problems = []
    # What `import linkwright` offers may name arrays to type checkers.
    for name in imported(path, source, types=not place.startswith("pipeline/api/")):
        parts = name.removeprefix("linkwright.").split(".")
        homes = HOMES.get(parts[0])
        if homes is not None and not any(place.startswith(home) for home in homes):
            problems.append(
                f"{place} imports {name}: {parts[0]} belongs to {', '.join(homes) or 'the tests'}"
            )
        if (
            parts[0] == "pydantic"
            and not folders[-1].endswith("section.py")
            and not place.startswith(PYDANTIC)
        ):
            problems.append(f"{place} imports {name}: pydantic is for the borders only")
        if name.partition(".")[0] in ROOMS:
            problems.append(f"{place} imports {name}: what is installed is linkwright.{name}")
        if parts[0] == "tests":
            problems.append(f"{place} imports {name}: the product knows no tests")
        if folders[0] == "stages" and parts[0] in ("pipeline", "conf"):
            problems.append(f"{place} imports {name}: a stage does not know how it is run")
        if folders[0] == "stages" and parts[0] == "stages" and len(parts) > 1:
            allowed = {"robot", folders[1]} if len(folders) > 2 else {"robot"}
            floor = BELOW.index(folders[1]) if folders[1] in BELOW else len(BELOW)
            allowed |= set(BELOW[:floor])
            if parts[1] not in allowed:
                problems.append(f"{place} imports {name}: a stage imports no other stage")
    return problems


@pytest.mark.parametrize("path", modules(), ids=lambda path: path.relative_to(PROJECT).as_posix())
def test_module_keeps_within_the_walls(path):
    assert breaches(path, path.read_text()) == []


ONE_ROOM = re.compile(r"\bmujoco\.(?:Mj(?:Spec|Model)\.from_|mj_(?:id2name|name2id|resetDataKeyframe)\b)")
"""What only `stages/mujoco` does with MuJoCo: it compiles, begins at keyframes and looks names up."""


def test_one_room_compiles_models_and_looks_names_up():
    places = [path for path in modules() if ONE_ROOM.search(path.read_text())]
    assert places
    assert [path.name for path in places if "stages/mujoco/" not in path.as_posix()] == []


@pytest.mark.parametrize(("place", "line"), [
    ("stages/graph/x.py", "from linkwright.stages.mesh import make_geometry"),
    ("stages/graph/x.py", "import linkwright.stages.export.urdf.model"),
    ("stages/graph/x.py", "from ..mesh import section"),
    ("stages/robot/x.py", "from linkwright.stages.graph.tree import span"),
    ("stages/robot/x.py", "from linkwright.stages.formats.xml import parse"),
    ("stages/formats/x.py", "from linkwright.stages.graph.tree import span"),
    ("stages/formats/x.py", "from linkwright.stages.mujoco.compile import compiled_text"),
    ("stages/mujoco/x.py", "from linkwright.stages.validate.simulate.running import flags"),
    ("stages/mujoco/x.py", "from linkwright.stages.show.raster import seen"),
    ("stages/formats/x.py", "from linkwright.stages.show.raster import seen"),
    ("stages/show/x.py", "from linkwright.stages.mesh.part_mesh import PartMesh"),
    ("stages/show/live/x.py", "def f():\n    from linkwright.pipeline.caching.actions import Cache"),
    ("stages/mesh/x.py", "def f():\n    from linkwright.pipeline.caching.actions import Cache"),
    ("stages/mesh/x.py", "import_module('linkwright.stages.export')"),
    ("stages/graph/x.py", "import httpx"),
    ("stages/export/x.py", "from lxml import etree"),
    ("stages/robot/x.py", "def f():\n    import mujoco"),
    ("pipeline/x.py", "def f():\n    import mujoco.viewer"),
    ("pipeline/x.py", "def f():\n    import numpy as np"),
    ("pipeline/x.py", "if TYPE_CHECKING:\n    import numpy.typing"),
    ("pipeline/api/x.py", "import numpy"),
    ("stages/graph/x.py", "from pydantic import BaseModel"),
    ("pipeline/run/build.py", "from omegaconf import OmegaConf"),
    ("pipeline/cli.py", "from hydra import compose"),
    ("pipeline/run/build.py", "import tests.fake_onshape"),
    ("pipeline/run/build.py", "from stages.robot.model import Robot"),
    ("pipeline/x.py", "import conf"),
])  # fmt: skip
def test_breach_is_found(place, line):
    assert len(breaches(PROJECT / place, line)) == 1


@pytest.mark.parametrize(("place", "line"), [
    ("pipeline/stages/stage.py", "from linkwright.stages.mesh import make_geometry"),
    ("stages/mesh/x.py", "from linkwright.stages.robot.model.robot import Robot"),
    ("stages/mesh/x.py", "from linkwright.stages.formats.triangles import names"),
    ("stages/mesh/x.py", "from linkwright.stages.mujoco.compile import compiled_text"),
    ("stages/mesh/x.py", "from linkwright.stages.show.raster import seen"),
    ("stages/show/x.py", "from linkwright.stages.mujoco.compile import compiled_text"),
    ("stages/show/x.py", "from linkwright.stages.show.raster import seen"),
    ("stages/show/x.py", "import mujoco"),
    ("pipeline/api/x.py", "if TYPE_CHECKING:\n    import numpy as np"),
    ("stages/mujoco/x.py", "from linkwright.stages.formats.xml import parse"),
    ("stages/formats/x.py", "from linkwright.stages.robot.model.robot import Robot"),
    ("stages/mesh/x.py", "from linkwright.stages.mesh.weld import weld"),
    ("stages/mesh/section.py", "from pydantic import Field"),
    ("stages/formats/xml.py", "from lxml import etree"),
    ("pipeline/config/compose.py", "import hydra"),
])  # fmt: skip
def test_what_is_allowed_is_let_through(place, line):
    assert breaches(PROJECT / place, line) == []


def test_tests_import_the_product_by_installed_names():
    """In a checkout the folders can be imported too, as other modules than those of `linkwright`."""
    bare = re.compile(rf"^\s*(from|import) ({'|'.join(ROOMS)})\b", re.MULTILINE)
    tests = (PROJECT / "tests").rglob("*.py")
    assert [str(path) for path in tests if bare.search(path.read_text(encoding="utf-8"))] == []


@pytest.mark.slow
def test_each_module_can_be_the_first_that_is_imported():
    """Circles of imports that work only in the order of a build."""
    scripts = ["guestmain.py", "__main__.py"]
    if find_spec("submitit") is None:
        scripts.append("submitit_jobs.py")
    names = sorted(f"linkwright.{name_of(path)}" for path in modules() if path.name not in scripts)
    code = (
        "import os, sys\n"
        "import mujoco, numpy, scipy.spatial, networkx, lxml.etree, pydantic, omegaconf, hydra\n"
        "for name in sys.argv[1:]:\n"
        "    child = os.fork()\n"
        "    if not child:\n"
        "        try:\n"
        "            __import__(name)\n"
        "        except BaseException as error:\n"
        "            print(name, error, flush=True)\n"
        "        os._exit(0)\n"
        "    os.waitpid(child, 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, *names], capture_output=True, text=True, check=True)
    assert done.stdout == ""


EXTRAS = {
    "PIL": ("stages.show.preview.turning", "stages.show.preview.webp"),
    "collada": (),
    "pinocchio": (),
    "pxr": ("stages.export.usd.", "stages.validate.usd.", "stages.validate.read.usd"),
    "pytest": ("pipeline.snapshots.pytest_items",),
    "ray": (),
    "socksio": (),
    "submitit": ("pipeline.sweep.launchers.submitit_jobs",),
    "xacro": ("stages.fetch.urdf.expand_guest",),
}
"""Packages that an installation may lack → the modules, and the beginnings of their names, that need them."""

WITHOUT_EXTRAS = """
import importlib, json, sys
names, extras = json.loads(sys.stdin.read())
sys.modules |= dict.fromkeys(extras)
lacking = []
for name in names:
    try:
        importlib.import_module(f"linkwright.{name}")
    except ImportError as error:
        lacking.append([name, error.name.partition(".")[0]])
print(json.dumps(lacking))
"""


def test_only_what_uses_an_extra_needs_it():
    request = json.dumps([[name_of(path) for path in modules()], list(EXTRAS)])
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_EXTRAS], input=request, capture_output=True, text=True, check=True
    )
    lacking = json.loads(done.stdout)
    assert len(lacking) > len(EXTRAS)
    assert [(name, extra) for name, extra in lacking if not name.startswith(EXTRAS[extra])] == []
