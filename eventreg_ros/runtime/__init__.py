"""How samples come: inputs, tick grid, duration histogram; no rclpy."""
