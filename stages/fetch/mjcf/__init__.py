"""An MJCF on this computer, as MuJoCo compiles it, as a bundle."""
