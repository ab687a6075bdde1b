"""Elements of an MJCF from a model that MuJoCo compiled: what its XML must say to compile to the same."""
