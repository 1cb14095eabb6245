# SPDX-License-Identifier: Apache-2.0
"""Beyond the paper: adaptation, observer and prediction, spike coding; pure functions."""
