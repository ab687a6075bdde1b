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

TOYS = PROJECT / "tests/unit/toys"

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

    def add(self, toy):
        """Adds the files of a toy, which have their paths below its folder, and `.txt` behind."""
        for source in sorted((TOYS / toy).rglob("*.txt")):
            file = self.folder / source.relative_to(TOYS / toy).with_suffix("")
            file.parent.mkdir(parents=True, exist_ok=True)
            assert not file.exists()
            shutil.copy(source, file)

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
    tree.add("source")
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
    tree.check_goldens("source.toy")
    robot = json.loads((tree.build("source=toy", "source.count=3") / "robot.json").read_text())
    assert [link["name"] for link in robot["links"]] == ["l0", "l1", "l2"]


@pytest.mark.slow
def test_format_is_a_folder_a_line_an_option_and_its_golden(tree):
    tree.add("format")
    table = "stages/export/writers.py"
    before = "from linkwright.stages.export.urdf.writer import UrdfWriter"
    tree.add_line(table, before, "from linkwright.stages.export.toy.writer import ToyWriter")
    tree.add_line(table, '    "mjcf": MjcfWriter(),', '    "toy": ToyWriter(),')
    table = "stages/export/section.py"
    before = "from linkwright.stages.export.urdf.section import UrdfFormatSection"
    tree.add_line(table, before, "from linkwright.stages.export.toy.section import ToySection")
    tree.add_line(table, '    "mjcf": MjcfFormatSection,', '    "toy": ToySection,')
    tree.check_goldens("export.toy")
    output = tree.build("source=sample", "mesh=visual", "export=[toy]", "export.toy.title=Parts")
    lines = (output / "sample.txt").read_text().split("\n")
    links = json.loads((output / "robot.json").read_text())["links"]
    assert lines == ["Parts", *(link["name"] for link in links), "sample.urdf", "sample.srdf"]
    assert not list(output.glob("*.urdf"))


def test_check_is_a_file_and_a_line(tree):
    tree.add("check")
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


def test_proof_of_a_format_is_a_reader_and_a_line(tree):
    """The reader says what a file has, and is below 200 lines; what it must have is compared already."""
    reader = TOYS / "proof/stages/validate/read/toy.py.txt"
    assert len(reader.read_text(encoding="utf-8").splitlines()) < 200
    tree.add("proof")
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
    said = json.loads(tree.run("proof.py", str(folder)))
    assert said == {
        "none": [], "text": ["reads"], "mass": ["mass"], "place": ["poses", "motion"], "damping": ["joints"],
        "loop": ["loops"],
    }  # fmt: skip


READ_BACK = """
import json, sys
from pathlib import Path
from linkwright.stages.formats.described import read_robot_json
from tests.config.robot_json import markdown, schema
data = Path(sys.argv[1], "robot.json").read_bytes()
row = schema()["$defs"]["LinkRecord"]["properties"]["density"]
links = read_robot_json(data).written.robot.links
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
