"""What is known of a USD of a robot without reading it: names, and where its joints are at zero."""
