"""What happened: studies as MCAP bags, the way rosbag2 lays them out. No ROS is needed to read or write."""
