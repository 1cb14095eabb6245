# SPDX-License-Identifier: Apache-2.0
"""What the name of a node says: its namespace, its kind, and what its signals are called.

A node's kind is its name, or its name up to _SUFFIX: plant, plant_left. In a scenario a node in a
namespace is called NAMESPACE/NAME (r1/plant), and its signals, being relative topics, NAMESPACE/y.
"""

from __future__ import annotations

from typing import NamedTuple

from ..errors import ScenarioError
from ..models.roles import ROLES, STIMULUS_OUTPUT
from .hint import hint

KINDS = (*ROLES, 'stimulus', 'spike_monitor', 'recorder', 'clock', 'link')
NAMING = ('excitatory', 'inhibitory', 'input', 'output', 'signals')
"""Parameters that name signals."""

OTHER = 'block'
"""The kind of a node of another package whose name is none of :data:`KINDS`."""

OUTPUTS = {**{name: role.output for name, role in ROLES.items()}, 'stimulus': STIMULUS_OUTPUT}
"""What each kind publishes unless its parameters say otherwise."""


class NodeName(NamedTuple):
    """The parts of a node's name: r1/plant_left is of kind plant with the suffix _left."""

    namespace: str
    kind: str
    suffix: str

    @property
    def name(self) -> str:
        """The name without its namespace."""
        return self.kind + self.suffix

    @property
    def output(self) -> str:
        """The signal that the node publishes by default, without its namespace; '' if none."""
        output = OUTPUTS.get(self.kind, '')
        return output + self.suffix if output else ''

    def sibling(self, kind: str) -> str:
        """Return the full name of the node of ``kind`` that has the same namespace and suffix."""
        return full_name(self.namespace, kind + self.suffix)


def kind_of(name: str) -> str | None:
    """Return the kind of the node called ``name``, which may hold a namespace; None: no kind."""
    last = name.rpartition('/')[2]
    found = [kind for kind in KINDS if last == kind or last.startswith(f'{kind}_')]
    return max(found, key=len, default=None)


def split(node: str, foreign: bool = False) -> NodeName:
    """Return the parts of a node's name.

    A ``foreign`` node, one of another package, may have any name. Raises ScenarioError for a name
    that is of no kind.
    """
    namespace, _, name = node.strip('/').rpartition('/')
    kind = kind_of(name)
    if kind is not None:
        return NodeName(namespace, kind, name.removeprefix(kind))
    if foreign:
        return NodeName(namespace, OTHER, name.removeprefix(OTHER))
    raise ScenarioError(
        f'no node {node!r}{hint(name, KINDS)}; a node of your own needs package and executable'
    )


def full_name(namespace: str, name: str) -> str:
    """Return ``name`` within ``namespace``, both without a leading slash; absolute ones stay."""
    if name.startswith('/'):
        return name.strip('/')
    return f'{namespace}/{name}' if namespace else name
