"""Makes a bundle of an MJCF on this computer, as MuJoCo compiles it."""
