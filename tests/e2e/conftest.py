"""Builds of the sample and of the robots of others, which several modules read."""

import pytest
from filelock import FileLock

from tests.support.command import called, environment
from tests.support.other_robots import AS_IT_IS, FILES, is_here, source_of

KEYS = (
    "mesh=hull", "actuators=position", "validate=quick", "export=[urdf,mjcf,sdf,ros2,python]", "output=out",
    "export.python.author='Ada \"L\" Ü'", "export.python.license=MIT", "export.python.version=1.2.0",
)  # fmt: skip


@pytest.fixture(scope="session")
def build_of(run_folder, shared_cache):
    """Returns the folder of a robot's build, which the first process that asks for it makes. Git is told to
    ignore meshes there."""

    def build(name):
        if not is_here(name):
            pytest.skip("needs the robots of others")
        here = run_folder / f"built_{name}"
        with FileLock(f"{here}.lock"):
            if not (here / "out").exists():
                (here / ".git").mkdir(parents=True)
                (here / ".gitignore").write_text("*.stl\nassets/\n")
                environ = environment(here, seeded=False, LINKWRIGHT_CACHE=str(shared_cache))
                called(here, *source_of(name), *KEYS, *AS_IT_IS, environ=environ, status=0)
        return here / "out"

    return build


@pytest.fixture(params=["sample", *(pytest.param(name, marks=pytest.mark.slow) for name in FILES)])
def built(request, build_of):
    return build_of(request.param)


@pytest.fixture
def sample(build_of):
    return build_of("sample")
