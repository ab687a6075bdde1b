"""Readers: each says in one way what a file of its format has, which `stages.validate.same` compares.

robot       what a reader gives: `ReadRobot`
compiled    an MJCF or URDF that MuJoCo compiled; mjcf and urdf: what is particular to each
sdf         an SDF; usd a USD, by usd-core: what only these have is in the rooms of these names
"""
