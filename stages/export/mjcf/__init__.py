"""MJCF: the robot, and a scene around it, for MuJoCo.

- actuators: MJCF's actuators, by the shortcuts of MuJoCo's XML reference where they have one, and its
  sensors.
- bodies: The bodies of an MJCF: links with their joints, inertials, geoms and sites.
- build: Writes all files of the format, from what the other modules of this room make of the robot.
- extras: What an MJCF source alone has, as far as the MJCF that is written can carry it.
- form: The form of a robot's MJCF, as the configuration wants it.
- joints: MJCF's joints: the dofs between a body and its parent.
- keyframes: Keyframes: the named poses of the robot, each where the scene puts it, and of what lies beside it
  there.
- loops: Loop closures in MJCF: sites on both links, equalities between the sites, and carriers.
- model: MJCF: the robot alone, as `<name>.xml` (the scene around it is another file).
- placement: Poses as MJCF attributes, and elements that have one.
- reset: What a plain reset does to servos: MuJoCo sets each control to 0, whatever qpos0 is, and MJCF has no
  other.
- scene: scene.xml: the robot in a small world, with a floor, light and sky, ready for a viewer.
- section: Configuration of the MJCF writer.
- sections: The sections of an MJCF that its source alone fills: tendons, and what names them.
- settings: Values of MuJoCo's settings as attributes.
- writer: MJCF: the robot, and a scene around it, for MuJoCo.
"""
