# SPDX-License-Identifier: Apache-2.0
"""What happened: events, rejection, bags, reports, plots."""
