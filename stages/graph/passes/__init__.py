"""Passes from one mechanism or robot to the next: names, masses, limits, relations, added links.

- actuation: The transmissions, controls and actuators of the source, under the present names and in the
  present values of the joints.
- added_links: Links and frames that CAD does not have: a payload, a foot under the base, a tool's tip.
- keyframes: Poses that the key `keyframes` and the source name, and whether `home` closes the loops.
- link_mass: Mass and inertia of links: the user's values, and whether a solid can have them.
- mjcf_extras: What only an MJCF has, on the robot's present links and joints.
- mobility: The mobility of a mechanism: its coordinates less the conditions of relations and loops, by rank.
- recount_actuators: A source's actuators on dofs whose values are counted anew: the same forces, in the new
  values.
- relation_dofs: Finds the dofs that a relation joins, and its factor: as drawn, or as the user configures it.
- relations: Relations between dofs: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.
- rename: Renames links and joints as the user wants (key `names`).
- semantics: What the source's SRDF says, by the robot's own names.
- source_keyframes: Keyframes of the source, in the present values of the joints, with what a file rounds made
  exact.
- total_mass: The mass of the whole robot, as a scale shows it: what is estimated is scaled to it.
- zero_pose: How q is counted: from which value of the mate, and in which direction.
"""
