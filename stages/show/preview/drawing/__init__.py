"""Drawing: light, faces, edges and the studio of the robot's picture.

- creases: Normals of a surface that is smooth where its faces meet at a small angle, and has an edge
  elsewhere.
- faces: Triangles as they are seen: each point in the light that reaches it, as a screen shows it.
- light: Light from many far lamps: a soft key light and a sky; what lies in whose shadow.
- painting: The picture of a robot in a studio: a calm ground that fades into the background, a soft shadow.
- pixels: Pixels: blurred, enlarged and reduced; light as a screen shows it.
- studio: A robot in a studio: of one size whatever its own, among lamps.
- vectors: Vectors (..., 3), many at once, a component at a time: to reduce an axis of three takes several
  times as long.
"""
