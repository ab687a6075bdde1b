"""A new source, format, proof of a format or check is one folder or file and one line in a table: each test
adds one to a copy.

Besides the code, a source and a format need one YAML in `conf` and its golden. A new fact of the robot is a
field of the model and of robot.json, and a line of each writer.
"""

import json
import shutil
import subprocess
import sys

import mujoco
import pytest

from tests.support.command import environment
from tests.support.places import PROJECT, ROOMS, link_package

pytestmark = pytest.mark.e2e

GOLDENS = """
import sys
from pathlib import Path
from tests.config.regenerate import GOLDEN, names, text
assert sorted(names()) == sorted(file.stem for file in GOLDEN.iterdir())
for name in sys.argv[1:]:
    assert text(name, Path.cwd().parent) == (GOLDEN / f"{name}.yaml").read_text(encoding="utf-8"), name
"""
"""Checks that every file of `conf` has its golden, and compares the goldens that are named."""


class Tree:
    """A copy of the product and of its goldens, to which a test adds something."""

    def __init__(self, folder):
        self.folder = folder
        for name in (*ROOMS, "tests/config"):
            # With the compiled modules, which are valid in the copy: to compile them again takes a second.
            shutil.copytree(PROJECT / name, folder / name)
        # As an installation has it, before which the copy comes on Python's path.
        link_package(folder, folder)
        shutil.copy(PROJECT / "tests/__init__.py", folder / "tests")
        shutil.copy(PROJECT / "pyproject.toml", folder)

    def add(self, path, text):
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        assert not file.exists()
        file.write_text(text, encoding="utf-8")

    def add_line(self, path, place, line, behind=False):
        """Adds a line to a table in front of the one that is the text `place`, or behind it."""
        file = self.folder / path
        text = file.read_text(encoding="utf-8")
        assert text.count(f"\n{place}\n") == 1
        both = f"\n{place}\n{line}\n" if behind else f"\n{line}\n{place}\n"
        file.write_text(text.replace(f"\n{place}\n", both), encoding="utf-8")

    def run(self, *arguments):
        """The output of Python in the copy."""
        line = [sys.executable, *arguments]
        environ = environment(self.folder.parent, PYTHONPATH=str(self.folder))
        done = subprocess.run(line, cwd=self.folder, env=environ, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def build(self, *overrides):
        """The folder of a build in which every check passed."""
        output = self.folder.parent / "built"
        # The installed command would run the product as it is, not its copy.
        code = "import sys; from linkwright.pipeline.cli import main; sys.exit(main())"
        self.run("-c", code, *overrides, f"output={output}")
        return output

    def check_goldens(self, toy):
        """Every file of `conf` has its golden: the toy's is right, and others did not change."""
        self.run("-c", GOLDENS, toy, "robot.sample", "export.urdf")


@pytest.fixture
def tree(tmp_path):
    return Tree(tmp_path / "tree")


@pytest.mark.slow
def test_source_is_a_folder_a_line_an_option_and_its_golden(tree):
    tree.add("stages/fetch/toy/__init__.py", '"""A chain of links that no file describes."""\n')
    tree.add(
        "stages/fetch/toy/section.py",
        '''"""Configuration of the source `toy`."""

from typing import Literal

from linkwright.stages.fetch.source_section import SourceSection
from linkwright.stages.robot.section import Count


class ToySourceSection(SourceSection):
    """A chain of links."""

    kind: Literal["toy"] = "toy"
    """Kind of the source; `source=KIND` chooses it."""

    count: Count = 2
    """Number of links."""
''',
    )
    tree.add(
        "stages/fetch/toy/source.py",
        '''"""The source `toy`."""

from hashlib import sha256

from linkwright.stages.fetch.source import FetchContext, Fetched, Source
from linkwright.stages.robot.bundle import FileBundle

LINK = """<link name="l{0}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="j{1}" type="continuous"><parent link="l{0}"/><child link="l{1}"/></joint>"""


class ToySource(Source):
    def __init__(self, keys):
        self._count = keys.count

    def label(self):
        return "the toy"

    def pinned(self, environ):
        return {"count": self._count}

    def fetch(self, context: FetchContext) -> Fetched:
        links = [LINK.format(n) for n in range(self._count)]
        joints = [JOINT.format(n - 1, n) for n in range(1, self._count)]
        text = f"<robot name='toy'>{''.join(links + joints)}</robot>".encode()
        digest = sha256(text).hexdigest()
        root = {"document": "toy", "microversion": "", "element": "", "configuration": ""}
        return Fetched(FileBundle("urdf", root, digest, {"robot": digest}, {digest: text}))
''',
    )
    table = "stages/fetch/section.py"
    before = "from linkwright.stages.fetch.source_section import SourceSection"
    tree.add_line(table, before, "from linkwright.stages.fetch.toy.section import ToySourceSection")
    tree.add_line(table, '    "sample": SampleSourceSection,', '    "toy": ToySourceSection,')
    table = "stages/fetch/sources.py"
    before = "SOURCES: dict[str, Callable[[], type[Source]]] = {"
    tree.add_line(table, before, "def _toy():")
    tree.add_line(table, before, "    from linkwright.stages.fetch.toy.source import ToySource")
    tree.add_line(table, before, "    return ToySource")
    tree.add_line(table, '    "sample": _sample,', '    "toy": _toy,')
    tree.add("conf/source/toy.yaml", "kind: toy\n")
    tree.add("tests/config/golden/source.toy.yaml", "source:\n  kind: toy\n  count: 2\n")
    tree.check_goldens("source.toy")
    robot = json.loads((tree.build("source=toy", "source.count=3") / "robot.json").read_text())
    assert [link["name"] for link in robot["links"]] == ["l0", "l1", "l2"]


@pytest.mark.slow
def test_format_is_a_folder_a_line_an_option_and_its_golden(tree):
    tree.add("stages/export/toy/__init__.py", '"""A list of the links, and of the files of the URDF."""\n')
    tree.add(
        "stages/export/toy/section.py",
        '''"""Configuration of the toy writer."""

from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.robot.section import Text


class ToySection(FormatSection):
    """The list."""

    files = ("<name>.txt",)

    title: Text = "Links"
    """The first line."""
''',
    )
    tree.add(
        "stages/export/toy/writer.py",
        '''"""The toy writer."""

from linkwright.stages.export.toy.section import ToySection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class ToyWriter:
    section = ToySection
    reads = ("urdf",)
    modules = ()

    def write(self, given: WriterInput) -> FormatFiles:
        robot = given.written.robot
        (path,) = self.section.paths(robot.name)
        lines = [given.keys.export.toy.title, *(link.name for link in robot.links), *given.files]
        return FormatFiles({path: "\\n".join(lines).encode()})
''',
    )
    table = "stages/export/writers.py"
    before = "from linkwright.stages.export.urdf.writer import UrdfWriter"
    tree.add_line(table, before, "from linkwright.stages.export.toy.writer import ToyWriter")
    tree.add_line(table, '    "mjcf": MjcfWriter(),', '    "toy": ToyWriter(),')
    table = "stages/export/section.py"
    before = "from linkwright.stages.export.urdf.section import UrdfFormatSection"
    tree.add_line(table, before, "from linkwright.stages.export.toy.section import ToySection")
    tree.add_line(table, '    "mjcf": MjcfFormatSection,', '    "toy": ToySection,')
    tree.add("conf/export/toy.yaml", "# @package export.toy\ntitle: Links\n")
    tree.add("tests/config/golden/export.toy.yaml", "export:\n  toy:\n    title: Links\n")
    tree.check_goldens("export.toy")
    output = tree.build("source=sample", "mesh=visual", "export=[toy]", "export.toy.title=Parts")
    lines = (output / "sample.txt").read_text().split("\n")
    links = json.loads((output / "robot.json").read_text())["links"]
    assert lines == ["Parts", *(link["name"] for link in links), "sample.urdf", "sample.srdf"]
    assert not list(output.glob("*.urdf"))


def test_check_is_a_file_and_a_line(tree):
    tree.add(
        "stages/validate/checks/toy.py",
        '''"""The robot is light."""


def check(compiled):
    mass = float(compiled.model.body_mass.sum())
    yield compiled.within("light", mass, 1000.0, "total mass [kg]")
''',
    )
    table = "stages/validate/checks/__init__.py"
    tree.add_line(
        table,
        "from linkwright.stages.validate.engines import ENGINES",
        "from linkwright.stages.validate.checks import toy",
    )
    tree.add_line(
        table,
        '    ModelCheck("C-KEYFRAME", "keyframes", keyframes.check, ("mjcf", "scene")),',
        '    ModelCheck("C-TOY", "toy", toy.check, ("mjcf", "urdf")),',
    )
    report = json.loads((tree.build("source=sample", "mesh=visual") / "report.json").read_text())
    light = [check for check in report["checks"] if check["name"].endswith(": light")]
    assert [check["name"] for check in light] == [f"{file}: light" for file in ("sample.xml", "sample.urdf")]
    assert all(check["passed"] and 0 < check["value"] < 10 for check in light)


READER = """\
\"\"\"The robot of a toy file: a JSON of links, joints, relations and loops.\"\"\"

import json

import numpy as np

from linkwright.stages.robot.model.poses import inverse, motion
from linkwright.stages.validate.model.mass_properties import MassProperties
from linkwright.stages.validate.same.read_robot import (
    AttributeNames, FoundJoint, FoundMimic, FoundPose, Poses, ReadRobot, UnreadableFile
)
from linkwright.stages.validate.read.run import run_checks


class ReadToy(ReadRobot):
    attribute_names = AttributeNames(
        mass="mass", com="com", inertia="inertia ", axis="axis", place=("place", "place"),
        mimic=("factor", "offset"), numbers={},
    )

    def __init__(self, path, written):
        try:
            self.toy = json.loads(path.read_bytes())
        except ValueError as error:
            raise UnreadableFile(f"it is not JSON: {error}") from None
        self.file, self.robot, self.fixed_dofs = path.name, written.robot, {}
        self.file_configuration = {dof.name: dof.saved for dof in written.robot.dofs}

    def names_found(self):
        return {"link": self.toy["links"].keys(), "joint": self.toy["joints"].keys()}

    def names_expected(self):
        links, joints = self.robot.links, self.robot.joints
        return {"link": {link.name for link in links}, "joint": {joint.name for joint in joints}}

    def mass_properties(self, link):
        own = self.toy["links"][link]
        return MassProperties(own["mass"], np.array(own["com"]), np.array(own["inertia"]))

    def poses(self, q):
        found = {self.robot.root.name: np.eye(4)}
        for joint in self.toy["joints"].values():
            pose = found[joint["parent"]] @ np.array(joint["parent_from_joint"])
            found[joint["child"]] = pose @ self._chain(joint["dofs"], q)
        return Poses(found, {})

    def _chain(self, dofs, q):
        pose = np.eye(4)
        for dof in dofs:
            moved = motion(dof["kind"], np.array(dof["axis"]), q[dof["name"]])
            pose = pose @ np.array(dof["origin"]) @ moved
        return pose

    def parent(self, link):
        joints = self.toy["joints"].values()
        return next((joint["parent"] for joint in joints if joint["child"] == link), "")

    def joints(self):
        for joint in self.robot.joints:
            dofs = {dof["name"]: dof for dof in self.toy["joints"][joint.name]["dofs"]}
            for dof in joint.dofs:
                own = dofs[dof.name]
                scalar = dof.kind in ("turn", "slide")
                low, high = own["interval"]
                damping = own["damping"] or 0.0
                numbers = {"lower": low, "upper": high, "damping": damping} if scalar else {}
                element = self.element("joint", dof.name)
                yield FoundJoint(dof.name, element, own["kind"], (dof.kind,), dof, numbers)

    def mimics(self):
        return (FoundMimic(*row) for row in self.toy["relations"])

    def loop_poses(self, loop, q):
        own = self.toy["loops"][loop.name]
        for link in "ab":
            frame = getattr(loop, f"{link}_from_frame")
            place = np.array(own[f"{link}_from_frame"])
            yield FoundPose(f'loop "{loop.name}"', (link, link), place, frame)


def check_file(path, written, quick):
    return run_checks(ReadToy, path, written, quick=quick)
"""

PROOF = """\
import json, sys
from functools import reduce
from operator import attrgetter
from pathlib import Path
from linkwright.stages.formats.described import described
from linkwright.stages.targets.section import TargetSection
from linkwright.stages.validate import run

folder = Path(sys.argv[1])
written = described((folder / "robot.json").read_bytes()).written
robot = written.robot


def facts(value, *names):
    '''The values of an object's attributes: of `inertial.mass` under the name `mass`.'''
    rows = {name.rpartition(".")[2]: attrgetter(name)(value) for name in names}
    return {name: row.tolist() if hasattr(row, "tolist") else row for name, row in rows.items()}


toy = {
    "links": {
        link.name: facts(link, "inertial.mass", "inertial.com", "inertial.inertia") for link in robot.links
    },
    "joints": {
        joint.name: {
            **facts(joint, "parent", "child", "parent_from_joint"),
            "dofs": [
                facts(dof, "name", "kind", "axis", "origin", "limits.interval", "dynamics.damping")
                for dof in joint.dofs
            ],
        }
        for joint in robot.joints
    },
    "relations": [[row.follower, row.driver, row.multiplier, row.offset] for row in robot.relations],
    "loops": {loop.name: facts(loop, "a_from_frame", "b_from_frame") for loop in robot.loops},
}


def failed(text):
    (folder / f"{robot.name}.toy").write_text(text)
    results = run.check_formats(folder, written, TargetSection(), quick=False)
    wrong = [check.name for check in results if not check.passed]
    return [name.partition(": ")[2] for name in wrong if ".toy:" in name]


def changed(*path):
    other = json.loads(json.dumps(toy))
    *above, last = path
    place = reduce(lambda part, key: part[key], above, other)
    place[last] = (place[last] or 0.0) + 0.01
    return failed(json.dumps(other))


moved = next(joint for joint in robot.joints if joint.dofs and joint.dofs[0].kind == "turn")
link, joint, loop = robot.links[1].name, ("joints", moved.name), robot.loops[0].name
print(json.dumps({
    "none": failed(json.dumps(toy)),
    "text": failed("nothing"),
    "mass": changed("links", link, "mass"),
    "place": changed(*joint, "parent_from_joint", 0, 3),
    "damping": changed(*joint, "dofs", 0, "damping"),
    "loop": changed("loops", loop, "a_from_frame", 0, 3),
}))
"""


def test_proof_of_a_format_is_a_reader_and_a_line(tree):
    """The reader says what a file has, and is below 200 lines; what it must have is compared already."""
    assert len(READER.splitlines()) < 200
    tree.add("stages/validate/read/toy.py", READER)
    table = "stages/validate/format_checks.py"
    tree.add_line(
        table,
        "from linkwright.stages.validate.rows import FormatCheck",
        "from linkwright.stages.validate.read import toy",
    )
    tree.add_line(
        table,
        '    FormatCheck("C-SDF", ".sdf", _check_sdf),',
        '    FormatCheck("C-TOY", ".toy", toy.check_file),',
    )
    folder = tree.build("source=sample", "mesh=visual")
    tree.add("proof.py", PROOF)
    said = json.loads(tree.run("proof.py", str(folder)))
    assert said == {
        "none": [], "text": ["reads"], "mass": ["mass"], "place": ["poses", "motion"], "damping": ["joints"],
        "loop": ["loops"],
    }  # fmt: skip


READ_BACK = """
import json, sys
from pathlib import Path
from linkwright.stages.formats.described import described
from tests.config.robot_json import markdown, schema
data = Path(sys.argv[1], "robot.json").read_bytes()
row = schema()["$defs"]["LinkRecord"]["properties"]["density"]
links = described(data).written.robot.links
print(json.dumps([[link.density for link in links], row, "kg/m³" in markdown()]))
"""
"""What the reader, the JSON Schema and the page about robot.json have of the density."""


@pytest.mark.slow
def test_fact_of_the_robot_is_a_field_and_a_line_of_each_writer(tree):
    """The density of a link's material, which reaches robot.json and is read back, the MJCF and the page."""
    tree.add_line(
        "stages/robot/model/robot.py",
        "    shapes: tuple[Primitive, ...] = ()",
        "    density: float = 2712.5",
        behind=True,
    )
    records = "stages/formats/robot_json/links.py"
    tree.add_line(records, "    shapes: tuple[LinkShapeRecord, ...]", "    density: Number", behind=True)
    meaning = "    density: density of its material [kg/m³]."
    tree.add_line(records, "    shapes: shapes of the user's own.", meaning, behind=True)
    tree.add_line(
        "stages/export/mjcf/bodies.py",
        "        axes = None if frame is None else frame.body_from_inertial",
        '        body.set("user", number(link.density))',
        behind=True,
    )
    tree.add_line(
        "stages/show/graph_view/tables.py",
        "            _share(link.inertial.mass, total),",
        '            f"{link.density:g} kg/m³, " +',
    )
    output = tree.build("source=sample", "mesh=visual")
    links = json.loads((output / "robot.json").read_text())["links"]
    assert {link["density"] for link in links} == {2712.5}
    densities, row, documented = json.loads(tree.run("-c", READ_BACK, str(output)))
    assert densities == [2712.5] * len(links)
    assert row == {"type": "number", "description": "Density of its material [kg/m³]."}
    assert documented
    bodies = mujoco.MjModel.from_xml_path(str(output / "sample.xml")).body_user
    assert bodies[1:].ravel().tolist() == [2712.5] * (len(bodies) - 1)
    assert "2712.5 kg/m³, " in (output / "report.html").read_text(encoding="utf-8")
