"""What the replies of a server hold, and where they are kept."""
