# SPDX-License-Identifier: Apache-2.0
"""What was recorded: the reader and the writer of bags."""
