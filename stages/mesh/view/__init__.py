"""Pictures of links: what is seen of them, beside what they collide with."""
