"""The colliders of a link: one module for each way to make them."""
