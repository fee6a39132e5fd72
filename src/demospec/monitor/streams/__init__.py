"""What feeds a monitor and what it writes: lines, recordings, ROS 2; JSON, MCAP, messages."""
