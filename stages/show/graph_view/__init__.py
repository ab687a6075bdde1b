"""Draws the views of the value `Robot` for people: an outline, tables, and a picture.

- boxes: Lays out the boxes of the picture: the lines of a link and of the joint to its parent, and their
  size.
- canvas: Draws text, boxes and lines in SVG, on a sheet with a background.
- draw_views: Draws all views of a robot.
- labels: Writes texts about a robot: shortened names, and values in degrees, millimetres and kilograms.
- layout: Places the nodes of a tree, level by level, without overlap.
- outline: Writes the kinematic tree as text, with a line for each link and each further dof.
- picture: Draws the kinematic graph: links as boxes, joints as edges from left to right.
- symbols: Draws the symbols of the picture, one for each type of joint, and the legend that explains them.
- tables: Describes the robot in tables of texts, which a page shows as they are.
- views: Names the views of a robot: files of the graph stage beside its value.
"""
