"""How ready a robot is for simulation: 35 points, a score, what would raise it. It never fails a build.

- bodies: The points about bodies and their shapes.
- evidence: The points that other checks of the run prove, and those about the files as a whole.
- finished: A finished robot as the points of sim-readiness look at it: its folder, its XML, its model.
- joints: The points about joints, what drives them, and the first pose.
- points: The 35 points of sim-readiness, by number: what a model of the grade of MuJoCo Menagerie meets.
- score: The score of a finished robot, as a check with a table of its points.
- text: The points that the text of the files shows.
"""
