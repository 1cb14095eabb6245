"""A plant that is no neuron, behind the controller of eventreg_ros."""
