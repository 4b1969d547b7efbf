"""The samplers: each draws the next arm from the trials it may see."""
