# SPDX-License-Identifier: Apache-2.0
"""Links on signals: what the scenario becomes, what is refused, and what launch makes of it."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from eventreg_ros import scenario as scenarios
from eventreg_ros.errors import EventregError, ParameterError, ScenarioError
from eventreg_ros.scenario.inputs import delays_of
from eventreg_ros.scenario.links import LinkSpec
from eventreg_ros.scenario.parameters import parameters_of

LAUNCH = Path(__file__).resolve().parent.parent.parent / 'launch' / 'loop.launch.py'


def inputs(scenario):
    return {
        node: [*values['excitatory'], *values['inhibitory']]
        for node, values in scenario.nodes.items()
        if 'excitatory' in values
    }


def test_the_blocks_listen_to_the_link_and_nothing_else_changes():
    plain = scenarios.load('exact')
    before = plain.to_yaml()
    linked = plain.with_links(['u:delay=0.02,jitter=0.005', 'y'])
    assert inputs(linked) == {
        'exosystem': [],
        'plant': ['w', 'v', 'u_link'],
        'controller': ['y_link', 'y_r'],
    }
    link = linked.nodes['link_u']
    assert (link['input'], link['output'], link['delay']) == ('u', 'u_link', 0.02)
    assert (link['jitter'], link['loss'], link['order']) == (0.005, 0.0, 'newest')
    assert linked.given['link_y'] == {'input': 'y', 'output': 'y_link'}
    assert linked.nodes['spike_monitor'] == plain.nodes['spike_monitor']
    changed = {'excitatory', 'inhibitory'}
    for node, values in plain.nodes.items():
        for name in values.keys() - changed:
            assert linked.nodes[node][name] == values[name]
    assert plain.to_yaml() == before
    assert plain.with_links([]) == plain


def test_the_signs_stay_and_the_wiring_is_what_a_node_is_started_with():
    linked = scenarios.load('exact').with_links(['u:loss=0.1'])
    assert linked.given['plant']['inhibitory'] == ['u_link']
    assert linked.nodes['plant']['excitatory'] == ['w', 'v']
    assert 'u_link' in linked.publishers


def test_every_block_that_listens_gets_the_link():
    linked = scenarios.load('open').with_links(['v:delay=0.1', 'y_r:delay=0.1'])
    assert inputs(linked)['plant'] == ['w', 'v_link', 'u']
    assert inputs(linked)['reference'] == ['v_link']
    assert inputs(linked)['controller'] == ['y', 'y_r_link']
    assert {'link_v', 'link_y_r'} <= set(linked.nodes)


def test_all_of_the_link_node_can_be_given_and_with_its_type():
    signal, options, _ = LinkSpec.read(
        'lab/u:delay=0.5,jitter=1,loss=0.25,duplicate=1e-3,order=fifo,seed=7'
    )
    assert signal == 'lab/u'
    assert options == {
        'delay': 0.5, 'jitter': 1.0, 'loss': 0.25, 'duplicate': 0.001, 'order': 'fifo', 'seed': 7,
    }  # fmt: skip
    assert {*options, 'input', 'output', 'autostart'} == parameters_of('link').keys()


@pytest.mark.parametrize(
    ('links', 'kind', 'words'),
    [
        (['x:delay=0.1'], ScenarioError, "nobody publishes 'x'"),
        (['v'], ScenarioError, "nobody publishes 'v'"),
        (['u:delay=0.1', 'u:loss=0.1'], ScenarioError, 'has a link_u already'),
        (['u_link', 'u'], ScenarioError, "nobody publishes 'u_link'"),
        (['u:delai=0.1'], ParameterError, "did you mean 'delay'"),
        (['u:input=w'], ParameterError, "no option 'input'"),
        (['u:delay'], ParameterError, 'NAME=VALUE'),
        (['u:delay=1,delay=2'], ParameterError, 'once'),
        (['u:delay=long'], ParameterError, "finite number >= 0 and <= 60, got 'long'"),
        (['u:delay=nan'], ParameterError, 'finite number >= 0'),
        (['u:loss=2'], ParameterError, '<= 1, got 2.0'),
        (['u:seed=1.5'], ParameterError, "whole number >= 0 and <= 9.0072e+15, got '1.5'"),
        (['u:order=none'], ParameterError, 'one of newest, fifo, any'),
        ([':delay=1'], ParameterError, 'SIGNAL:NAME=VALUE'),
    ],
)
def test_what_is_wrong_is_said_in_one_line(links, kind, words):
    with pytest.raises(kind) as error:
        scenarios.load('exact').with_links(links)
    assert words in str(error.value)
    assert '\n' not in str(error.value)


def test_a_signal_that_no_block_listens_to_gets_no_link():
    scenario = scenarios.parse(
        'exosystem:\n  ros__parameters: {}\ncontroller:\n  ros__parameters: {}\n', 'two'
    )
    with pytest.raises(ScenarioError, match="no block listens to 'w'"):
        scenario.with_links(['w:delay=0.1'])


def test_in_lockstep_the_blocks_state_the_delays_of_the_links_before_them():
    scenario = scenarios.load('exact').with_links(['u:delay=0.02', 'y:delay=0.2', 'w'])
    stepping = scenario.in_lockstep(1.0)
    assert set(stepping.nodes) == {*scenarios.load('exact').nodes, 'clock'}
    plant, controller = stepping.nodes['plant'], stepping.nodes['controller']
    assert (plant['excitatory'], plant['inhibitory']) == (['w'], ['u'])
    assert (plant['lockstep_delays'], controller['lockstep_delays']) == (['u:0.2'], ['y:2.0'])


def test_in_lockstep_a_link_after_a_link_adds_up():
    text = """
r1/plant: {ros__parameters: {inhibitory: [u_far]}}
r1/link_a: {ros__parameters: {input: u, output: u_near, delay: 0.1}}
r1/link_b: {ros__parameters: {input: u_near, output: u_far, delay: 0.05}}
r1/controller: {ros__parameters: {}}
"""
    found = scenarios.parse(text, 'far').with_stated_delays()
    values = found.nodes['r1/plant']
    assert values['inhibitory'] == ['u']
    assert delays_of(values) == {'u': pytest.approx(1.5)}


@pytest.mark.parametrize('more', ['jitter=0.01', 'loss=0.1', 'duplicate=0.1'])
def test_lockstep_knows_links_that_delay_and_no_others(more):
    scenario = scenarios.load('exact').with_links([f'u:delay=0.1,{more}'])
    with pytest.raises(ScenarioError, match=rf'link_u\.{more.split("=")[0]} must be 0 in lockstep'):
        scenario.in_lockstep(1.0)


@pytest.mark.parametrize('entry', ['u', 'u:', 'u:x', 'u:-1', 'u:inf', ':'])
def test_delays_of_lockstep_that_are_none_are_refused(entry):
    with pytest.raises(EventregError, match=r'plant\.lockstep_delays must be SIGNAL:T'):
        scenarios.load('exact', [f"plant.lockstep_delays:=['{entry}']"])


@pytest.fixture
def launch(monkeypatch, tmp_path):
    """The launch file with just enough of ROS's launch, which is not to be had from PyPI."""

    def module(name, **names):
        made = ModuleType(name)
        vars(made).update(names)
        monkeypatch.setitem(sys.modules, name, made)

    def as_it_is(*arguments, **named):
        return SimpleNamespace(arguments=arguments, **named)

    class Configuration:
        def __init__(self, name):
            self.name = name

        def perform(self, context):
            return context.get(self.name, '')

    monkeypatch.setattr('tempfile.tempdir', str(tmp_path))
    module('launch', LaunchDescription=as_it_is)
    actions = ('DeclareLaunchArgument', 'LogInfo', 'OpaqueFunction', 'RegisterEventHandler')
    module('launch.actions', **dict.fromkeys(actions, as_it_is))
    module('launch.event_handlers', OnShutdown=as_it_is)
    module('launch.substitutions', LaunchConfiguration=Configuration)
    module('launch_ros', actions=None)
    module('launch_ros.actions', Node=as_it_is)
    spec = importlib.util.spec_from_file_location('loop_launch', LAUNCH)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def test_the_launch_argument_puts_links_on_signals(launch):
    context = {'scenario': 'exact', 'link': 'u:delay=0.02,jitter=0.005 y:loss=0.1'}
    _, _, *nodes = launch.start(context)
    started = {node.name: node for node in nodes}
    assert {'link_u', 'link_y', 'plant'} <= set(started)
    assert started['link_u'].executable == started['link_y'].executable == 'link'
    assert started['plant'].executable == 'plant'
    text = Path(started['plant'].parameters[0]).read_text(encoding='utf-8')
    assert 'excitatory: [y_link]' in text
    assert 'loss: 0.1' in text
    with pytest.raises(RuntimeError, match='nobody publishes'):
        launch.start({**context, 'link': 'x'})
    assert all(node.executable == node.name for node in launch.start({'scenario': 'exact'})[2:])


def test_a_launch_takes_its_files_with_it(launch, tmp_path):
    handler, _, plant, *_ = launch.start({'scenario': 'exact', 'record': 'true'})
    assert Path(plant.parameters[0]).exists()
    assert list(tmp_path.glob('**/*.yaml'))
    handler.arguments[0].on_shutdown(None, None)
    assert not list(tmp_path.iterdir())


def test_the_bag_of_a_launch_holds_what_the_nodes_were_started_with(launch, tmp_path):
    file = tmp_path / 'mine.yaml'
    file.write_text(
        '/**: {ros__parameters: {time_scale: 20.0}}\n'
        '/lab/controller: {ros__parameters: {k: 3.0}}\n'
        'exosystem: {ros__parameters: {tau: 0.1}}\n'
        '/other/node: {ros__parameters: {anything: 1}}\n'
    )
    context = {
        'scenario': 'exact', 'params_file': str(file), 'record': 'true', 'namespace': 'lab',
    }  # fmt: skip
    _, _, *nodes = launch.start(context)
    started = {node.name: node for node in nodes}
    given = scenarios.parse(Path(started['plant'].parameters[0]).read_text(), 'started')
    stored = scenarios.load(given.nodes['recorder']['scenario'])
    for found in (given, stored):
        assert found.time_scale == 20.0
        assert found.nodes['controller']['k'] == 3.0
        assert found.nodes['exosystem']['tau'] == 0.1
    assert {node.namespace for node in nodes} == {'lab'}
    assert len(started['plant'].parameters) == 1


def test_a_params_file_that_is_wrong_ends_the_launch_in_words(launch, tmp_path):
    file = tmp_path / 'mine.yaml'
    bad = (('controller: {ros__parameters: {kk: 1}}', 'kk'), ('- 1', 'ROS refuses it'))
    for text, words in bad:
        file.write_text(text)
        with pytest.raises(RuntimeError, match=words):
            launch.start({'scenario': 'exact', 'params_file': str(file)})
    with pytest.raises(RuntimeError, match='readable'):
        launch.start({'scenario': 'exact', 'params_file': str(tmp_path / 'none.yaml')})
