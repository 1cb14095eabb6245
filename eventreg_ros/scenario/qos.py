# SPDX-License-Identifier: Apache-2.0
"""Keys that override the quality of service: qos_overrides.TOPIC.publisher.POLICY.

TOPIC is the resolved name, with the namespace and after remapping. rclpy takes a key with any other
name without a word and does nothing with it, so that such keys are refused here.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable
from typing import NamedTuple

from ..errors import ParameterError, shown
from .hint import hint

PREFIX = 'qos_overrides.'
POLICIES = ('depth', 'history', 'reliability')
"""What rclpy lets be overridden by default, which is what our nodes ask it for."""

_KEY = re.compile(r'qos_overrides\.([^.]+)\.(publisher|subscription)\.([^.]+)')


class Endpoint(NamedTuple):
    """A publisher or subscription: how the node calls its topic, the resolved name, the kind."""

    name: str
    topic: str
    kind: str

    def key(self, policy: str) -> str:
        """Return the parameter that overrides a policy of it."""
        return f'{PREFIX}{self.topic}.{self.kind}.{policy}'


def check_key(node: str, key: str, endpoints: Collection[Endpoint]) -> None:
    """Raise ParameterError for a key that is none, or has a name as it was before resolution.

    A key for a topic that ``node``, with these ``endpoints``, has nothing to do with passes: what
    stands below /** comes to every node.
    """
    topic, kind, policy = _parts(node, key)
    same = [each for each in endpoints if each.kind == kind]
    if any(each.topic == topic for each in same):
        return
    for each in same:
        if each.name.strip('/') == topic.strip('/'):
            raise ParameterError(
                f'{node}.{key} acts on nothing: {each.name} is {each.topic} here; '
                f'write {each.key(policy)}'
            )


def misspelt(key: str, endpoints: Iterable[Endpoint]) -> str | None:
    """Return the topic that ``key`` may mean, where it names none of a node's but nearly one."""
    found = _KEY.fullmatch(key)
    known = [each.topic for each in endpoints if found is not None and each.kind == found[2]]
    if found is None or found[1] in known:
        return None
    return next(iter(difflib.get_close_matches(found[1], known, 1)), None)


def need_topic(where: str, key: str, endpoints: Collection[Endpoint]) -> None:
    """Raise ParameterError unless ``key`` is of one of the ``endpoints``."""
    topic, kind, _ = _parts(where, key)
    known = sorted({each.topic for each in endpoints if each.kind == kind})
    if topic not in known:
        raise ParameterError(f'{where}.{key}: no {kind} of {topic}{hint(topic, known or ["none"])}')


def _parts(where: str, key: str) -> tuple[str, str, str]:
    found = _KEY.fullmatch(key)
    if found is None:
        raise ParameterError(
            f'{where}.{key} must be {PREFIX}TOPIC.publisher.POLICY or '
            f'{PREFIX}TOPIC.subscription.POLICY, as in {PREFIX}/y.publisher.depth'
        )
    topic, kind, policy = found.groups()
    if policy not in POLICIES:
        raise ParameterError(f'{where}.{key}: no policy {shown(policy)}{hint(policy, POLICIES)}')
    return topic, kind, policy


def keys_of(parameters: Iterable[str]) -> list[str]:
    """Return those of ``parameters`` that override a quality of service."""
    return [name for name in parameters if name.startswith(PREFIX)]


def moved(key: str, namespace: str) -> str:
    """Return ``key`` as it is within a further ``namespace``; other parameters stay."""
    found = _KEY.fullmatch(key)
    space = namespace.strip('/')
    if found is None or not space:
        return key
    return key.replace(f'{PREFIX}/', f'{PREFIX}/{space}/', 1)
