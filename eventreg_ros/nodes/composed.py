# SPDX-License-Identifier: Apache-2.0
"""Several nodes in one process and one executor: the same classes and bits, less transport."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from typing import Any

from rclpy.utilities import remove_ros_args

from ..models.roles import ROLES
from ..scenario.names import KINDS, kind_of
from .block import BlockNode
from .clock import ClockNode
from .link import LinkNode
from .managed import ManagedNode
from .recorder import Recorder
from .ros import run_nodes
from .spike_monitor import SpikeMonitor
from .stimulus import StimulusNode
from .topics import SHARED

CLASSES: dict[str, type[ManagedNode]] = {
    'stimulus': StimulusNode,
    'spike_monitor': SpikeMonitor,
    'recorder': Recorder,
    'clock': ClockNode,
    'link': LinkNode,
}


def make(node: str, **kwargs: Any) -> ManagedNode:
    """Create the node that is called ``node``, which may have a suffix and a namespace."""
    namespace, _, name = node.rpartition('/')
    kind = kind_of(name)
    assert kind is not None, node
    rules = [f'__node:={name}'] if name != kind else []
    if namespace:
        rules += [f'__ns:=/{namespace}', *SHARED]
    if rules:
        arguments = [word for rule in rules for word in ('-r', rule)]
        kwargs['cli_args'] = ['--ros-args', *arguments, *kwargs.get('cli_args', ())]
    return BlockNode(kind, **kwargs) if kind in ROLES else CLASSES[kind](**kwargs)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the nodes named on the command line: python -m eventreg_ros.nodes.composed plant ..."""
    argv = list(sys.argv if argv is None else argv)
    kinds = remove_ros_args(argv)[1:]
    if not kinds or None in map(kind_of, kinds):
        print(f'composed: name nodes among {", ".join(KINDS)}, got {kinds}', file=sys.stderr)
        return 2
    return run_nodes([partial(make, kind) for kind in kinds], argv)


if __name__ == '__main__':
    sys.exit(main())
