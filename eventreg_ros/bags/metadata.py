# SPDX-License-Identifier: Apache-2.0
"""metadata.yaml of a rosbag2, of any version: hints at what its files hold."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any

from .channel import absolute

INFORMATION = 'rosbag2_bagfile_information'
SCENARIO_KEY = 'eventreg_ros.scenario'
NAME_KEY = 'eventreg_ros.scenario_name'
TOPICS_KEY = 'eventreg_ros.topics'
"""Signals that were recorded under another name: y:=/arm/membrane w:=/generator/out."""

MOST = 8 * 2**20
"""A text of more characters than this is not parsed."""


@dataclass(frozen=True)
class Metadata:
    """What metadata.yaml says: file names, message counts and types by topic, custom data."""

    files: tuple[str, ...] = ()
    counts: Counter[str] = field(default_factory=Counter)
    types: dict[str, str] = field(default_factory=dict)
    custom: dict[str, str] = field(default_factory=dict)


def parse(text: str) -> Metadata | None:
    """Return what a metadata.yaml says, None where it cannot be understood."""
    found = _load(text)
    information = found.get(INFORMATION) if isinstance(found, dict) else None
    return _metadata(information) if isinstance(information, dict) else None


def custom_data(text: str) -> dict[str, str]:
    """Return the custom data of a metadata text without its first key, as files hold it."""
    found = _load(text)
    if isinstance(found, dict) and isinstance(found.get(INFORMATION), dict):
        found = found[INFORMATION]
    return _metadata(found).custom if isinstance(found, dict) else {}


def _load(text: str) -> Any:
    """Return what a YAML text holds, None where it is none, or one that was made to hurt."""
    import yaml

    loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
    if len(text) > MOST:
        return None
    try:
        if '<<' in text and any(
            isinstance(event, yaml.ScalarEvent) and event.value == '<<'
            for event in yaml.parse(text, loader)
        ):
            return None  # merge keys copy what they name, again and again
        return yaml.load(text, loader)
    except (yaml.YAMLError, RecursionError, ValueError):
        return None


def _metadata(information: dict[Any, Any]) -> Metadata:
    counts: Counter[str] = Counter()
    types = {}
    for entry in _list(information.get('topics_with_message_count')):
        topic = _dict(_dict(entry).get('topic_metadata'))
        name, count = topic.get('name'), _dict(entry).get('message_count')
        if isinstance(name, str):
            types[absolute(name)] = str(topic.get('type', ''))
            if isinstance(count, int):
                counts[absolute(name)] += count
    files = [_name(f) for f in _list(information.get('relative_file_paths')) if isinstance(f, str)]
    custom = _dict(information.get('custom_data'))
    return Metadata(
        tuple(files), counts, types,
        {key: value for key, value in custom.items() if isinstance(value, str)},
    )  # fmt: skip


def _name(path: str) -> str:
    """Return the name alone: old versions put the directory before it."""
    return PureWindowsPath(PurePosixPath(path).name).name


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _dict(value: Any) -> dict[Any, Any]:
    return value if isinstance(value, dict) else {}
