# SPDX-License-Identifier: Apache-2.0
"""The reference: the plant driven by +v alone, undisturbed; publishes y_r (sys.reference)."""

from __future__ import annotations

import sys

from .block import BlockNode
from .ros import run_node


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(lambda: BlockNode('reference'))


if __name__ == '__main__':
    sys.exit(main())
