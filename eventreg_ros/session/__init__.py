# SPDX-License-Identifier: Apache-2.0
"""One run: domain, processes, the client of the nodes, the result; prints nothing."""
