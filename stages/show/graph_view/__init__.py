"""The robot as people read it: an outline, tables, and a picture.

- boxes: The boxes of the picture: the lines of a link and of the joint to its parent, and their size.
- canvas: A picture in SVG: text, boxes and lines on a sheet with a ground of its own.
- labels: Texts about a robot for people: shortened names, and values in degrees, millimetres and kilograms.
- layout: Where the nodes of a tree go, level by level, so that none overlap.
- outline: The kinematic tree as text, a line for each link and further dof.
- picture: The kinematic graph as a picture: links as boxes, joints as edges from left to right.
- symbols: The symbols of the picture: one for each type of joint, and the legend that explains them.
- tables: The robot as tables of texts, for a page that knows no robotics.
- views: The views of a robot: files of the graph stage beside its value.
"""
