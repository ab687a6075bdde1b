"""MJCFs for tests: files written by hand or at random, and the robots that we make of them."""

from importlib import import_module

import mujoco
import numpy as np

from linkwright.stages.export import export
from linkwright.stages.fetch.mjcf.gather import gather
from linkwright.stages.fetch.mjcf.section import MjcfSourceSection
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.validate import validate
from tests.support.building import plan_of
from tests.support.engines import Mujoco
from tests.support.exports import exported

SOLID = '<inertial pos=".01 -.02 .03" mass="{mass}" fullinertia=".02 .03 .025 .001 -.002 .003"/>'


def body(name, inside="", mass=1.0, **attributes):
    """A body with mass; `inside` holds joints, geoms and further bodies."""
    text = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f'<body name="{name}"{text}>{SOLID.format(mass=mass)}{inside}</body>'


def model(world, more="", compiler='angle="radian"'):
    return f'<mujoco model="made up"><compiler {compiler}/><worldbody>{world}</worldbody>{more}</mujoco>'


def written(folder, text, name="model.xml"):
    path = folder / name
    path.write_text(text)
    return path


def bundle_of(path):
    return gather(MjcfSourceSection(path=str(path)))[0]


def robot_of(path, **keys):
    return build_robot(bundle_of(path), plan_of(**keys))


def rebuilt(path, **keys):
    """The export of the robot in this file, without meshes."""
    return exported(robot_of(path, **keys), **keys)


def built(path, folder, **keys):
    """Writes the files of all stages but the cache; what they report, and the checks that fail. Colliders
    are the file's own meshes."""
    plan = plan_of(
        source={"kind": "mjcf", "path": str(path)},
        **{
            "contact": {"self": "auto"},
            "ground": {"kind": "none"},
            "export": {"mjcf": {}},
            "mesh": {"collider": "raw"},
            **keys,
        },
    )
    bundle, warnings = gather(plan.source)
    robot = build_robot(bundle, plan)
    geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
    outcome = export(robot, geometry, plan)
    for name, data in outcome.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    checks = validate(folder, outcome.written, plan)
    failed = tuple(f"{check.name}: {check.detail[:120]}" for check in checks if check.fails)
    return [*warnings, *robot.diagnostics, *geometry.diagnostics, *outcome.diagnostics], failed


class Original(Mujoco):
    """An MJCF as MuJoCo alone sees it, with the frames of a URDF in it: those of each body's last joint."""

    def poses(self, values):
        placed = super().poses(values)
        for index in range(1, self.model.nbody):
            last = int(self.model.body_jntadr[index] + self.model.body_jntnum[index]) - 1
            turns = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_BALL)
            if self.model.body_jntnum[index] and self.model.jnt_type[last] in [int(t) for t in turns]:
                shift = np.eye(4)
                shift[:3, 3] = self.model.jnt_pos[last]
                name = self.model.body(index).name
                placed[name] = placed[name] @ shift
        return placed


def random_model(seed):
    """A tree of some bodies with any joints anywhere, on the world or on a fixed base."""
    rng = np.random.default_rng(seed)

    def row(values):
        return " ".join(repr(float(value)) for value in values)

    def joints(name):
        kinds = [
            ["hinge"],
            ["slide"],
            ["ball"],
            [],
            ["hinge", "hinge", "hinge"],
            ["slide", "hinge"],
            ["hinge", "slide"],
            ["slide", "ball"],
            ["slide", "slide", "hinge", "slide"],
        ][rng.integers(9)]
        text = ""
        for index, kind in enumerate(kinds):
            more = f'pos="{row(rng.uniform(-0.2, 0.2, 3))}" name="{name}_{kind}{index}" type="{kind}"'
            if kind != "ball":
                more += f' axis="{row(rng.normal(size=3))}" ref="{rng.uniform(-1, 1)!r}"'
                if rng.random() < 0.5:
                    more += f' range="{row(sorted(rng.uniform(-2, 2, 2)))}"'
            text += f'<joint {more} armature="{rng.uniform(0, 0.1)!r}" damping="{rng.uniform(0, 1)!r}"/>'
        return text

    children = {0: []}
    for number in range(1, int(rng.integers(3, 8))):
        parent = int(rng.integers(number)) if number > 1 else 0
        children[number] = []
        children[parent].append(number)

    def write(number):
        name = f"link{number}"
        inside = joints(name) if number > 1 or rng.random() < 0.5 else ""
        inside += "".join(write(child) for child in children[number])
        place = {"pos": row(rng.uniform(-1, 1, 3)), "quat": row(rng.normal(size=4))}
        return body(name, inside, mass=repr(rng.uniform(0.5, 2)), **place)

    return model("".join(write(child) for child in children[0]))


def at_home(module, request, *_):
    """A guest's answer without a process of its own: the same code, for tests of what it makes."""
    return import_module(module).answer(request)
