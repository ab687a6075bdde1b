"""MJCF: the robot, and a scene around it, for MuJoCo.

- actuators: Writes the actuators of an MJCF, with the shortcuts of MuJoCo's XML reference, and its sensors.
- bodies: Writes the bodies of an MJCF: links with their joints, inertials, geoms and sites.
- build: Writes the MJCF and its scene.
- extras: Selects the features of an MJCF source that the written MJCF can carry, and reports the others.
- form: Decides the form of a robot's MJCF: which links become part of other bodies, and the source's extras.
- joints: Writes the joints of an MJCF: the dofs between a body and its parent.
- keyframes: Writes keyframes: the named poses of the robot, placed in the scene, and the poses of its other
  objects.
- loops: Writes loop closures in MJCF: sites on both links, equalities between the sites, and carriers.
- model: Writes the MJCF of the robot alone, `<name>.xml` (the scene around it is another file).
- placement: Writes poses as MJCF attributes, and elements at a pose.
- reset: Reports servos that leave qpos0 after a plain reset: MuJoCo then sets each control to 0.
- scene: Writes scene.xml: the robot in a small world with a floor, light and sky, ready for a viewer.
- section: Defines the configuration of the MJCF writer.
- sections: Writes the sections of an MJCF that only come from its source, such as tendons and their
  actuators.
- settings: Formats the values of MuJoCo's settings as attributes.
- writer: Registers the writer of MJCF: the robot, and a scene around it, for MuJoCo.
"""
