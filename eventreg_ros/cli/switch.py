# SPDX-License-Identifier: Apache-2.0
"""What ``eventreg activate`` and ``eventreg deactivate`` share."""

from __future__ import annotations

import argparse

from ..scenario.interventions import Intervention
from ..session.intervene import intervene
from ..simulation.turns import Action


def add_node(parser: argparse.ArgumentParser) -> None:
    """Add NODE."""
    parser.add_argument('node', metavar='NODE', help='the name of the node: controller, say')


def switch(node: str, action: Action) -> int:
    """Switch ``node`` on or off, say so, and return 0."""
    run = intervene(Intervention(f'{node}:{action}', 0.0, node.strip('/'), action))
    print(f'{node} is {"active" if action == "activate" else "inactive"} in {run}')
    return 0
