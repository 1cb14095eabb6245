"""How it runs in ROS; nothing else imports rclpy."""
