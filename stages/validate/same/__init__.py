"""The comparers: whether what a reader of any format read is the robot as it was written.

found        what a reader gives: `ReadRobot`
masses       mass, centre of mass and inertia of each link
motion       where links and frames are; differences: which elements are why
joints       types and numbers of joints
relations    what follows what
loops        what closes loops
names        links, joints and frames
shapes       what links look like and collide with
"""
