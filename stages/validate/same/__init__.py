"""The comparers: whether what a reader of any format read is the robot as it was written.

masses       mass, centre of mass and inertia of each link
motion       where links and frames are; differences: which elements are why
joints       types and numbers of joints
relations    what follows what
loops        what closes loops
solids       shapes
"""
