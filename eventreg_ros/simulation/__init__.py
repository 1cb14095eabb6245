# SPDX-License-Identifier: Apache-2.0
"""How time advances: the step, the hold, the block, the stimulus, and the closed loops."""
