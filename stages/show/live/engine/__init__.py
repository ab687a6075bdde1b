"""Makes the copy of the model that the page's own MuJoCo reads."""
