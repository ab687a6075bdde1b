"""What travels between stages comes back bit for bit."""

from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from typing_extensions import TypeAliasType

from linkwright.stages.robot import codec
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Limits, Primitive, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.support import robots
from tests.support.robots import joint, loop, robot_with, some_value


def test_a_robot_with_every_type_of_joint_comes_back():
    rng = np.random.default_rng(3)
    joints = []
    for kind in robots.EVERY:
        saved = [some_value(freedom, rng) for _, freedom, _ in robots.CHAINS[kind]]
        limits = {f"{kind}_joint": Limits(upper=0.5)}
        joints.append(joint(kind, "base", kind, saved, place=robots.pose(rng), limits=limits))
    joints[0] = replace(joints[0], mate=None)
    frames = [(kind, robots.pose(rng), robots.pose(rng)) for kind in robots.LOOPS]
    shape = Primitive("box", (0.1, 0.2, 0.3), frozen(robots.pose(rng)), (1.0, 0.5, 0.0, 1.0))
    robot = robot_with(
        joints,
        loops=[loop(kind, "planar", "ball", *ends, name=kind) for kind, *ends in frames],
        given={"planar": robots.solid(2.0)},
        shapes={"ball": (shape,)},
        world_from_root=robots.pose(rng),
    )
    data = codec.encode_robot(robot)
    again = codec.decode_robot(data)
    assert codec.encode_robot(again) == data
    q = saved_configuration(robot)
    assert saved_configuration(again) == q
    assert {type(dof.saved) for dof in again.dofs} == {float, tuple}
    assert (again.joints[0].mate, again.joints[1].mate) == (None, robot.joints[1].mate)
    actual, expected = link_poses(again, q), link_poses(robot, q)
    assert all((actual[name] == expected[name]).all() for name in expected)
    assert again.link("ball").shapes[0].size == shape.size
    assert again.link("planar").given is not None
    assert not again.world_from_root.flags.writeable


def test_primitives_come_back_with_the_geometry():
    primitive = Primitive("sphere", (0.1,), frozen(np.eye(4)))
    mesh = Shape("base", "visual", "base.stl", (1.0, 0.0, 0.0, 1.0), 8, 12, 1.0, 2.0)
    made_up = Shape("base", "collision", None, None, 0, 0, 1.0, 2.0, primitive)
    files = codec.encode_geometry(Geometry((mesh, made_up), {"base.stl": b"solid"}))
    again = codec.decode_geometry(files)
    assert codec.encode_geometry(again) == files
    assert again.shapes[0] == mesh
    assert again.shapes[1].primitive.kind == "sphere"


Scalar = TypeVar("Scalar", bound=np.generic)
# As numpy writes its own NDArray from 2.5 on, which is for Python 3.12 and newer.
Numbers = TypeAliasType("Numbers", np.ndarray[Any, np.dtype[Scalar]], type_params=(Scalar,))
Named = TypeAliasType("Named", Numbers[np.float64])
Pair = TypeAliasType("Pair", tuple[Numbers[np.float64], ...])


@dataclass(frozen=True)
class Aliased:
    plain: Numbers[np.float64]
    named: Named
    maybe: Named | None
    several: Pair
    one_or_several: str | Pair


def test_types_behind_an_alias_come_back_as_what_they_stand_for():
    array = np.array([0.1, 0.2])
    again = codec.load(Aliased, codec.dump(Aliased(array, array, array, (array,), (array, array))))
    arrays = [again.plain, again.named, again.maybe, *again.several, *again.one_or_several]
    assert [type(array) for array in arrays] == [np.ndarray] * 6
    assert all((restored == array).all() for restored in arrays)
    assert codec.load(Aliased, codec.dump(Aliased(array, array, None, (), "word"))).one_or_several == "word"
