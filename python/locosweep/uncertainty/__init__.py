"""What a robot does when some of its parameters are known only as distributions."""
