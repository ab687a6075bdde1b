"""The reader of MJCF files, as MuJoCo compiled them: bodies, joints and equalities become a mechanism."""
