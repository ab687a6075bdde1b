"""Makes a bundle of a URDF on this computer, and of the meshes that it names.

- expand: Expands trusted xacro files with ROS's own `xacro` package, in a guest process.
- expand_guest: Guest process that expands a xacro file with ROS's own `xacro` package.
- gather: Makes a bundle of a URDF and its meshes.
- mesh_paths: Resolves the names of meshes in a URDF to files.
- plain: Checks that a URDF is not a xacro file under another name.
- ros_packages: Finds the folders of ROS packages.
- section: Configuration of the source `urdf`.
- source: Defines the source `urdf`: a URDF, or a xacro file that makes one, and the meshes that it names.
- srdf_file: Finds the SRDF of a URDF: the file that `source.srdf` names, or else a file of the robot's name
  in the usual places.
- survey: Lists the files of a robot without reading the robot: its text and the files that it names.
- text: Reads the text of a robot's file, as plain URDF that reveals nothing of this computer.
"""
