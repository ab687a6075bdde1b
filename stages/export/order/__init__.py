"""The order of joints, actuators and sensors in MuJoCo's arrays and for the readers of a URDF."""
