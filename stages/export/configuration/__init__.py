"""Configuration of what is exported beside the robot's mechanism.

- actuator_section: What drives a dof.
- element_section: XML elements and attributes of the user's own.
- format_section: What the configurations of all formats have.
- motor_section: A motor, and where its values come from.
- mujoco_section: MuJoCo's settings.
- scene_section: The ground, and the world around the robot.
- sensor_section: What measures the robot.
"""
