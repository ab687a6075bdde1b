"""Lists the names of all quantities that may vary, before the robot's MJCF is written."""

from linkwright.stages.robot.model.robot import Robot

LINK_QUANTITIES = ("mass", "com", "inertia", "friction")
JOINT_QUANTITIES = ("damping", "friction", "armature", "stiffness", "effort")
ACTUATOR_QUANTITIES = ("kp", "kv", "gain", "force")


def possible_quantities(robot: Robot) -> list[str]:
    """Returns the names of the quantities that may vary. The MJCF lacks those of merged links and of undriven
    dofs."""
    dofs = [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]
    joints = [dof.name for dof in dofs if dof.kind != "free"]
    driven_names = dict.fromkeys([*joints, *(actuator.name for actuator in robot.actuators)])
    quantities = [f"links.{link.name}.{quantity}" for link in robot.links for quantity in LINK_QUANTITIES]
    quantities += [f"joints.{name}.{quantity}" for name in joints for quantity in JOINT_QUANTITIES]
    return quantities + [
        f"actuators.{name}.{quantity}" for name in driven_names for quantity in ACTUATOR_QUANTITIES
    ]
