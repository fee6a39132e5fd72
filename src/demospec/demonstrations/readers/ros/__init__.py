"""Bags of ROS 2 and ROS 1 and MCAP files: pose, path, transform and joint topics as paths."""
