"""Scores how ready a robot is for simulation, by 35 points, with hints that would raise the score. It never
fails a build.

- bodies: Judges the points about bodies and their shapes.
- evidence: Judges the points that other checks of the run prove, and the points about the files as a whole.
- finished: Defines the finished robot by which points of sim-readiness are judged: its folder, XML and model.
- joints: Judges the points about joints, their drives, and the first pose.
- points: Lists the 35 points of sim-readiness, which models of the quality of MuJoCo Menagerie meet.
- score: Scores the readiness of a finished robot, as a check with a table of the points.
- text: Judges the points about the text of the files.
"""
