"""robot.json: its schema, by which it is written and read.

- codec: records as JSON and back
- values: numbers, values and poses
- links, joints, driving, shapes, scene, mjcf, files: records of these
- robot: the whole
"""

FORMAT, VERSION = "linkwright-robot", 1
