# SPDX-License-Identifier: Apache-2.0
"""How it runs in ROS; nothing else imports rclpy."""
