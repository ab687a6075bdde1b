"""The engines that files are made for: what each takes of a model, in one table, and what follows from it.

- diagnostic: Reports what a build replaces for its targets (I-TARGET).
- engines: Lists the engines that a build can be made for, and combines the limits of their shapes.
- mujoco_readers: Lists what MuJoCo, MJX and MuJoCo Warp read of our files: their rows of the table of
  readers.
- options: Replaces options and actuators that targets do not accept by others that move the robot in the same
  way.
- readers: Lists, in one table, what other programs read of our files, and what they do with the rest.
- row: Defines a row of the table of readers.
- section: Defines the configuration of the targets: the engines whose limits the files keep.
- things: Finds the things in a robot that some readers drop, by the table of readers.
- versions: Lists the elements and attributes of MJCF that a version of MuJoCo added or removed.
"""
