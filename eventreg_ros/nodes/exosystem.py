# SPDX-License-Identifier: Apache-2.0
"""The exosystem: two neurons that inhibit each other; publishes the disturbance w (eq. s.w)."""

from __future__ import annotations

import sys

from .block import BlockNode
from .ros import run_node


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(lambda: BlockNode('exosystem'))


if __name__ == '__main__':
    sys.exit(main())
