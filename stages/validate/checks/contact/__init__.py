"""Checks of shapes and of their contact.

- bare_links: Each link that is seen collides, unless that was asked for.
- colliders: The colliders of each link are where its visual shapes are, and of their size.
- contact_filter: Which pairs of shapes may collide is what the robot says: in MuJoCo's own rules, whatever
  the pose.
- contact_properties: Each collider touches as the robot says: by its friction, stiffness, margin and
  priority, and by all of its hull.
- false_contact: The robot's colliders touch each other where what is seen of them does, over poses within the
  limits.
- reach: Each joint moves over its whole range, alone, without two links running into each other.
- self_contact: At `home` nothing of the robot touches itself that is excluded from contact, or that was not
  reported.
- shapes: Each body has the shapes of its links: as many, where they shall be, and of their size.
- start: A simulation starts with nothing inside something else: at `home`, and at qpos0, where a reset leads
  to.
"""
