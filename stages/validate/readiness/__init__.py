"""How ready a robot is for simulation: 35 points, a score, what would raise it. It never fails a build."""
