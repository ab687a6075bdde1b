"""The package `linkwright`: its names, how light it is, and folders beside a robot with the names of ours."""

from pathlib import Path

import pytest

import linkwright
from linkwright.pipeline import errors
from tests.support.places import PROJECT, ROOMS
from tests.support.processes import python

NAMES = """
AssemblyError AuthError Build CacheError Check CompiledModel ConfigError DecompositionFailed Diagnostic
Disconnected Dof EmptyMesh ExportError Finding Frame InTheWay Joint Link LinkwrightError MeshError MissingMass
NoRoot NotFound Offline OutputError ProtocolError QuotaExhausted RateLimited Report Robot SecretFound
SourceError ValidationFailed __version__ build
"""


def test_the_names_are_these_and_every_error_is_among_them():
    assert sorted(linkwright.__all__) == sorted(NAMES.split())
    assert all(getattr(linkwright, name) is not None for name in linkwright.__all__)
    types = {name: value for name, value in vars(errors).items() if isinstance(value, type)}
    assert {name for name, value in types.items() if issubclass(value, Exception)} <= set(NAMES.split())
    with pytest.raises(AttributeError, match="module 'linkwright' has no attribute 'bild'"):
        _ = linkwright.bild


def test_an_import_loads_the_package_alone_and_all_names_come_at_once(tmp_path):
    code = (
        "import sys; import linkwright; loaded = set(sys.modules); from linkwright import *\n"
        "print({name for name in loaded if name.startswith(('linkwright.', 'numpy', 'yaml'))})\n"
        "print(set(linkwright.__all__) <= set(dir(linkwright)), build is linkwright.build)\n"
    )
    done = python("-c", code, cwd=tmp_path)
    assert done.stdout == "set()\nTrue True\n", done.stderr


def test_it_is_typed():
    assert Path(linkwright.__file__).with_name("py.typed").is_file()


def test_the_product_imports_its_rooms_by_the_names_that_are_installed():
    """Not by those of the folders, and nothing of the public face, which imports the rooms."""
    paths = [path for top in ROOMS for path in PROJECT.joinpath(top).rglob("*.py")]
    assert [path for path in paths if "pipeline.package" in path.read_text(encoding="utf-8")] == []


def test_it_runs_as_the_command(tmp_path):
    done = python("-m", "linkwright", "--help", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout.startswith("linkwright: a robot is a YAML file")
    assert python("-m", "linkwright", "robot=nope", cwd=tmp_path).returncode == 2


@pytest.mark.e2e
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
    environ = {"HOME": str(tmp_path), "LINKWRIGHT_CACHE": str(tmp_path / "cache")}
    done = python("script.py", cwd=tmp_path, **environ)
    assert done.stdout.startswith("conf pipeline stages 1"), done.stderr
    for words in (["-m", "linkwright"], ["-c", "from linkwright.__main__ import main; main()"]):
        words += ["source=sample", "until=export", "mesh=visual"]
        done = python(*words, cwd=tmp_path, PYTHONPATH=str(tmp_path), **environ)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "outputs/sample/sample.xml").is_file()
