"""robot.json: its schema, by which it is written and read.

- codec: Records as JSON and back: the class of a record is the schema of its table.
- driving: What drives and measures the robot of a robot.json.
- files: What a robot.json says of the robot's other files: their order, their names, and packages of them.
- joints: Joints, loops, relations and frames of robot.json.
- links: Links of robot.json: mass properties, CAD's parts, and the user's own shapes.
- mjcf: What only an MJCF has, in a robot.json.
- robot: The whole of a robot.json: the model in no simulator's format, with its origins in CAD.
- scene: The scene, the keyframes and the SRDF of a robot.json.
- shapes: The shapes of a robot.json, without the files of the meshes, and which of them touch.
- values: Numbers, values and poses in robot.json.
"""

FORMAT, VERSION = "linkwright-robot", 1
