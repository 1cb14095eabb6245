# SPDX-License-Identifier: Apache-2.0
"""What --link says: a signal, and what the link on it does to its samples."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from ..errors import EventregError, ParameterError, ScenarioError
from ..simulation.loop import Loop
from .hint import hint
from .other_nodes import OTHERS
from .parameter import Parameter

OPTIONS = {p.name: p for p in OTHERS['link'] if p.name not in ('input', 'output', 'autostart')}
"""The parameters of the link node that --link may set."""


class LinkSpec(NamedTuple):
    """A link that is wanted: its signal, the parameters given, and where they were given."""

    signal: str
    options: dict[str, Any]
    where: str

    @classmethod
    def read(cls, link: str) -> LinkSpec:
        """Read SIGNAL:NAME=VALUE,NAME=VALUE. Raises ParameterError."""
        signal, _, rest = link.partition(':')
        if not signal:
            raise ParameterError(
                f'a link must be SIGNAL:NAME=VALUE,... (u:delay=0.02), got {link!r}'
            )
        options: dict[str, Any] = {}
        for option in filter(None, rest.split(',')):
            name, equals, text = option.partition('=')
            if not equals or name in options:
                raise ParameterError(
                    f'link {link}: give each option once as NAME=VALUE, got {option!r}'
                )
            if name not in OPTIONS:
                raise ParameterError(f'link {link}: no option {name!r}{hint(name, OPTIONS)}')
            options[name] = OPTIONS[name].check(f'link {signal}', _value(OPTIONS[name], text))
        return cls(signal, options, f'link {link}')

    def need_publisher(self, published: Collection[str]) -> None:
        """Raise ScenarioError unless the signal is ``published``."""
        if self.signal not in published:
            raise ScenarioError(
                f'{self.where}: nobody publishes {self.signal!r}{hint(self.signal, published)}'
            )


def need_pure_delay(link: str, values: Mapping[str, Any]) -> None:
    """Raise ScenarioError unless a link does nothing but delay: lockstep knows only that."""
    for name in ('jitter', 'loss', 'duplicate'):
        if values[name]:
            raise ScenarioError(
                f'{link}.{name} must be 0 in lockstep, which waits for every sample, got '
                f'{values[name]:g}; leave it out, or leave out --lockstep'
            )


def link_name(signal: str) -> str:
    """Return the name of the node that is the link on ``signal``."""
    return 'link_' + re.sub(r'\W', '_', signal.strip('/'))


def _value(parameter: Parameter, text: str) -> Any:
    """Return ``text`` as a number where one is meant; what is none is left for the check."""
    try:
        return {'double': float, 'int': int}.get(parameter.type, str)(text)
    except ValueError:
        return text


def need_linked(loop: Loop, on: frozenset[str] | None) -> frozenset[str] | None:
    """Return ``on``. Raises EventregError when it names a signal that no block listens to."""
    linked = {signal for _, signal in loop.links}
    for signal in sorted((on or frozenset()) - linked):
        raise EventregError(f'on: no block listens to {signal!r}{hint(signal, linked)}')
    return on
