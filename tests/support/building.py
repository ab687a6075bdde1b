"""From a document of the local Onshape to a robot and its files, without touching a cache."""

from functools import cache

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.export import export
from linkwright.stages.fetch.bundle.archive import read
from linkwright.stages.fetch.onshape.gather import gather
from linkwright.stages.fetch.onshape.replies.recorded import RecordedAnswers
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.robot.model.geometry import Geometry
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.sample import sample_document

NO_MESHES = Geometry((), {})


def plan_of(**keys):
    """A plan of the sample source with these keys; `scene__pose={...}` stands for scene.pose.

    Colliders are quickly made, and links do not touch each other, unless the keys say otherwise.
    """
    tree = {"name": "robot", "source": {"kind": "sample"}}
    for key, value in keys.items():
        *above, last = key.split("__")
        branch = tree
        for step in above:
            branch = branch.setdefault(step, {})
        branch[last] = value
    tree["mesh"] = {"collider": "hull"} | tree.get("mesh", {})
    tree["contact"] = {"self": "none"} | tree.get("contact", {})
    return Plan.parse(tree)


def bundle_of(document, **options):
    """The bundle that a fetch of this document gives."""
    return gather(RecordedAnswers(read(bundle_bytes(document, **options), "document"), "document"))


def robot_of(document, plan=None, **options):
    return build_robot(bundle_of(document, **options), plan or plan_of())


@cache
def sample_robot():
    """The robot of the sample document, made once."""
    return robot_of(sample_document())


def write(robot, folder, plan=None, geometry=NO_MESHES):
    """Exports into `folder`."""
    exported = export(robot, geometry, plan or plan_of())
    for name, data in exported.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return exported


def shaped(document, **keys):
    """The robot of a document and its geometry, by a plan of these keys."""
    robot, plan = robot_of(document), plan_of(**keys)
    return robot, make_geometry(robot, bundle_of(document), plan, lambda kind, key, make: make()), plan


def solid(robot, **more):
    """The geometry of a robot of primitives alone, as they are; `more`: other fields of `Geometry`."""
    return Geometry(tuple(shape for link in robot.links for shape in primitive_shapes(link)), {}, **more)
