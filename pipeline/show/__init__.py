"""What `stages.show` makes of a build, kept in the cache: the live view of its page, and its picture."""
