"""Run by the Python of an environment that has Drake: what it makes of a file, as JSON on stdout.

On stdin: {"file": its path, "weld": the link to hold still or null, "joints": names, "values": a list of
{joint: number or quaternion (w, x, y, z)}}. For each of the values: the poses of links in the world, and the
mass matrix of the speeds of these joints, a ball's being its angular velocity in its child's axes.
"""

import json
import sys

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import DiagramBuilder


def main():
    request = json.load(sys.stdin)
    # Mimic needs a plant in steps of time, colliders a scene.
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=0.001, discrete_contact_approximation="sap")
    plant, _ = AddMultibodyPlant(config, builder)
    Parser(plant).AddModels(request["file"])
    if request["weld"] is not None:
        plant.WeldFrames(plant.world_frame(), plant.GetBodyByName(request["weld"]).body_frame())
    plant.Finalize()
    diagram = builder.Build()
    context = plant.GetMyContextFromRoot(diagram.CreateDefaultContext())
    json.dump([answer(plant, context, request["joints"], values) for values in request["values"]], sys.stdout)


def answer(plant, context, joints, values):
    places = plant.GetDefaultPositions()
    turned = np.eye(plant.num_velocities())
    order = []
    for name in joints:
        joint, value = plant.GetJointByName(name), values[name]
        first, begin = joint.position_start(), joint.velocity_start()
        if isinstance(value, list):
            w, x, y, z = value
            rotation = RotationMatrix(quaternion(w, x, y, z))
            places[first : first + 3] = RollPitchYaw(rotation).vector()
            # Drake's speeds are in the axes of the parent.
            turned[begin : begin + 3, begin : begin + 3] = rotation.matrix()
        else:
            places[first] = value
        order += range(begin, begin + joint.num_velocities())
    plant.SetPositions(context, places)
    mass = turned.T @ plant.CalcMassMatrix(context) @ turned
    bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
    poses = {body.name(): plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4().tolist() for body in bodies}
    size = {"positions": plant.num_positions(), "constraints": plant.num_constraints()}
    return {**size, "mass": mass[np.ix_(order, order)].tolist(), "poses": poses}


def quaternion(w, x, y, z):
    from pydrake.common.eigen_geometry import Quaternion

    return Quaternion(w=w, x=x, y=y, z=z)


if __name__ == "__main__":
    main()
