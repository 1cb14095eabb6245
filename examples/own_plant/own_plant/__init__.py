# SPDX-License-Identifier: Apache-2.0
"""A plant that is no neuron, behind the controller of eventreg_ros."""
