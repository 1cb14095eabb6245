"""YAML as ROS's own parser reads it, and no other."""

from __future__ import annotations

import re
from typing import Any

from ..errors import ScenarioError


def _dialect(base: Any) -> Any:
    """Return the YAML loader or dumper ``base`` with the words that ROS's parser reads its way."""
    ros: Any = type(base.__name__, (base,), {})
    number = re.compile(r'^[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$')
    ros.add_implicit_resolver('tag:yaml.org,2002:float', number, list('-+0123456789'))
    ros.add_implicit_resolver('tag:yaml.org,2002:bool', re.compile('^[yYnN]$'), list('yYnN'))
    return ros


def dump(data: Any) -> str:
    """Return ``data`` as text that ROS reads as it is meant."""
    import yaml

    dumper = _dialect(yaml.SafeDumper)
    return str(yaml.dump(data, Dumper=dumper, sort_keys=False, default_flow_style=None))


def load(text: str, name: str) -> Any:
    """Return what ``text`` says. Raises ScenarioError, which names the scenario ``name``."""
    import yaml

    class Loader(_dialect(yaml.SafeLoader)):  # type: ignore[misc]
        """Refuses what reads well and means something else: an unquoted y, a key given twice."""

        def compose_mapping_node(self, anchor: Any) -> Any:
            node = super().compose_mapping_node(anchor)
            seen: set[tuple[str, str]] = set()
            for key, _ in node.value:
                name = (key.tag, key.value) if isinstance(key, yaml.ScalarNode) else None
                if name in seen and key.tag != 'tag:yaml.org,2002:merge':
                    raise yaml.constructor.ConstructorError(
                        None, None, f'{key.value} is given twice; keep one', key.start_mark
                    )
                seen |= {name} if name else set()
            return node

        def construct_yaml_bool(self, node: Any) -> bool:
            if node.value in ('y', 'Y', 'n', 'N'):
                raise yaml.constructor.ConstructorError(
                    None, None, f"ROS reads {node.value} as true or false; write '{node.value}'",
                    node.start_mark,
                )  # fmt: skip
            return bool(super().construct_yaml_bool(node))

    Loader.add_constructor('tag:yaml.org,2002:bool', Loader.construct_yaml_bool)
    try:
        return yaml.load(text, Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).splitlines()[0]
        if "'\\t'" in problem:
            problem += ' (indent with spaces, not tabs)'
        raise ScenarioError(f'scenario {name}{where}: not valid YAML: {problem}') from None
    except ValueError as error:  # a date that does not exist, say
        raise ScenarioError(f'scenario {name}: not valid YAML: {error}') from None
