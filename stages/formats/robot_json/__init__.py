"""robot.json: its schema, by which it is written and read.

- codec: Converts records to JSON and back: the class of a record is the schema of its table.
- driving: Defines the actuators and sensors of robot.json.
- files: Defines the tables of robot.json about the robot's other files: their order, names and packages.
- joints: Defines the joints, loops, relations and frames of robot.json.
- links: Defines the links of robot.json: mass properties, CAD's parts, and the user's own shapes.
- mjcf: Defines the extras of an MJCF in robot.json.
- robot: Defines the whole of a robot.json: the model in no simulator's format, with its origins in CAD.
- scene: Defines the scene, the keyframes and the SRDF of a robot.json.
- shapes: Defines the shapes of robot.json, without the files of the meshes, and their contacts.
- values: Converts numbers, values and poses in robot.json.
"""

FORMAT, VERSION = "linkwright-robot", 1
