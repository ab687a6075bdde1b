"""What travels between stages comes back bit for bit."""

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import pytest
from typing_extensions import TypeAliasType

from linkwright.stages.robot import codec
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Primitive, frozen
from tests.support.truth import differences
from tests.unit.formats.test_described import whole


@pytest.mark.parametrize("seed", range(3))
def test_robot_with_every_type_of_joint_and_loop_comes_back(seed):
    again = codec.decode_robot(codec.encode_robot(whole(seed)))
    assert differences(whole(seed), again, 0.0, {}) == []
    data = codec.encode_robot(again)
    assert codec.encode_robot(codec.decode_robot(data)) == data
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
