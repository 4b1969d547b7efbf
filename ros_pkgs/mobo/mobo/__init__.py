"""The ROS 2 nodes of mobo: thin shells around mobo_core."""
