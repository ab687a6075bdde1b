"""An MJCF as a value: the model, its joints, its form, its bounds."""
