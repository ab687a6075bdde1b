"""From one mechanism or robot to the next: names, masses, limits, relations, links of the user's own."""
