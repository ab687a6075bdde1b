"""Contact of the robot with itself: which of its links do not collide, and which touch where it starts.

- analysis: Which pairs of links do not collide: those next to each other, those that the user names, and
  those that touch in every pose, of which only what does so is left out; and which others touch at `home`.
- by_source: Which shapes do not collide by what an MJCF source says: the bits of its geoms, its excludes and
  pairs, and what MuJoCo leaves out by itself.
- colliders: The robot's colliders in MuJoCo: how deep those of two links are in each other, at any pose.
- excluded_pairs: The pairs of links that do not collide: those that the configuration names, and those that
  colliders by contact need not keep apart.
- narrow: Which shapes of two links do not collide, where the links touch in every pose: as few as will do.
"""
