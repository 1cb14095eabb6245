# SPDX-License-Identifier: Apache-2.0
"""What a parameter file means: offline tools and nodes agree, in generated files of many kinds.

The node is the class that runs in ROS, made from a file that goes through rcl; offline is
``scenario.parse``. Both refuse, or both take the same values. Two things a node cannot know and
only reports or leaves alone: a parameter that it does not have, and a node that is none of ours.
"""

import itertools
import json
import re
from pathlib import Path

import pytest

from eventreg_ros.errors import EventregError
from eventreg_ros.scenario import parse

pytest.importorskip('rclpy')

from rclpy.context import Context

from eventreg_ros.nodes.composed import make
from eventreg_ros.nodes.given import as_meant

pytestmark = pytest.mark.ros

VALUES = json.loads(Path(__file__).with_name('values.json').read_text(encoding='utf-8'))['values']
"""What may stand behind a key and its colon: scalars of all kinds, lists, mappings, broken YAML."""

PARAMETERS = [
    ('plant', 'k'), ('plant', 'x0'), ('plant', 'output'), ('plant', 'excitatory'),
    ('plant', 'lockstep'), ('plant', 'hold'), ('plant', 'use_sim_time'), ('clock', 'steps'),
    ('spike_monitor', 'signals'), ('stimulus', 'onsets'), ('recorder', 'scenario_name'),
]  # fmt: skip


def single(value, node, parameter):
    """A file that gives one value to one parameter."""
    return f'{node}:\n  ros__parameters:\n    {parameter}:{value}\n'


SINGLES = [
    (single(value, *where), where[0]) for where, value in itertools.product(PARAMETERS, VALUES)
]

KEYS = [
    'plant',
    '/plant',
    '/**',
    '/*',
    '/**/plant',
    '/*/plant',
    'plant_2',
    'r1/plant',
    'controller',
]
LINES = """\
k: 2.0|k: 3|k: 08|k: {}|k: {a: 1}|k: null|"k": 1.5|k: &k 2.5|tau: *k|tau: 0.25
x0: [0.5, 0.0]|x0: []|output: y|output: z|excitatory: [w, y2]|excitatory: [w, y]
excitatory: &s [w]|inhibitory: *s|hold: zero|rate: 100|rate: 100.0|model: neuron|model: linear
gain: [1.0, 2.0]|qos: {a: 1}|lockstep: y|lockstep: n|<<: {k: 4.0}|<<: *s|use_sim_time: no
qos_overrides: {/y: {publisher: {depth: 10}}}|qos_overrides./y.publisher.depth: 7
time_scale: 12:30|settle: 3.0|autostart: off""".replace('\n', '|').split('|')


def whole(random):
    """A file of some nodes with some parameters, written in some way."""
    sections = []
    for _ in range(random.choice([1, 1, 2, 2, 3, 4])):
        key = random.choice(KEYS)
        lines = random.sample(LINES, random.choice([0, 1, 1, 2, 2, 3, 4]))
        sections.append(_section(random, key, lines))
    between = random.choice(['', '', '', '', '---\n', '\n# more\n', '...\n---\n'])
    return between.join(sections)


def _section(random, key, lines):
    name = random.choice(['ros__parameters'] * 9 + ['ros__parameters_'])
    if random.random() < 0.3:
        return f'{key}: {{{name}: {{{", ".join(lines)}}}}}\n'
    if '/' in key.strip('/') and random.random() < 0.5:
        space, _, key = key.rpartition('/')
        inside = ''.join(f'      {line}\n' for line in lines) or '      {}\n'
        return f'{space}:\n  {key}:\n    {name}:\n{inside}'
    inside = ''.join(f'    {line}\n' for line in lines)
    return f'{key}:\n  {name}:{"" if inside else " {}"}\n{inside}'


def offline(text, node):
    """What the file gives to a node, or the reason for which it is refused."""
    try:
        return dict(parse(text, 'mine').nodes.get(node, {}))
    except EventregError as error:
        return str(error)


@pytest.fixture
def online(tmp_path, domain):
    """Say what a real node takes from a file, or why it refuses it."""

    def make_one(text, node):
        path = tmp_path / 'it.yaml'
        path.write_text(text, encoding='utf-8')
        context, made = Context(), None
        try:
            with as_meant(['x', '--ros-args', '--params-file', str(path)]) as arguments:
                context.init(arguments, domain_id=domain)
            made = make(node, context=context)
            return dict(made.values)
        except Exception as error:
            return f'{type(error).__name__}: {error}'
        finally:
            if made is not None:
                made.close()
            context.try_shutdown()

    return make_one


STRICTER = (
    'names no node', "no node '", 'must hold ros__parameters:', 'both publish',
    'has no parameter', 'no node has the parameter', ': no publisher of', 'acts on nothing',
    'must be qos_overrides.',
)  # fmt: skip
"""What only a scenario is refused for, or a node not before it is configured. A node, to which all
of /** is given, cannot know which parameters are misplaced; it reports one that no node has."""


COLON = re.compile(r'[{\[][^}\]]*[^ ]:[^ ]')
"""Within braces and a word, where libyaml before 0.2, which the wheels of rcl have, takes none."""


def disagreement(text, node, online):
    """Return how offline and node differ about a file, None where they agree."""
    ours = offline(text, node)
    if isinstance(ours, str) and (other := re.match(r'(r1/plant|plant_2|controller)\b', ours)):
        node = other[0]  # it is another node's value that is refused
    theirs = online(text, node)
    if isinstance(ours, str) and isinstance(theirs, str):
        return None
    if isinstance(ours, str):
        excused = any(words in ours for words in STRICTER)
        return None if excused else f'offline refuses: {ours}\nnode takes {theirs}'
    if not ours:  # the scenario has no such node
        return None
    if isinstance(theirs, str):
        old = 'Error parsing a event' in theirs and COLON.search(text)
        return None if old else f'node refuses: {theirs}\noffline takes {ours}'
    different = {
        p: (ours.get(p), theirs[p]) for p in theirs if repr(ours.get(p)) != repr(theirs[p])
    }
    return f'(offline, node): {different}' if different else None


def agree(text, node, online):
    assert (found := disagreement(text, node, online)) is None, f'{text!r}: {found}'


def test_one_value_means_the_same_offline_and_to_a_node(online, fuzz):
    fuzz(60, lambda draw: agree(*draw.choice(SINGLES), online))


def test_a_whole_file_means_the_same_offline_and_to_a_node(online, fuzz):
    fuzz(60, lambda draw: agree(whole(draw), 'plant', online))


def test_a_mangled_file_means_the_same_offline_and_to_a_node(online, fuzz, mangled):
    def text(draw):
        return mangled(whole(draw), draw).encode('utf-8', 'replace').decode()

    fuzz(40, lambda draw: agree(text(draw), 'plant', online))
