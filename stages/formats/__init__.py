"""Text to value and back, without policy: URDF, MJCF, XML, glTF, numbers, units, triangles.

- colours: Colours out of CAD's appearances, which come in several encodings.
- damaged: A file of a format that is damaged.
- described: The robot that a robot.json describes, and all else that its files are checked against.
- numbers: The one formatter of numbers in robot files.
- onshape_configuration: Onshape's text for a configuration: `id=value;id2=value2`, or "default" for none.
- own_xml: XML that a user adds: the language that it is of, and what has a name in a MJCF or URDF.
- png: PNG images: whether bytes are one that readers take, and a PNG of pixels.
- templates: Files from templates: the one place that imports jinja2.
- triangles: The triangles of a part studio in a compact form: fetch stores it, and mesh reads it.
- written: The robot as its files have it: what writers write, readers read back, and checks compare with.
- xml: XML in and out: one place that parses and writes, with entities and the network off.
"""
