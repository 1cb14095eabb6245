"""Beyond the paper: adaptation, observer and prediction, spike coding; pure functions."""
