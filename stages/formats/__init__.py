"""Converts text to values and back, without policy: URDF, MJCF, XML, glTF, numbers, units, triangles.

- colours: Reads colours from CAD's appearances, which come in several encodings.
- damaged: Defines the error of a damaged file.
- described: Reads the robot that a robot.json describes, and the other values that its files are checked
  against.
- npz: Writes and reads NumPy's npz, byte for byte the same under any version of NumPy and of zlib: stored,
  without times.
- numbers: Formats the numbers in robot files: no other module does.
- onshape_configuration: Encodes Onshape's text for a configuration: `id=value;id2=value2`, or "default" for
  none.
- own_xml: Recognizes XML that a user adds: its language, and the named elements of an MJCF or URDF.
- png: Checks that readers accept a PNG image, and writes pixels as PNG.
- templates: Fills templates, and is the only module that imports jinja2.
- triangles: Reads the header of a part studio's triangles in the compact form.
- variants: `variants.npz`: randomized variants of a robot, as arrays of values for fields of MuJoCo's model.
- written: Holds the robot as its files have it: writers write it, and checks compare files with it.
- xml: Parses and writes XML, with entities and the network off: no other module does.
"""
