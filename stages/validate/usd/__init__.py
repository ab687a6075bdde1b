"""Checks a USD, which usd-core reads.

- actuators: Compares the actuators of a USD, in MuJoCo's own schema, with the robot's.
- driving: Compares the joints of a USD with the robot's: resistance, start, drives and relations.
- look_reader: Reads the materials of a USD, which give a shape its look and its friction.
- looks: Compares the materials of a USD's shapes (colour, opacity, image, friction) with the robot's.
- model: Compares a USD's units, placement, shapes and collisions with the robot's.
- place_reader: Reads the frames and the cameras on the bodies of a USD, in metres and radians.
- places: Compares the frames and cameras of a USD with the robot's.
- prim_reader: Finds errors of a USD's prims that do not depend on the robot.
- reader: Reads the bodies and joints of a USD, with lengths in metres and angles in radians.
- shape_reader: Reads the visual shapes and colliders of a USD's bodies, in metres.
"""
