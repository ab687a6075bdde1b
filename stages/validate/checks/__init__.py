"""The table of contents of all checks of a build, each list in the order of the report.

- `ENGINES`: each compiles the models that it reads.
- `TEXT_CHECKS`: checks of a model's text, before an engine reads it.
- `MODEL_CHECKS`: checks of a compiled model, each a module of this room.
- `FORMAT_CHECKS`: checks of files that no engine reads.
"""

from linkwright.stages.validate.checks.contact import (
    bare_links,
    colliders,
    contact_filter,
    contact_properties,
    false_contact,
    reach,
    self_contact,
    shapes,
    start,
)
from linkwright.stages.validate.checks.mechanism import (
    closed_at_start,
    hinge_axes,
    inertial,
    joints,
    links_and_joints,
    loops,
    mass_ratio,
    masses,
    motion,
    parity,
    placement,
    poses,
    relations,
    urdf_shapes,
)
from linkwright.stages.validate.checks.simulation import (
    control_noise,
    energy,
    gravity_compensation,
    rest,
    time_step,
    torque,
    trial,
    variants,
)
from linkwright.stages.validate.checks.world import (
    actuators,
    keyframes,
    options,
    scene,
    sensors,
    source_elements,
    surroundings,
)
from linkwright.stages.validate.engines import ENGINES
from linkwright.stages.validate.files import TEXT_CHECKS
from linkwright.stages.validate.format_checks import FORMAT_CHECKS
from linkwright.stages.validate.rows import ModelCheck

__all__ = ["ENGINES", "FORMAT_CHECKS", "MODEL_CHECKS", "TEXT_CHECKS"]

MODEL_CHECKS = (
    ModelCheck("C-LINKS", "links and joints", links_and_joints.check, ("mjcf", "urdf", "scene")),
    ModelCheck("C-CLOSED", "closed at start", closed_at_start.check, ("mjcf", "urdf")),
    ModelCheck("C-MASS", "masses", masses.check, ("mjcf", "urdf")),
    ModelCheck("C-POSE", "poses", poses.check, ("mjcf", "urdf")),
    ModelCheck("C-PLACE", "placement", placement.check, ("mjcf",)),
    ModelCheck("C-JOINT", "joints", joints.check, ("mjcf", "urdf")),
    ModelCheck("C-MOTION", "motion", motion.check, ("mjcf", "urdf")),
    ModelCheck("C-PARITY", "parity", parity.check, ("mjcf", "urdf")),
    ModelCheck("C-RELATION", "relations", relations.check, ("mjcf", "urdf")),
    ModelCheck("C-LOOP", "loops", loops.check, ("mjcf", "urdf")),
    ModelCheck("C-KEYFRAME", "keyframes", keyframes.check, ("mjcf", "scene")),
    ModelCheck("C-ACTUATOR", "actuators", actuators.check, ("mjcf", "scene")),
    ModelCheck("C-ACTUATOR", "gravity compensation", gravity_compensation.check, ("mjcf",)),
    ModelCheck("C-SENSOR", "sensors", sensors.check, ("mjcf",)),
    ModelCheck("C-SOURCE", "source elements", source_elements.check, ("mjcf", "scene")),
    ModelCheck("C-SELF-CONTACT", "self contact", self_contact.check, ("mjcf",)),
    ModelCheck("C-FALSE-CONTACT", "false contact", false_contact.check, ("mjcf",)),
    ModelCheck("C-EXCLUDE", "contact filter", contact_filter.check, ("mjcf",)),
    ModelCheck("C-CONTACT", "contact properties", contact_properties.check, ("mjcf",)),
    ModelCheck("C-SCENE", "scene", scene.check, ("scene",)),
    ModelCheck("C-SCENE", "surroundings", surroundings.check, ("scene",)),
    ModelCheck("C-OPTION", "options", options.check, ("simulated",)),
    ModelCheck("C-INERTIAL", "inertial", inertial.check, ("simulated",)),
    ModelCheck("C-MASS-RATIO", "mass ratio", mass_ratio.check, ("simulated",)),
    ModelCheck("C-START", "start", start.check, ("simulated",)),
    ModelCheck("C-TRIAL", "trial", trial.check, ("simulated",)),
    ModelCheck("C-REST", "rest", rest.check, ("simulated",)),
    ModelCheck("C-NOISE", "control noise", control_noise.check, ("simulated",)),
    ModelCheck("C-TIME-STEP", "time step", time_step.check, ("simulated",)),
    ModelCheck("C-ENERGY", "energy", energy.check, ("simulated",)),
    ModelCheck("C-TORQUE", "torque", torque.check, ("simulated",)),
    ModelCheck("C-VARIANTS", "variants", variants.check, ("simulated",)),
    ModelCheck("C-SHAPE", "shapes", shapes.check, ("mjcf",)),
    ModelCheck("C-COLLIDER", "colliders", colliders.check, ("mjcf",)),
    ModelCheck("C-NO-COLLIDER", "bare links", bare_links.check, ("mjcf",)),
    ModelCheck("C-AXIS", "hinge axes", hinge_axes.check, ("mjcf",)),
    ModelCheck("C-REACH", "reach", reach.check, ("mjcf",)),
    ModelCheck("C-SHAPE", "urdf shapes", urdf_shapes.check, ("urdf",)),
)
"""The robot in a scene is the MJCF's, so that results for the MJCF hold for both. If the first check misses a
link or joint, the other checks are skipped, since they look for each by its name."""
