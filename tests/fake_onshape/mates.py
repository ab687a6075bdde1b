"""What each type of mate leaves free, along the chain second entity → slides → turn → first entity.

A value is a number where a mate leaves one thing free, a tuple of numbers (slides, then the turn) where
it leaves several, and a unit quaternion (w, x, y, z) for a BALL. Limits go likewise: a pair, or a tuple of
pairs; of a BALL the pair is (None, half angle of its cone).

Mate frames are right-handed in the world, except those of what a mirror made. Between two left-handed
frames M means the same motion seen in the mirror: with both z axes turned about, so that the frames are
proper, a slide along z runs backwards, turns and other slides stay, and a ball's axis is (−x, −y, z).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tests.fake_onshape.frames import rotation_vector, turn

OPEN = (None, None)
REST = (1.0, 0.0, 0.0, 0.0)
MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])


@dataclass(frozen=True)
class Freedom:
    """A turn about, or a slide along, an axis (0..2), or a ball. `side` is a part of its limits' names,
    `suffix` of its name where the mate leaves more than one."""

    kind: str
    axis: int
    side: str
    suffix: str

    @property
    def limit_names(self):
        """Onshape's names of the least and the greatest value."""
        if self.kind == "ball":
            return None, "limitEulerConeAngleMax"
        return f"limit{self.side}Min", f"limit{self.side}Max"


_TURN = Freedom("turn", 2, "AxialZ", "_turn")
_ALONG = Freedom("slide", 2, "Z", "_slide")
_SLOT = Freedom("slide", 0, "X", "_slide")
_X, _Y, _Z = (Freedom("slide", axis, side, f"_{side.lower()}") for axis, side in enumerate("XYZ"))

FREEDOMS = {
    "FASTENED": (),
    "REVOLUTE": (_TURN,),
    "SLIDER": (_ALONG,),
    "CYLINDRICAL": (_ALONG, _TURN),
    "PIN_SLOT": (_SLOT, _TURN),
    "PLANAR": (_X, _Y, _TURN),
    "PARALLEL": (_X, _Y, _Z, _TURN),
    "BALL": (Freedom("ball", 2, "", ""),),
}


def dof_names(kind, name):
    """The names of what a mate `name` leaves free: its own, or several with suffixes."""
    freedoms = FREEDOMS[kind]
    return (name,) if len(freedoms) == 1 else tuple(name + freedom.suffix for freedom in freedoms)


def dof_of(kind, name, wanted):
    """The name of the one `wanted` (turn or slide) of a mate; ValueError unless there is just one."""
    pairs = zip(dof_names(kind, name), FREEDOMS[kind], strict=True)
    freedoms = [dof for dof, freedom in pairs if freedom.kind == wanted]
    if len(freedoms) != 1:
        msg = f"{name!r}, a {kind}, has {len(freedoms)} freedoms of the kind {wanted}"
        raise ValueError(msg)
    return freedoms[0]


def split(kind, value):
    """A mate's value as a tuple, one entry for each thing that it leaves free."""
    return tuple(value) if len(FREEDOMS[kind]) > 1 else (value,) * len(FREEDOMS[kind])


def joined(kind, values):
    """A mate's value from a tuple as `split` makes it."""
    return values[0] if len(values) == 1 else (tuple(values) or 0.0)


def bounds(kind, limits):
    """A mate's limits as a tuple of pairs, one for each thing that it leaves free."""
    count = len(FREEDOMS[kind])
    if count < 2:
        return (tuple(limits),) * count
    return (OPEN,) * count if tuple(limits) == OPEN else tuple(tuple(pair) for pair in limits)


def motion(kind, value, mirrored=False):
    """The pose (4, 4) of a mate's first frame in its second at `value`, both proper.

    `mirrored`: the frames are those of a mirrored mate, with their z turned about.
    """
    if kind == "BALL":
        made = np.eye(4)
        made[:3, :3] = rotation(value)
        return made
    xyz, angle = [0.0, 0.0, 0.0], 0.0
    for freedom, amount in zip(FREEDOMS[kind], split(kind, value), strict=True):
        if freedom.kind == "turn":
            angle = amount
        else:
            xyz[freedom.axis] = -amount if mirrored and freedom.axis == 2 else amount
    return turn((0, 0, 1), angle, xyz)


def measured(kind, apart, mirrored=False):
    """The value of which `apart` (4, 4) is the motion."""
    values = []
    for freedom in FREEDOMS[kind]:
        if freedom.kind == "ball":
            return quaternion(apart[:3, :3])
        if freedom.kind == "turn":
            values.append(float(np.arctan2(apart[1, 0], apart[0, 0])))
        else:
            values.append(float(apart[freedom.axis, 3]) * (-1.0 if mirrored and freedom.axis == 2 else 1.0))
    return joined(kind, tuple(values))


def misfit(kind, apart):
    """(6,): the turn [rad] and shift [m] of `apart` that a mate does not leave free."""
    turned, moved = rotation_vector(apart[:3, :3]), apart[:3, 3].copy()
    for freedom in FREEDOMS[kind]:
        if freedom.kind == "ball":
            turned = np.zeros(3)
        elif freedom.kind == "turn":
            turned = np.array([apart[0, 2], apart[1, 2], 0.0])
        else:
            moved[freedom.axis] = 0.0
    return np.concatenate([turned, moved])


def rotation(quat):
    """The rotation (3, 3) of a quaternion (w, x, y, z)."""
    return Rotation.from_quat(np.roll(np.asarray(quat, float), -1)).as_matrix()


def quaternion(matrix):
    """The unit quaternion (w, x, y, z), w ≥ 0, of a rotation (3, 3)."""
    return tuple(float(number) for number in np.roll(Rotation.from_matrix(matrix).as_quat(canonical=True), 1))


def in_the_mirror(kind, value):
    """A value as it counts between the proper frames of a mirrored mate."""
    return (value[0], -value[1], -value[2], value[3]) if kind == "BALL" else value
