"""The shapes of a robot.json, without the files of the meshes, and which of them touch."""

from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json.codec import UNREAD, JsonRecord, Key
from linkwright.stages.formats.robot_json.links import PrimitiveRecord
from linkwright.stages.formats.robot_json.values import Bounds, Colour, LinkName, Short, TextPairs, each_of
from linkwright.stages.robot.model.geom_form import PLAIN, ContactProperties, GeomForm
from linkwright.stages.robot.model.geometry import Exclude, ExcludeReason, Role, Shape, Touch


@dataclass(frozen=True)
class ContactRecord(JsonRecord[ContactProperties]):
    """MuJoCo's properties in contact, in its words and units, as far as they are given.

    friction: sliding [-], torsional [m] and rolling [m].
    condim: the dimension of the contact.
    solref: stiffness and damping of the contact's constraint.
    solimp: impedance of the contact's constraint.
    margin: distance at which a contact begins [m].
    priority: of two geoms, that of the higher has its way.
    solmix: the weight in the mixture with the other geom.
    gap: distance within the margin that has no force [m].
    contype: bits of what it is.
    conaffinity: bits of what it collides with.
    """

    friction: Annotated[tuple[float, float, float] | None, each_of(3)] = None
    condim: int | None = None
    solref: Annotated[tuple[float, float] | None, each_of(2)] = None
    solimp: Annotated[tuple[float, float, float, float, float] | None, each_of(5)] = None
    margin: float | None = None
    priority: int | None = None
    solmix: float | None = None
    gap: float | None = None
    contype: int | None = None
    conaffinity: int | None = None


@dataclass(frozen=True)
class GeomRecord(JsonRecord[GeomForm]):
    """How an MJCF source has a shape.

    name: of its geom; "" for none.
    attributes: what no other format has, as MJCF's text.
    """

    name: str
    attributes: TextPairs


@dataclass(frozen=True, kw_only=True)
class ShapeRecord(JsonRecord[Shape]):
    """What is seen, or what collides: a mesh or a primitive.

    link: the link that has it.
    role: whether it is seen or collides.
    number: counts those of a link and a role, in the order in which all files have them.
    file: the mesh, in the frame of the link; null for a primitive.
    primitive: null for a mesh.
    colour: red, green, blue and alpha in 0..1; null for neutral grey, and where it only collides.
    texture: the image of a mesh with texture coordinates; null for none.
    vertices: of a mesh, else 0.
    faces: of a mesh, else 0.
    area: surface [m²].
    volume: volume [m³]; 0 where a mesh is not closed.
    contact: what is given of MuJoCo's properties in contact; null for nothing.
    collider: which of its link's colliders it is, or is a piece of; null for none.
    bounds: of a mesh, the least x, y and z and the largest [m].
    geom: present where an MJCF source names it, or has attributes of it that no other format has.
    ellipsoid: what it is in the MJCF, where all other formats have a mesh.
    """

    link: LinkName
    role: Role
    number: Annotated[int, UNREAD]
    file: str | None
    primitive: PrimitiveRecord | None
    colour: Colour | None
    texture: str | None
    vertices: int
    faces: int
    area: Short
    volume: Short
    contact: ContactRecord | None
    collider: int | None
    bounds: Bounds | None
    form: Annotated[GeomRecord | None, Key("geom")] = None
    ellipsoid: PrimitiveRecord | None = None

    @classmethod
    def from_model(cls, value: Shape, **more: Any) -> "ShapeRecord":
        form = value.form if value.form.name or value.form.attributes else None
        return super().from_model(value, form=form, bounds=value.bounds or None, **more)

    def to_model(self, **more: Any) -> Shape:
        form = self.form.to_model() if self.form else PLAIN
        return super().to_model(form=form, bounds=self.bounds or ())


@dataclass(frozen=True)
class ColliderRecord(JsonRecord[None]):
    """How some parts of a link collide.

    link: the link.
    number: counts those of a link.
    parts: the parts, by their names in CAD.
    made: what they collide as: a kind of primitive, hull, pieces, spheres, raw or none.
    reason: why, of a collider by contact; else "".
    """

    link: LinkName
    number: Annotated[int, UNREAD]
    parts: Annotated[tuple[str, ...], UNREAD]
    made: Annotated[str, UNREAD]
    reason: Annotated[str, UNREAD]


@dataclass(frozen=True)
class ExcludeRecord(JsonRecord[Exclude]):
    """Two links that do not collide, or only some of their colliders.

    link_a: the first, in the order of the links.
    link_b: the second.
    reason: Adjacent: a joint or a rigid connection between them; Always: they touch in whatever pose; Source:
        the source says so; User: the configuration does.
    depth: how deep what does not collide is in each other at `home` [m].
    geoms: only these pairs of their colliders, by their numbers; empty for all.
    """

    link_a: LinkName
    link_b: LinkName
    reason: ExcludeReason
    depth: Short
    geoms: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class TouchRecord(JsonRecord[Touch]):
    """Two links that may collide, and touch at `home`.

    link_a: the first, in the order of the links.
    link_b: the second.
    depth: how deep they are in each other there [m].
    """

    link_a: LinkName
    link_b: LinkName
    depth: Short
