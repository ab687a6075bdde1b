"""Analyses contact of the robot with itself: which links do not collide, and which touch at `home`.

- analysis: Finds the pairs of links that do not collide, and the other pairs that touch at `home`.
- by_source: Finds the colliders that do not collide in an MJCF source: by the bits of its geoms, by its
  excludes and pairs, and by MuJoCo's rule for a body and its parent.
- colliders: Computes with MuJoCo how deep the colliders of two links overlap, at any pose.
- excluded_pairs: Collects the pairs of links that do not collide: pairs that the configuration names, and all
  pairs that colliders by contact need not keep apart.
- narrow: Finds the fewest shapes of two links that must not collide if the links touch in every pose.
"""
