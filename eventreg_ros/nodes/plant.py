# SPDX-License-Identifier: Apache-2.0
"""The plant: an excitable neuron driven by +w, +v and -u; publishes y (eq. s.E)."""

from __future__ import annotations

import sys

from .block import BlockNode
from .ros import run_node


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(lambda: BlockNode('plant'))


if __name__ == '__main__':
    sys.exit(main())
