"""Defines the shapes of robot.json, without the files of the meshes, and their contacts."""

from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json.codec import UNREAD, JsonRecord, Key
from linkwright.stages.formats.robot_json.links import PrimitiveRecord
from linkwright.stages.formats.robot_json.values import (
    Bounds,
    Colour,
    LinkName,
    SixDigits,
    TextPairs,
    numbers_by_own_scale,
)
from linkwright.stages.robot.model.geom_form import PLAIN, ContactProperties, GeomForm
from linkwright.stages.robot.model.geometry import Exclude, ExcludeReason, Role, Shape, Touch


@dataclass(frozen=True)
class ContactRecord(JsonRecord[ContactProperties]):
    """MuJoCo's contact properties that are set, in its names and units.

    friction: sliding [-], torsional [m] and rolling [m].
    condim: the dimension of the contact.
    solref: stiffness and damping of the contact's constraint.
    solimp: impedance of the contact's constraint.
    margin: distance at which a contact begins [m].
    priority: of two geoms in contact, the geom with the higher priority sets the properties.
    solmix: the weight in the mixture with the other geom.
    gap: contacts have a force only at distances below margin − gap [m].
    contype: bits that are compared with the other geom's conaffinity.
    conaffinity: bits that are compared with the other geom's contype: the geoms collide if either comparison
        finds a common bit.
    """

    friction: Annotated[tuple[float, float, float] | None, numbers_by_own_scale(3)] = None
    condim: int | None = None
    solref: Annotated[tuple[float, float] | None, numbers_by_own_scale(2)] = None
    solimp: Annotated[tuple[float, float, float, float, float] | None, numbers_by_own_scale(5)] = None
    margin: float | None = None
    priority: int | None = None
    solmix: float | None = None
    gap: float | None = None
    contype: int | None = None
    conaffinity: int | None = None


@dataclass(frozen=True)
class GeomRecord(JsonRecord[GeomForm]):
    """A shape's geom in an MJCF source.

    name: the name of the geom, or "".
    attributes: the attributes that no other format has, as MJCF's text.
    """

    name: str
    attributes: TextPairs


@dataclass(frozen=True, kw_only=True)
class ShapeRecord(JsonRecord[Shape]):
    """A visual shape or a collider: a mesh or a primitive.

    link: the link that has it.
    role: visual or collision.
    number: its index among the shapes of its link and role, in the order of all files.
    file: the mesh, in the frame of the link; null for a primitive.
    primitive: the primitive; null for a mesh.
    colour: red, green, blue and alpha in 0..1; null for neutral grey, and for a shape that only collides.
    texture: the image of a mesh with texture coordinates; null without an image.
    vertices: the number of vertices of a mesh, otherwise 0.
    faces: the number of triangles of a mesh, otherwise 0.
    area: surface [m²].
    volume: volume [m³]; 0 if a mesh is not closed.
    contact: MuJoCo's contact properties that are set; null if nothing is set.
    collider: the number of the link's collider to which the shape belongs; null without a collider.
    bounds: the smallest x, y and z of a mesh, and the largest [m]; null for a primitive.
    geom: present if an MJCF source names the geom, or has attributes of it that no other format has.
    ellipsoid: the ellipsoid that the MJCF has in place of this mesh; missing without an ellipsoid.
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
    area: SixDigits
    volume: SixDigits
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
class WholeVisualRecord(JsonRecord[Shape]):
    """All visual meshes of a link in one file.

    link: the link that has them.
    file: a GLB with their colours and images.
    vertices: the number of vertices of all meshes.
    faces: the number of triangles of all meshes.
    area: surface [m²].
    volume: volume of the closed meshes [m³].
    bounds: the smallest x, y and z, and the largest [m], in the frame of the link.
    """

    link: LinkName
    file: str
    vertices: int
    faces: int
    area: SixDigits
    volume: SixDigits
    bounds: Bounds

    def to_model(self, **more: Any) -> Shape:
        return super().to_model(role="visual", colour=None)


@dataclass(frozen=True)
class ColliderRecord(JsonRecord[None]):
    """The collider of some parts of a link.

    link: the link.
    number: its index among the colliders of its link.
    parts: the parts, by their names in CAD.
    made: what the collider consists of: a kind of primitive, hull, pieces, spheres, raw or none.
    reason: why a collider by contact has this number of pieces; otherwise "".
    """

    link: LinkName
    number: Annotated[int, UNREAD]
    parts: Annotated[tuple[str, ...], UNREAD]
    made: Annotated[str, UNREAD]
    reason: Annotated[str, UNREAD]


@dataclass(frozen=True)
class ExcludeRecord(JsonRecord[Exclude]):
    """Two links whose collisions are excluded: all of them, or those of some pairs of colliders.

    link_a: the first link, in the order of the links.
    link_b: the second link.
    reason: Adjacent: a joint or a rigid connection between them; Always: they touch in every pose; Source:
        the source says so; User: the configuration does.
    depth: the depth by which the colliders that do not collide overlap at `home` [m].
    geoms: the pairs of colliders that do not collide, by their numbers; empty for all pairs.
    """

    link_a: LinkName
    link_b: LinkName
    reason: ExcludeReason
    depth: SixDigits
    geoms: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class TouchRecord(JsonRecord[Touch]):
    """Two links that may collide, and touch at `home`.

    link_a: the first link, in the order of the links.
    link_b: the second link.
    depth: the depth by which they overlap at `home` [m].
    """

    link_a: LinkName
    link_b: LinkName
    depth: SixDigits
