"""The package `linkwright`: its names, how light it is, and other packages with the names of ours."""

import pytest

from linkwright.pipeline import api, errors
from linkwright.pipeline.package.shadows import PACKAGES
from tests.support.face import python, shipped
from tests.support.places import PROJECT

NAMES = """
AssemblyError AuthError Build CacheError Check ConfigError DecompositionFailed Diagnostic Disconnected Dof
EmptyMesh ExportError Frame InTheWay Joint Link LinkwrightError MeshError MissingMass NoRoot NotFound
Offline OutputError ProtocolError QuotaExhausted RateLimited Report Robot SecretFound SourceError
ValidationFailed __version__ build
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    return shipped(tmp_path_factory.mktemp("package"))


def test_the_names_are_these():
    assert sorted(face.__all__) == sorted(NAMES.split())
    assert all(getattr(face, name) is not None for name in face.__all__)


def test_every_error_is_among_them():
    of_ours = {
        name for name, one in vars(errors).items() if isinstance(one, type) and issubclass(one, Exception)
    }
    assert of_ours <= set(face.__all__)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'linkwright' has no attribute 'bild'"):
        _ = face.bild


def test_an_import_loads_nothing_but_the_package_itself(package, tmp_path):
    code = (
        "import sys; import linkwright; "
        "print({name.partition('.')[0] for name in sys.modules} & {'numpy', 'yaml', 'conf', *sys.argv[1:]})"
    )
    done = python(package, "-c", code, *PACKAGES, cwd=tmp_path)
    assert done.stdout == "set()\n", done.stderr


def test_each_name_is_one_of_the_faces_own(package, tmp_path):
    code = (
        "import linkwright, linkwright.pipeline.api\n"
        "from linkwright import *\n"
        "names = linkwright.__all__\n"
        "print(all(getattr(linkwright, name) == getattr(linkwright.pipeline.api, name) for name in names))\n"
        "print(set(names) <= set(dir(linkwright)), build is linkwright.build, hasattr(linkwright, 'bild'))\n"
    )
    done = python(package, "-c", code, cwd=tmp_path)
    assert done.stdout.splitlines() == ["True", "True True False"], done.stderr


def test_it_is_typed(package):
    assert (package / "linkwright" / "py.typed").is_file()


def test_the_product_imports_nothing_of_the_package():
    """A wheel has it as `linkwright` only."""
    importing = [
        path.name
        for path in PROJECT.joinpath("pipeline").rglob("*.py")
        if path.parent.name != "package" and "face.package" in path.read_text()
    ]
    assert importing == []


def test_it_runs_as_the_command(package, tmp_path):
    done = python(package, "-m", "linkwright", "--help", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout.startswith("linkwright: a robot is a YAML file")
    assert python(package, "-m", "linkwright", "robot=nope", cwd=tmp_path).returncode == 2


def message(name, found):
    return (
        f"the package `{name}` is not linkwright's\n"
        f"  found: {found}\n  expected: {PROJECT / name}\n"
        "  → run from another folder, or remove the other package from PYTHONPATH or this environment\n"
    )


@pytest.mark.parametrize("name", PACKAGES)
def test_another_package_of_the_name_is_reported_with_both_paths(package, tmp_path, name):
    other = tmp_path / name
    other.mkdir()
    (other / "__init__.py").touch()
    (tmp_path / "script.py").write_text("import linkwright\nlinkwright.build()\n")
    script = python(package, "script.py", cwd=tmp_path)
    assert script.returncode == 1
    assert script.stderr.endswith(f"ImportError: {message(name, other)}")
    command = python(package, "-m", "linkwright", "--cfg", "job", cwd=tmp_path)
    assert command.returncode == 0, command.stderr
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    command = python(package, "-m", "linkwright", cwd=elsewhere, before=(tmp_path,))
    assert command.returncode == 2
    assert command.stderr == f"error: {message(name, other)}"


def test_a_module_of_the_name_is_reported_as_well(package, tmp_path):
    (tmp_path / "pipeline.py").touch()
    done = python(package, "-c", "from linkwright import build", cwd=tmp_path)
    assert done.stderr.endswith(f"ImportError: {message('pipeline', tmp_path / 'pipeline.py')}")


def test_a_folder_of_the_name_that_is_no_package_is_no_matter(package, tmp_path):
    """Many projects keep YAML in a folder `conf`."""
    (tmp_path / "conf").mkdir()
    done = python(package, "-c", "import linkwright; print(linkwright.Build)", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
