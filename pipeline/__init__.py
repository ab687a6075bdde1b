"""How a build runs: composing, caching, reporting. Knows no robotics."""
