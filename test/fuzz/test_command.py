# SPDX-License-Identifier: Apache-2.0
"""What people type: -p, --at, --link, numbers of impairments; generated, whole and mangled.

``simulate``, ``sweep`` and ``analyze`` do it all. ``run`` goes as far as the nodes: what they
would be given must be read again as it was meant.
"""

import json
from pathlib import Path

import pytest

from eventreg_ros.cli import run as run_verb
from eventreg_ros.errors import EventregError
from eventreg_ros.scenario import load, parse, shipped
from eventreg_ros.scenario.links import OPTIONS
from eventreg_ros.simulation import jit

pytestmark = pytest.mark.slow

TEXTS = json.loads(Path(__file__).with_name('values.json').read_text(encoding='utf-8'))
VALUES = [value.strip() for value in TEXTS['values']]
NUMBERS = [*TEXTS['numbers'], '9' * 5000]
OTHER_NODES = ['', '/', 'links', 'nobody', 'plant_2', 'link_u', 'recorder', '/plant', 'a/b']
OTHER_PARAMETERS = ['', 'x0[0]', 'x0[99]', 'x0[-1]', 'k.k', 'qos_overrides./y.publisher.depth', 'y']


def rarely(draw, usual, odd):
    return draw.choice(odd) if draw.random() < 0.1 else draw.choice(usual)


def near(draw, value):
    """A value of the same type, most often one that is allowed."""
    if isinstance(value, bool):
        return draw.choice(['true', 'false'])
    if isinstance(value, int | float):
        return f'{value * draw.choice([0.5, 0.9, 1, 1, 2, 10]) + draw.choice([0, 0, 1, 0.125])}'
    if isinstance(value, list) and value and isinstance(value[0], float):
        return str([draw.choice([x, -x, 0.0, x + 0.5]) for x in value])
    return draw.choice(VALUES) if isinstance(value, list) else f"'{value}'"


def an_override(draw, scenario, values=(VALUES, NUMBERS)):
    node = rarely(draw, [*scenario.nodes, '/**'], OTHER_NODES)
    known = scenario.nodes.get(node, scenario.nodes['plant'])
    parameter = rarely(draw, list(known), OTHER_PARAMETERS)
    if draw.random() < 0.7:
        return f'{node}.{parameter}:={near(draw, known.get(parameter, 1.0))}'
    return f'{node}.{parameter}:={draw.choice(draw.choice(values))}'


def an_action(draw, scenario):
    time = rarely(draw, ['0', '0.1', '0.2', '1/8', '1.9', '2'], NUMBERS)
    if draw.random() < 0.6:
        node = rarely(draw, [n for n, v in scenario.nodes.items() if 'k' in v], OTHER_NODES)
        parameter = rarely(draw, ['k', 'tau', 'input_limit', 'adapt'], ['x0', 'rate', 'y', ''])
        return f'{time}:{node}.{parameter}:={rarely(draw, ["0.5", "0.0625", "1/9"], NUMBERS)}'
    node = rarely(draw, list(scenario.nodes), OTHER_NODES)
    return f'{time}:{node}:{rarely(draw, ["activate", "deactivate"], ["stop", ""])}'


def a_link(draw, scenario):
    signal = rarely(draw, list(scenario.publishers), ['z', ''])
    options = [
        f'{rarely(draw, list(OPTIONS), ["dealy"])}={rarely(draw, ["0", "0.1"], NUMBERS)}'
        for _ in range(draw.randrange(3))
    ]
    return f'{signal}:{",".join(options)}'


def words(draw, mangled, option, make, scenario, most=2):
    """The option some times, each with a text that is mangled now and then."""
    found = []
    for _ in range(draw.randint(0, most)):
        text = make(draw, scenario)
        found.append(f'{option}={mangled(text, draw) if draw.random() < 0.1 else text}')
    return found


def drawn(draw):
    """The name of a scenario, now and then of none, and a scenario to take names from."""
    name = draw.choice(shipped())
    return (name if draw.random() < 0.97 else draw.choice(['exat', '/dev/zero', '.', 'a\nb']),
            load(name))  # fmt: skip


@pytest.fixture(autouse=True)
def _plain(monkeypatch, tmp_path):
    """Runs are too short to pay for compiling; what is written goes elsewhere."""
    monkeypatch.setattr(jit, '_njit', lambda: None)
    monkeypatch.chdir(tmp_path)


def test_simulate(fuzz, answered, mangled):
    def case(draw):
        name, scenario = drawn(draw)
        arguments = ['simulate', name, '--duration', draw.choice(['2', '2', '0.01'])]
        arguments += words(draw, mangled, '-p', an_override, scenario)
        arguments += words(draw, mangled, '--at', an_action, scenario, 1)
        for option in ('--delay', '--jitter', '--loss', '--noise', '--seed', '--settle'):
            number = rarely(draw, ['0', '0.01', '0.1'], NUMBERS)
            arguments += [f'{option}={number}'] * (draw.random() < 0.1)
        return answered([*arguments, *['--sampled'] * (draw.random() < 0.7)])[0]

    fuzz(120, case)


def test_sweep(fuzz, answered, mangled):
    def a_spec(draw, scenario):
        ranges = TEXTS['ranges']
        return an_override(draw, scenario, (ranges, ranges, NUMBERS, VALUES))

    def case(draw):
        name, scenario = drawn(draw)
        arguments = ['sweep', name, '--duration', '0.5', '--settle=0']
        arguments += words(draw, mangled, '-p', a_spec, scenario, 3)
        arguments += draw.choice([[], [], ['--sets=2'], [f'--sets={draw.choice(NUMBERS)}']])
        arguments += draw.choice([[], [], [], ['--worst=5'], ['--border=controller.k,plant.k']])
        return answered(arguments)[0]

    fuzz(40, case)


def started(scenario, duration, *, lockstep, **more):
    """In the place of starting nodes: what they are given is read again as it was meant."""
    if lockstep:
        scenario = scenario.in_lockstep(duration)
    scenario = scenario.with_recorder('bag', 'scenario.yaml')
    again = parse(scenario.to_yaml(), scenario.name)
    assert repr(again.nodes) == repr(scenario.nodes)
    raise EventregError('started')


def test_run(fuzz, answered, mangled, monkeypatch):
    def case(draw):
        name, scenario = drawn(draw)
        arguments = ['run', name, '--duration=2', *['--lockstep'] * (draw.random() < 0.3)]
        arguments += words(draw, mangled, '-p', an_override, scenario)
        arguments += words(draw, mangled, '--link', a_link, scenario)
        arguments += words(draw, mangled, '--at', an_action, scenario)
        return 'started' in answered(arguments)[1][-1]

    monkeypatch.setattr(run_verb, 'run', started)
    fuzz(80, case)


TOPICS = [
    *('y:=/y', 'y:=/w:data', 'y:=/y:data[0]', 'y:=/nobody', 'y=/y', ':=/y', 'y:=', 'z:=/y'),
    *('y:=/y:', 'y:=/y:a.b[99999999999]'),
]


def test_analyze(fuzz, answered, mangled, make_bag):
    bag = make_bag(w=[20, 120, 160, 200, 240], y=[130], u=[20])

    def topic(draw, scenario):
        return draw.choice(TOPICS)

    def case(draw):
        arguments = ['analyze', str(bag), *words(draw, mangled, '--topic', topic, None)]
        for option in ('--settle', '--from', '--until', '--window', '--blind'):
            number = rarely(draw, ['1', '100', '150.5', '260'], NUMBERS)
            arguments += [f'{option}={number}'] * (draw.random() < 0.25)
        for option, texts in (
            ('--scenario', ['exact', 'open', 'linear', 'exat', '/dev/zero', '']),
            ('--namespace', ['/', '/r1', 'r1', '', '/y', 'a b']),
            ('--time', ['log', 'publish', 'header', 'Log']),
        ):
            arguments += [f'{option}={draw.choice(texts)}'] * (draw.random() < 0.15)
        return answered([*arguments, *['--lenient'] * draw.randrange(2)])[0]

    fuzz(40, case)


def test_other_verbs(fuzz, answered, mangled, make_bag):
    """Those that take long are given nothing that they could work on."""
    bag = str(make_bag(w=[20, 120, 160, 200, 240], y=[130], u=[20]))
    nothing = ['exat', f'{bag}/x', '', '.', '/dev/null']
    numbers = [f'--{name}' for name in ('settle', 'window', 'time', 'until', 'duration')]

    def case(draw):
        verb = draw.choice(['compare', 'new', 'list', 'analyse', 'certify', 'identify', 'margin'])
        good = [] if verb in ('certify', 'identify', 'margin') else ['exact', 'linear', bag]
        arguments = [verb, *draw.sample([*nothing, *good], draw.choice([1, 1, 2]))]
        if draw.random() < 0.5:
            arguments.append(f'{draw.choice(numbers)}={draw.choice(NUMBERS)}')
        if draw.random() < 0.3:
            arguments[-1] = mangled(arguments[-1], draw)
        return verb, answered(arguments)[0]

    fuzz(20, case)
