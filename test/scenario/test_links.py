"""Links on signals: what the scenario becomes, what is refused, and what launch makes of it."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from eventreg_ros import scenario as scenarios
from eventreg_ros.errors import EventregError, ParameterError, ScenarioError
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


def test_lockstep_and_links_exclude_each_other():
    assert 'clock' in scenarios.load('exact').in_lockstep(1.0).nodes
    with pytest.raises(EventregError, match='link_u could delay nothing'):
        scenarios.load('exact').with_links(['u']).in_lockstep(1.0)


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
