"""The package `linkwright`: its names, how light it is, and folders beside a robot with the names of ours."""

import subprocess
import sys
from pathlib import Path

import pytest

import linkwright
from linkwright.pipeline import errors
from tests.support.command import environment
from tests.support.places import PROJECT, ROOMS

NAMES = """
AssemblyError AuthError Build CacheError Check CompiledModel ConfigError DecompositionFailed Diagnostic
Disconnected Dof EmptyMesh ExportError Finding Frame InTheWay Joint Link LinkwrightError MeshError MissingMass
NoRoot NotFound Offline OutputError ProtocolError QuotaExhausted RateLimited Report Robot SecretFound
SourceError ValidationFailed __version__ build
"""


def python(here: Path, *arguments: str, **more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=here,
        env=environment(here, **more),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_the_names_are_these():
    assert sorted(linkwright.__all__) == sorted(NAMES.split())
    assert all(getattr(linkwright, name) is not None for name in linkwright.__all__)


def test_every_error_is_among_them():
    of_ours = {
        name
        for name, value in vars(errors).items()
        if isinstance(value, type) and issubclass(value, Exception)
    }
    assert of_ours <= set(linkwright.__all__)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'linkwright' has no attribute 'bild'"):
        _ = linkwright.bild


def test_an_import_loads_nothing_but_the_package_itself(tmp_path):
    code = (
        "import sys; import linkwright; "
        "print({name for name in sys.modules if name.startswith(('linkwright.', 'numpy', 'yaml'))})"
    )
    done = python(tmp_path, "-c", code)
    assert done.stdout == "set()\n", done.stderr


def test_all_names_can_be_imported_at_once(tmp_path):
    code = (
        "import linkwright\n"
        "from linkwright import *\n"
        "print(set(linkwright.__all__) <= set(dir(linkwright)), build is linkwright.build)\n"
    )
    done = python(tmp_path, "-c", code)
    assert done.stdout == "True True\n", done.stderr


def test_it_is_typed():
    assert Path(linkwright.__file__).with_name("py.typed").is_file()


def test_the_product_imports_its_rooms_by_the_names_that_are_installed():
    """Not by those of the folders, and nothing of the public face, which imports the rooms."""
    importing = [
        path.name
        for top in ROOMS
        for path in PROJECT.joinpath(top).rglob("*.py")
        if "pipeline.package" in path.read_text(encoding="utf-8")
    ]
    assert importing == []


def test_it_runs_as_the_command(tmp_path):
    done = python(tmp_path, "-m", "linkwright", "--help")
    assert done.returncode == 0
    assert done.stdout.startswith("linkwright: a robot is a YAML file")
    assert python(tmp_path, "-m", "linkwright", "robot=nope").returncode == 2


def test_folders_and_modules_beside_the_robot_may_have_the_names_of_ours(tmp_path):
    """A user's project has `conf`, `pipeline` and `stages` of its own: scripts import these, and build."""
    for name in ("conf", "stages"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(f"MINE = '{name}'\n")
    (tmp_path / "pipeline.py").write_text("MINE = 'pipeline'\n")
    (tmp_path / "script.py").write_text(
        "import conf, linkwright, pipeline, stages\n"
        "robot = linkwright.build('source=sample', 'until=graph').robot\n"
        "print(conf.MINE, pipeline.MINE, stages.MINE, len(robot.links))\n"
    )
    done = python(tmp_path, "script.py")
    assert done.stdout.startswith("conf pipeline stages 1"), done.stderr
    built = ("source=sample", "until=export", "mesh=visual")
    for words in (
        ["-m", "linkwright", *built],
        ["-c", "from linkwright.__main__ import main; main()", *built],
    ):
        done = python(tmp_path, *words, PYTHONPATH=str(tmp_path))
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "outputs/sample/sample.xml").is_file()
