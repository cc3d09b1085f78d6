"""Xacro, the macro language that robot descriptions of ROS are written in, expanded without ROS."""
