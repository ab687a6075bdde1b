"""Finds the quantities of a compiled robot that may vary, with the origins of their values."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from linkwright.stages.export.actuators.motors import kinds_of
from linkwright.stages.export.mjcf.loops import Closures
from linkwright.stages.export.provenance import provenance
from linkwright.stages.export.variants.shares import SHARE_BY_ORIGIN
from linkwright.stages.formats.written import Written
from linkwright.stages.mujoco.names import OBJ, actuator_count, body_index, name_of
from linkwright.stages.mujoco.parameters import Entry, actuator_parameters, joint_parameters
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.robot import Dof, Link

MAJORITY_SHARE = 0.5
"""Share of a link's mass above which parts decide the origin of its mass properties."""


@dataclass(frozen=True, slots=True)
class VariedQuantity:
    """A quantity of the robot that may vary."""

    key: str
    """Its full name, such as `links.<link>.mass`."""

    origin: str
    """Where its value comes from: a key of `SHARE_BY_ORIGIN`."""

    entries: tuple[Entry, ...] = ()
    """The numbers of the model that it scales, all by one factor; empty for a mass property."""

    bodies: tuple[int, ...] = ()
    """The indices of the bodies whose mass property it is; empty for other quantities."""

    @property
    def name(self) -> str:
        """Returns the last part of the key."""
        return self.key.rpartition(".")[2]


def quantities(model: Any, written: Written) -> list[VariedQuantity]:
    """Returns the quantities of the links, joints and actuators in the MJCF, in its order, including those
    that the user's own XML adds."""
    return [
        *_link_quantities(model, written),
        *_joint_quantities(model, written),
        *_actuator_quantities(model, written),
    ]


def _link_quantities(model: Any, written: Written) -> Iterator[VariedQuantity]:
    links = {link.name: link for link in written.as_mjcf.robot.links}
    friction_origins = _friction_origins(written)
    link_of_carrier = {carrier.name: carrier.carried for carrier in Closures(written.as_mjcf.robot).carriers}
    carriers_by_link: dict[str, list[int]] = {}
    for carrier, link in link_of_carrier.items():
        carriers_by_link.setdefault(link, []).append(body_index(model, carrier))
    for body in range(1, model.nbody):
        name = name_of(model, OBJ.mjOBJ_BODY, body)
        if not name or name in link_of_carrier:
            continue
        if model.body_mass[body] > 0:
            origin = _mass_origin(links.get(name))
            # The bodies that carry the joints of loops have shares of the link's mass.
            bodies = (body, *carriers_by_link.get(name, ()))
            yield VariedQuantity(f"links.{name}.mass", origin, bodies=bodies)
            yield VariedQuantity(f"links.{name}.com", origin, bodies=(body,))
            yield VariedQuantity(f"links.{name}.inertia", origin, bodies=(body,))
        first = int(model.body_geomadr[body])
        geoms = range(first, first + int(model.body_geomnum[body]))
        colliding = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
        if colliding:
            entries = tuple(("geom_friction", (geom, k)) for geom in colliding for k in range(3))
            yield VariedQuantity(f"links.{name}.friction", friction_origins.get(name, "unset"), entries)


def _mass_origin(link: Link | None) -> str:
    """Returns the origin of most of a link's mass; "given" for a link that only the user's own XML has."""
    if link is None or link.given is not None:
        return "given"
    estimated = sum(part.inertial.mass for part in link.parts if part.estimated)
    return "estimated" if estimated > MAJORITY_SHARE * link.inertial.mass else "source"


def _friction_origins(written: Written) -> dict[str, str]:
    """Returns the origin of each link's friction, without links that have MuJoCo's default."""
    origins = {}
    for shape in written.mjcf_shapes.shapes:
        contact, source = shape.contact, shape.form.contact
        if contact is not None and contact.friction is not None:
            origins[shape.link] = "given"
        elif source is not None and source.friction is not None:
            origins.setdefault(shape.link, "source")
    return origins


def _joint_quantities(model: Any, written: Written) -> Iterator[VariedQuantity]:
    robot = written.robot
    dofs = {dof.name: dof for dof in [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]}
    estimated = {armature.dof for armature in written.actuation.armatures}
    for joint in range(model.njnt):
        name = name_of(model, OBJ.mjOBJ_JOINT, joint)
        if not name:
            continue
        dof = dofs.get(name)
        origins = {} if dof is None else provenance(dof, name in estimated, written.actuation.supplied)
        origins["stiffness"] = _stiffness_origin(dof)
        for quantity, entries in joint_parameters(model, joint):
            yield VariedQuantity(
                f"joints.{name}.{quantity}", _least_certain(origins.get(quantity, "given")), entries
            )


def _stiffness_origin(dof: Dof | None) -> str:
    """Returns the origin of a joint's stiffness; "given" for a joint that only the user's own XML has."""
    if dof is None:
        return "given"
    return "source" if dof.spring is not None else "unset"


def _actuator_quantities(model: Any, written: Written) -> Iterator[VariedQuantity]:
    actuators = {actuator.name: actuator for actuator in written.actuation.actuators}
    source_names = {source_actuator.name for source_actuator in written.robot.actuators}
    for index in range(actuator_count(model)):
        name = name_of(model, OBJ.mjOBJ_ACTUATOR, index)
        if not name:
            continue
        actuator = actuators.get(name)
        is_of_source = name in source_names and actuator is not None and not actuator.motor
        default = "source" if is_of_source else "given"
        for quantity, entries in actuator_parameters(model, index):
            origin = _parameter_origin(actuator, quantity) or default
            yield VariedQuantity(f"actuators.{name}.{quantity}", origin, entries)


def _parameter_origin(actuator: Actuator | None, name: str) -> str:
    """Returns the origin of an actuator's parameter; "" if the actuator does not have it."""
    if actuator is None:
        return ""
    if name in actuator.estimated:
        return "estimated"
    # The configuration calls the range of the force as MJCF does.
    source = dict(actuator.sources).get("forcerange" if name == "force" else name)
    return "" if source is None else _least_certain(source)


def _least_certain(origin: str) -> str:
    """Returns an origin as a key of `SHARE_BY_ORIGIN`. If it names several values of a motor, the least
    certain counts; a text that names no kind of value counts as "given"."""
    kinds = [origin] if origin in SHARE_BY_ORIGIN else kinds_of(origin)
    return max(kinds, key=lambda kind: SHARE_BY_ORIGIN[kind], default="given")
