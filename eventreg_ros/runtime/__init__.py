# SPDX-License-Identifier: Apache-2.0
"""How samples come: inputs, tick grid, duration histogram; no rclpy."""
