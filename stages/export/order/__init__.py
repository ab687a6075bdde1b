"""The order of joints, actuators and sensors, as MuJoCo's arrays and the readers of a URDF have it."""
