"""Passes from one mechanism or robot to the next: names, masses, limits, relations, added links.

- actuation: Carries over the source's transmissions, controls and actuators, with the robot's names and joint
  values.
- added_links: Adds links and frames that CAD does not have: a payload, a foot under the base, a tool's tip.
- keyframes: Adds the keyframes of the source and of the key `keyframes` to a robot, and checks that loops
  close.
- link_mass: Gives links the user's masses and inertias, and checks that a solid can have them.
- mjcf_extras: Places the extras of an MJCF on the robot's links and joints.
- mobility: Computes the mobility of a mechanism: the number of its coordinates less the rank of the
  conditions of its relations and loops.
- recount_actuators: Converts actuators to dofs whose values have another zero or sign, so that the forces
  stay the same.
- relation_dofs: Finds the dofs that a relation joins, and its factor: as in CAD, or as the user configures
  it.
- relations: Adds relations between dofs: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.
- rename: Renames links and joints as the user wants (key `names`).
- semantics: Carries over the content of the source's SRDF, with the robot's names.
- source_keyframes: Converts the source's keyframes to the robot's joint values, and makes rounded values
  exact.
- total_mass: Scales the estimated masses so that the whole robot has the mass that a scale shows.
- zero_pose: Sets the zero and the direction of each joint value q relative to the value of its mate. q = 0 is
  the pose in which the mates' frames coincide, or with `zero: saved` the saved pose; `joints` may give a dof
  a zero of its own, and invert it: value of the mate = zero + sign · q.
"""
