"""Draws the robot's picture: light, faces, edges and the studio.

- creases: Computes vertex normals that are smooth across shallow edges, and keep sharp edges sharp.
- faces: Computes the colours of points on the visible triangles in the light of the lamps.
- light: Lights the robot with many far lamps, a soft key light and a sky, and casts its shadows.
- painting: Paints the robot in a studio: with a soft shadow on a ground that fades into the background.
- pixels: Blurs, enlarges and reduces pixels; converts light for a screen.
- studio: Places a robot in a studio: scaled to a standard size, among lamps.
- vectors: Computes with vectors (..., 3) by component: several times as fast as along the last axis.
"""
