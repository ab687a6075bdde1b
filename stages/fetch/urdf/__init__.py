"""A URDF on this computer, and the meshes that it names, as a bundle.

- expand: Expands trusted xacro files with ROS's own `xacro` package, in a guest process.
- expand_guest: Guest process that expands a xacro file with ROS's own `xacro` package.
- gather: A URDF and its meshes as a bundle.
- mesh_paths: Resolves the names of meshes in a URDF to files.
- plain: Checks that a URDF is not a xacro file under another name.
- ros_packages: Finds the folders of ROS packages.
- section: Configuration of the source `urdf`.
- source: The source `urdf`: a URDF, or a xacro file that makes one, and the meshes that it names.
- srdf_file: Finds the SRDF of a URDF: the file that `source.srdf` names, else one of its name in the usual
  places.
- survey: Lists the files of a robot without reading the robot: its text and the files that it names.
- text: The text of a robot's file, as plain URDF that reveals nothing of this computer.
"""
