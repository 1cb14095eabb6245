"""Neuromorphic disturbance rejection for ROS 2: events are rejected, not trajectories."""

__version__ = '0.1.0'
