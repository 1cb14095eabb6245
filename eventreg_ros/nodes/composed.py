"""Several nodes in one process and one executor: the same classes and bits, less transport."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from typing import Any

from rclpy.utilities import remove_ros_args

from ..models.roles import ROLES
from ..scenario.parameters import NODES, kind_of
from .block import BlockNode
from .clock import ClockNode
from .link import LinkNode
from .managed import ManagedNode
from .recorder import Recorder
from .ros import run_nodes
from .spike_monitor import SpikeMonitor
from .stimulus import StimulusNode

CLASSES: dict[str, type[ManagedNode]] = {
    'stimulus': StimulusNode,
    'spike_monitor': SpikeMonitor,
    'recorder': Recorder,
    'clock': ClockNode,
    'link': LinkNode,
}


def make(kind: str, **kwargs: Any) -> ManagedNode:
    """Create the node that ``ros2 run eventreg_ros KIND`` would; a link may be called link_NAME."""
    name, kind = kind, kind_of(kind)
    if name != kind:
        kwargs['cli_args'] = ['--ros-args', '-r', f'__node:={name}', *kwargs.get('cli_args', ())]
    return BlockNode(kind, **kwargs) if kind in ROLES else CLASSES[kind](**kwargs)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the nodes named on the command line: python -m eventreg_ros.nodes.composed plant ..."""
    argv = list(sys.argv if argv is None else argv)
    kinds = remove_ros_args(argv)[1:]
    if not kinds or not {kind_of(kind) for kind in kinds} <= set(NODES):
        print(f'composed: name nodes among {", ".join(NODES)}, got {kinds}', file=sys.stderr)
        return 2
    return run_nodes([partial(make, kind) for kind in kinds], argv)


if __name__ == '__main__':
    sys.exit(main())
