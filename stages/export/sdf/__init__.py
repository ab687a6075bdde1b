"""SDF: links, joints, frames and sensors of a model for Gazebo, with loops as joints."""
