"""MuJoCo: the only room that compiles a model.

compile: from text or a file to a model, or the reason why not; warnings: what MuJoCo says on the way
urdf: a URDF as MuJoCo reads URDFs
includes: the content of included files in the place of each <include>
state: the data of a model at a keyframe; trial: whether a model stays whole and finite while it is simulated
fields, elements, bodies, sensors: elements of an MJCF from a compiled model: what its XML must say
"""
