"""A local Onshape: documents built in Python, and an HTTP server that speaks Onshape's API.

It shares no code with what it tests. `document` and `assembly` describe parts and assemblies; `mates`,
`edges`, `copies`, `kinematics` and `truth` know the truth about them, `settings` and `variables` are
what can be set in them, `definition` and `replies` give them Onshape's shapes, `server` serves them,
`bundle` packs them, `sample` is the robot that ships with the product, and `random_document` draws
documents for property tests.
"""
