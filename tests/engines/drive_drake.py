"""URDF, SDF and MJCF in Drake."""

import re
from importlib.metadata import version

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import BodyIndex, JointActuatorIndex, JointIndex
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from told import run, tree


class Drake:
    def __init__(self, path, root):
        # Mimic needs a plant in steps of time, colliders a scene.
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=0.001, discrete_contact_approximation="sap")
        plant, _ = AddMultibodyPlant(config, builder)
        self.path, self.root = path, root
        self.plant = self._filled(plant, path)
        self.context = self.plant.GetMyContextFromRoot(builder.Build().CreateDefaultContext())

    def _filled(self, plant, path):
        Parser(plant).AddModels(str(path))
        root = plant.GetBodyByName(self.root)
        if not self._held(plant, root):
            plant.WeldFrames(plant.world_frame(), root.body_frame())
        plant.Finalize()
        return plant

    def _held(self, plant, root):
        """Whether a joint of the file holds the root."""
        every = (plant.get_joint(JointIndex(index)) for index in range(plant.num_joints()))
        return any(joint.child_body().name() == root.name() for joint in every)

    def masses(self):
        bodies = (self.plant.get_body(BodyIndex(index)) for index in range(1, self.plant.num_bodies()))
        return {body.name(): body.default_mass() for body in bodies}

    def _at(self, plant, values):
        places = plant.GetDefaultPositions()
        for name, value in values.items():
            places[plant.GetJointByName(name).position_start()] = value
        return places

    def poses(self, values):
        self.plant.SetPositions(self.context, self._at(self.plant, values))
        bodies = (self.plant.get_body(BodyIndex(index)) for index in range(1, self.plant.num_bodies()))
        pose = self.plant.EvalBodyPoseInWorld
        return {body.name(): pose(self.context, body).GetAsMatrix4() for body in bodies}

    def motion(self, values, seconds, samples):
        """The motion of a plant in continuous time, which has no colliders and limits, and refuses mimic."""
        bare = self.path.with_name(f"bare_{self.path.name}")
        bare.write_text(re.sub("<mimic [^>]*/>", "", self.path.read_text()))
        plant = self._filled(MultibodyPlant(0.0), bare)
        simulator = Simulator(plant)
        ResetIntegratorFromFlags(simulator, "runge_kutta3", 0.01)
        simulator.get_mutable_integrator().set_target_accuracy(1e-8)
        context = simulator.get_mutable_context()
        plant.SetPositions(context, self._at(plant, values))
        for index in range(plant.num_actuators()):
            # An MJCF's armature.
            plant.get_joint_actuator(JointActuatorIndex(index)).SetRotorInertia(context, 0.0)
        if plant.num_actuators():
            plant.get_actuation_input_port().FixValue(context, np.zeros(plant.num_actuators()))
        made = []
        for sample in range(1, samples + 1):
            simulator.AdvanceTo(seconds * sample / samples)
            found = plant.GetPositions(context)
            made.append({name: found[plant.GetJointByName(name).position_start()] for name in values})
        return made


def main(folder, reference, rows):
    root = next(iter(reference["urdf"]["masses"]))
    for kind, told in (("urdf", "urdf"), ("sdf", "urdf"), ("mjcf", "mjcf")):
        if kind in reference["files"]:
            path = folder / reference["files"][kind]
            tree(lambda path=path: Drake(path, root), kind, reference[told], rows, frames=kind == "urdf")
    return version("drake")


if __name__ == "__main__":
    run(main)
