"""Readers: each says in one way what a file of its format has, which `stages.validate.same` compares.

compiled    the reader of a compiled model
mujoco      what MuJoCo compiled; mjcf and urdf: what is particular to each
sdf         an SDF; usd: a USD, by usd-core: what only these have is in the rooms of these names
run         the checks of a file that no engine reads
"""
