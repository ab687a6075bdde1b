"""No file of the working folder is imported, whatever its name, by any way to run the command."""

import ast
import importlib.metadata
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.command import COMMAND, environment, linkwright, run_in
from tests.support.places import PROJECT

pytestmark = pytest.mark.slow

OURS = {"conf", "pipeline", "stages", "linkwright", "tests"}
NAMED = re.compile("import_module$|find_spec$")
IMPORT = re.compile(r"^\s*(?:import|from)\s+([A-Za-z_]\w*)", re.MULTILINE)


def imports_of_the_product():
    """The top-level names of all imports in the product's files, those named by a text too."""
    for folder in ("pipeline", "stages", "conf"):
        for file in (PROJECT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    yield from (name.name for name in node.names)
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    yield node.module
                elif isinstance(node, ast.Call) and NAMED.search(ast.unparse(node.func)):
                    yield from (str(word.value) for word in node.args[:1] if isinstance(word, ast.Constant))


def imports_of_its_libraries():
    """The names that the libraries of the product, and theirs, import in any of their files."""
    waiting, seen = ["linkwright"], {"linkwright"}
    while waiting:
        try:
            library = importlib.metadata.distribution(waiting.pop())
        except importlib.metadata.PackageNotFoundError:
            continue
        for requirement in library.requires or ():
            name = re.split(r"[^\w.-]", requirement)[0]
            if "extra ==" not in requirement and name not in seen:
                seen.add(name)
                waiting.append(name)
        for file in library.files or ():
            if file.suffix == ".py" and not {"tests", "testing", "test"} & set(file.parts):
                text = Path(str(file.locate())).read_text(encoding="utf-8", errors="replace")
                yield from IMPORT.findall(text)


@pytest.fixture(scope="module")
def traps(tmp_path_factory):
    """A working folder with a file for each module that anything imports, and the folder in which each leaves
    a mark if it runs."""
    folder, marks = tmp_path_factory.mktemp("robot"), tmp_path_factory.mktemp("ran")
    names = {*imports_of_the_product(), *imports_of_its_libraries(), "sitecustomize", "usercustomize"}
    assert names >= {"pinocchio", "pxr", "collada", "numpy", "json", "mujoco"}
    # Modules that `python -m` loads before it has found the command: these are Python's own matter.
    code = "import runpy, sys; print(*{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-I", "-c", code], capture_output=True, text=True, check=True)
    for name in names - {"linkwright", *done.stdout.split()}:
        code = f"import os\nopen(os.path.join({str(marks)!r}, {name!r}), 'w').close()\n"
        if name in OURS or len(name) % 2:
            (folder / name).mkdir()
            (folder / name / "__init__.py").write_text(code)
        else:
            (folder / f"{name}.py").write_text(code)
    return folder, marks


WAYS = {
    "the command": [str(COMMAND)],
    "python -m": [sys.executable, "-m", "linkwright"],
    "python -um": [sys.executable, "-um", "linkwright"],
}


@pytest.mark.parametrize("way", WAYS)
def test_no_module_beside_the_robot_is_imported(traps, tmp_path, way):
    """Neither by a build nor by the command's other verbs, which begin in the same way. Python with two flags
    in one word is tried with a build's first half."""
    folder, marks = traps
    environ, out = environment(tmp_path), str(tmp_path / "out")
    build = ["source=sample", "name=arm", "mesh=hull", "export=[urdf,mjcf,sdf]", f"output={out}"]
    verbs = (
        ["check", out],
        ["diff", out, out],
        ["explain", "E-MASS"],
        ["cache", "info"],
        ["-sc", "query=bash"],
    )
    for words in (
        [*build, "until=graph"] if way == "python -um" else build,
        *(verbs if way == "the command" else ()),
    ):
        done = run_in(folder, *WAYS[way], *words, environ=environ)
        assert "Traceback" not in done.stderr
        assert [path.name for path in marks.iterdir()] == [], words
        assert done.returncode in (0, 2), done.stderr


def test_jobs_of_a_sweep_import_none_either(traps, tmp_path):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    folder, marks = traps
    words = ["-m", "source=sample", "root=auto,fixed", "until=graph", "hydra/launcher=joblib"]
    words += [f"hydra.sweep.dir={tmp_path / 'sweep'}"]
    done = run_in(folder, *WAYS["python -m"], *words, environ=environment(tmp_path))
    assert [path.name for path in marks.iterdir()] == []
    assert done.returncode == 0, done.stderr


def test_entries_for_the_working_folder_are_left_out_of_the_path(tmp_path):
    here, link = tmp_path / "here", tmp_path / "link"
    here.mkdir()
    link.symlink_to(here)
    (here / "my_checks.py").write_text(
        "import os, sys\nprint('PATH', [os.path.realpath(p) for p in sys.path], os.environ['PYTHONPATH'])\n"
        "def light(compiled): return []\n"
    )
    places = os.pathsep.join(["", ".", str(here), str(link), str(tmp_path)])
    words = ["source=sample", "mesh=visual", "export=mjcf", "validate.checks=[{_target_: my_checks.light}]"]
    environ = environment(tmp_path, PYTHONPATH=places)
    done = linkwright(here, *words, "plugins=[my_checks]", environ=environ)
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("PATH")]
    assert f"'{here}'" not in line
    assert line.endswith(f"] {tmp_path}")


def test_the_path_of_a_script_is_the_users(tmp_path):
    (tmp_path / "helper_of_mine.py").write_text("VALUE = 7\n")
    (tmp_path / "script.py").write_text(
        "import sys\nbefore = list(sys.path)\nimport linkwright\nlinkwright.build\n"
        "assert sys.path == before\nimport helper_of_mine\nprint(helper_of_mine.VALUE)\n"
    )
    for words in (["script.py"], ["-m", "script"], ["-c", "import script"]):
        done = run_in(tmp_path, sys.executable, *words)
        assert done.stdout == "7\n", done.stderr
