# SPDX-License-Identifier: Apache-2.0
"""What people type: one file per verb."""
