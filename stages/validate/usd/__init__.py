"""The checks of a USD, read by usd-core.

- driving: What the joints of a USD resist, where they start, what drives them and what they follow, against
  the robot's.
- look_reader: Reads the materials of a USD: what a shape looks like, and how slippery it is.
- looks: What the shapes of a USD look like, and how slippery they are, against the robot's.
- model: What a USD says of its units, of where the robot stands, of its shapes and of what collides.
- place_reader: Reads the frames and the cameras on the bodies of a USD, in metres and radians.
- places: The frames and cameras of a USD against the robot's.
- prim_reader: What is wrong with the prims of a USD whatever robot they are: names of what is not there,
  quaternions that are no rotations, and extents that are not those of the points.
- reader: Reads the bodies and joints of a USD, with lengths in metres and angles in radians.
- shape_reader: Reads what the bodies of a USD look like and collide with, in metres.
"""
