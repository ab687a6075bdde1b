"""Checks of shapes and of their contact.

- bare_links: Checks that each visible link has a collider, unless the user asked for none.
- colliders: Checks that the colliders of each link are where its visual shapes are, and of their size.
- contact_filter: Checks that MuJoCo's rules let the same pairs of shapes collide as the robot's, whatever the
  pose.
- contact_properties: Checks that each collider has the robot's friction, stiffness, margin and priority, and
  its whole hull.
- false_contact: Checks that the robot's colliders touch each other where the visual shapes do, at poses
  within limits.
- reach: Checks that no two links collide while a single joint moves over its whole range.
- self_contact: Checks that no excluded links touch at `home`, and no links whose contact was not reported.
- shapes: Checks that each body has the shapes of its links: their number, places and sizes.
- start: Checks that nothing is inside something else when a simulation starts: at `home`, or at qpos0 after a
  reset.
"""
