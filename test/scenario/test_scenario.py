# SPDX-License-Identifier: Apache-2.0
"""The scenario: shipped files against the paper, the YAML that ROS reads, overrides, errors."""

import re

import pytest

from eventreg_ros import certificates, simulate
from eventreg_ros.errors import EventregError, ParameterError, ScenarioError
from eventreg_ros.robustness.margins import margins
from eventreg_ros.scenario import Criteria, config_directory, files, load, parse, shipped, with_file
from eventreg_ros.scenario.qos import Endpoint, misspelt

# The paper (paper.tex): (k_p, tau_p) = (1, 1/11) in every caption; (k_w, tau_w), (k_eta, tau_eta)
# and (k_r, tau_r) from the captions of fig. not_contr (quiescent), exact_reg (exact, and with it
# uncontrolled and single_neuron), below_threshold (mismatch) and with.v (open). The contract adds
# the names, the initial states and what is left out.
PAPER = {
    'exact': {'exosystem': (2, 1 / 12), 'plant': (1, 1 / 11), 'controller': (2, 1 / 12)},
    'mismatch': {'exosystem': (1, 1 / 12), 'plant': (1, 1 / 11), 'controller': (3, 1 / 16)},
    'open': {
        'exosystem': (1, 1 / 12), 'plant': (1, 1 / 11), 'controller': (4, 1 / 15),
        'reference': (3, 1 / 13),
    },
    'uncontrolled': {'exosystem': (2, 1 / 12), 'plant': (1, 1 / 11)},
    'quiescent': {'plant': (1, 1 / 11), 'controller': (2, 1 / 12)},
    'single_neuron': {'exosystem': (2, 1 / 12), 'plant': (1, 1 / 11), 'controller': (2, 1 / 12)},
    'linear': {'exosystem': None, 'plant': None, 'controller': None},
}  # fmt: skip

# The contract: two generators with k 2; per bank, k, adapt and the taus of the controllers.
GENERATORS = {
    'exosystem': (1 / 12, (1.0, 0.0, -1.0, 0.0)),
    'exosystem_2': (1 / 19, (-0.4, 0.6, 0.9, -0.3)),
}
BANKS = {'two_generators': (2.0, 0.0, (1 / 12, 1 / 19)), 'unknown': (1.0, 0.04, (1 / 10, 1 / 22))}

# ../shared/truth/trajectories.json, "open": "stimulus".
ONSETS = (60.0, 110.0, 190.0, 250.0, 290.0, 360.0, 420.0, 455.0, 520.0, 600.0, 645.0, 720.0)
WIDTH, AMPLITUDE = 10.0, 1.5

MINIMAL = 'plant:\n  ros__parameters:\n    k: 2\n'


def complaint(text=MINIMAL, *overrides, name='mine'):
    """Return the one line with which a scenario is refused."""
    with pytest.raises(EventregError) as caught:
        parse(text, name, overrides)
    message = str(caught.value)
    assert '\n' not in message
    return message


def one(value, node='plant', parameter='k'):
    """Return a parameter as it is read from YAML."""
    text = f'{node}:\n  ros__parameters:\n    {parameter}: {value}\n'
    return parse(text, 'mine').nodes[node][parameter]


# The shipped ones -------------------------------------------------------------------------------


def test_exactly_the_scenarios_of_the_contract_are_shipped():
    assert set(shipped()) == {*PAPER, *BANKS, 'late', 'morris_lecar'}


@pytest.mark.parametrize('name', PAPER)
def test_shipped_scenarios_have_the_papers_values(name):
    blocks = load(name).blocks
    assert set(blocks) == set(PAPER[name])
    for role, values in PAPER[name].items():
        if values is not None:
            assert blocks[role].params[:2] == values


@pytest.mark.parametrize('name', PAPER)
def test_shipped_scenarios_have_the_contracts_initial_states(name):
    x0 = {role: spec.x0 for role, spec in load(name).blocks.items()}
    wanted = {
        'exosystem': (1.0, 0.0, -1.0, 0.0),
        'plant': (0.0, 0.0),
        'controller': (0.5, 0.0, -0.5, 0.0),
        'reference': (0.0, 0.0),
    }
    if name == 'linear':
        wanted = {'exosystem': (1.0, 0.0), 'plant': (0.0,), 'controller': (0.0, 0.0)}
    if name == 'quiescent':
        wanted['plant'] = (0.5, 0.0)
    if name == 'single_neuron':
        wanted['controller'] = (0.5, 0.0)
    assert x0 == {role: wanted[role] for role in x0}


@pytest.mark.parametrize('name', PAPER)
def test_shipped_scenarios_have_the_papers_wiring(name):
    wiring = {
        'exosystem': ((), 'w'),
        'plant': ((('w', 1.0), ('v', 1.0), ('u', -1.0)), 'y'),
        'controller': ((('y', 1.0), ('y_r', -1.0)), 'u'),
        'reference': ((('v', 1.0),), 'y_r'),
    }
    for role, spec in load(name).blocks.items():
        assert (spec.inputs, spec.output) == wiring[role]


@pytest.mark.parametrize('name', PAPER)
def test_shipped_scenarios_watch_what_they_publish(name):
    scenario = load(name)
    assert scenario.time_scale == 10.0
    assert scenario.rate == 200.0
    assert scenario.criteria == Criteria(0.5 if name == 'linear' else 1.0)
    assert set(scenario.nodes['spike_monitor']['signals']) == set(scenario.publishers)
    extra = {'spike_monitor', 'stimulus'} if name == 'open' else {'spike_monitor'}
    assert set(scenario.nodes) == {*PAPER[name], *extra}


@pytest.mark.parametrize('name', BANKS)
def test_the_banks_are_the_contracts(name):
    scenario, (k, adapt, taus) = load(name), BANKS[name]
    nodes, blocks = scenario.nodes, scenario.blocks
    assert set(blocks) == {*GENERATORS, 'plant', 'controller', 'controller_2'}
    for node, (tau, x0) in GENERATORS.items():
        assert (blocks[node].params, blocks[node].x0) == ((2.0, tau), x0)
    for node, tau in zip(('controller', 'controller_2'), taus, strict=True):
        values = nodes[node]
        assert (values['k'], values['tau'], values['adapt']) == (k, tau, adapt)
        assert values['x0'] == [0.5, 0.0, -0.5, 0.0]
        assert blocks[node].inputs == (('y', 1.0), ('y_r', -1.0))
    signs = dict(blocks['plant'].inputs)
    assert signs == {'w': 1.0, 'w_2': 1.0, 'u': -1.0, 'u_2': -1.0}
    assert blocks['plant'].params == (1.0, 1 / 11)
    assert scenario.criteria.settle == 600.0
    assert set(nodes['spike_monitor']['signals']) == set(scenario.outputs)


def test_the_linear_motif_is_hurwitz_and_has_the_papers_models():
    blocks = load('linear').blocks
    k_y, k_1, k_2 = blocks['controller'].params
    assert (k_y, k_1 > -k_2, k_2 < 1) == (0.0, True, True)  # eq. s.linear.gains
    assert [spec.model.name for spec in blocks.values()] == ['harmonic', 'lag', 'internal_model']


def test_models_of_the_nonlinear_scenarios():
    for name in set(PAPER) - {'linear'}:
        for role, spec in load(name).blocks.items():
            single = role in ('plant', 'reference') or name == 'single_neuron'
            oscillator = role == 'exosystem' or not single
            assert spec.model.name == ('oscillator' if oscillator else 'neuron')


def test_the_stimulus_of_open_is_the_truths():
    v = load('open').stimuli['v']
    assert v.breaks(1000.0) == sorted({*ONSETS, *(t + WIDTH for t in ONSETS)})
    for onset in ONSETS:
        assert (v(onset - 1e-6), v(onset), v(onset + WIDTH - 1e-6)) == (0.0, AMPLITUDE, AMPLITUDE)
        assert v(onset + WIDTH) == 0.0
    assert load('exact').stimuli == {}


@pytest.mark.parametrize('name', PAPER)
def test_to_yaml_is_read_back_as_the_same_scenario(name):
    scenario = load(name, ['plant.tau:=1e-3', '/**.rate:=123'])
    again = parse(scenario.to_yaml(), name)
    assert again == scenario
    assert again.given == scenario.given
    assert parse(again.to_yaml(), name).to_yaml() == scenario.to_yaml()


def test_to_yaml_holds_for_ros_too():
    assert "'y'" in load('exact').to_yaml()  # unquoted, ROS would take it for true
    tiny = parse('plant: {ros__parameters: {k: 1e-7}}', 'mine').to_yaml()
    assert re.search(r'k: \d+\.\d*e-0?7', tiny)  # a point and an exponent: a double to anyone


def test_to_yaml_says_only_what_was_given():
    assert parse(MINIMAL, 'mine').to_yaml() == 'plant:\n  ros__parameters: {k: 2.0}\n'


# Where scenarios are found ----------------------------------------------------------------------


@pytest.mark.parametrize(
    'where',
    [
        ('lib/python3.12/site-packages/eventreg_ros', 'share/eventreg_ros/config'),  # colcon, pip
        ('eventreg_ros', 'config'),  # the source tree
    ],
)
def test_the_config_directory_is_found_in_sources_and_installations(tmp_path, monkeypatch, where):
    package, config = (tmp_path / 'prefix' / part for part in where)
    (package / 'scenario').mkdir(parents=True)
    config.mkdir(parents=True)
    (config / 'exact.yaml').write_text(MINIMAL)
    monkeypatch.setattr(files, '__file__', str(package / 'scenario' / 'shipped.py'))
    assert config_directory() == config
    assert shipped() == ['exact']
    assert load('exact').nodes['plant']['k'] == 2.0


def test_a_missing_config_directory_is_one_line(tmp_path, monkeypatch):
    missing = tmp_path / 'eventreg_ros' / 'scenario' / 'shipped.py'
    monkeypatch.setattr(files, '__file__', str(missing))
    with pytest.raises(ScenarioError, match='install the package again'):
        config_directory()


def test_by_name_by_path_and_not_at_all(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ('mine.yaml', 'mine.yml'):
        (tmp_path / name).write_text(MINIMAL)
        assert load(name).name == 'mine'
        assert load(f'./{name}').nodes == load(str(tmp_path / name)).nodes
    for scenario, words in {
        'exakt': "no scenario 'exakt'; did you mean 'exact'",
        'no/such': "scenario file 'no/such' does not exist; check the path",
        'none.yaml': "scenario file 'none.yaml' does not exist",
        str(tmp_path): 'must be a readable text file: it is a directory; give a regular file',
        '/dev/zero': 'it is a device; give a regular file',
        '': "no scenario ''",
    }.items():
        with pytest.raises(ScenarioError) as caught:
            load(scenario)
        assert words in str(caught.value)


def test_a_file_that_is_no_text_is_one_line(tmp_path):
    (tmp_path / 'bytes.yaml').write_bytes(b'\xff\xfe\x00plant')
    with pytest.raises(ScenarioError, match='must be a readable text file') as caught:
        load(str(tmp_path / 'bytes.yaml'))
    assert '\n' not in str(caught.value)


# What a parameter file says -----------------------------------------------------------------------


def test_wildcards_reach_every_node_that_has_the_parameter_and_yield_to_the_node():
    text = (
        '/**: {ros__parameters: {rate: 50, k: 3, use_sim_time: true}}\n'
        'plant: {ros__parameters: {k: 2}}\n'
        'controller: {ros__parameters: {}}\n'
        'stimulus: {ros__parameters: {}}\n'
        'spike_monitor: {ros__parameters: {}}\n'
    )
    scenario = parse(text, 'mine')
    assert scenario.rate == 50.0
    assert scenario.nodes['plant']['k'] == 2.0
    assert scenario.nodes['controller']['k'] == 3.0
    assert 'k' not in scenario.given['stimulus']
    assert 'k' not in scenario.given['spike_monitor']
    assert scenario.given['spike_monitor']['use_sim_time'] is True
    assert list(scenario.nodes) == ['plant', 'controller', 'stimulus', 'spike_monitor']


@pytest.mark.parametrize('key', ['plant', '/plant', '/**/plant'])
def test_a_node_may_be_named_as_in_ros(key):
    assert parse(f'{key}: {{ros__parameters: {{k: 2}}}}', 'mine').nodes['plant']['k'] == 2.0


def test_parameters_may_be_nested_as_in_ros():
    text = 'plant: {ros__parameters: {qos_overrides: {/y: {publisher: {depth: 5}}}}}'
    assert parse(text, 'mine').given['plant'] == {'qos_overrides./y.publisher.depth': 5}


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('2', 2.0), ('2.0', 2.0), ('1e-3', 1e-3), ('1E3', 1e3), ('1.e2', 1e2), ('+2e+1', 20.0),
        ('1.5e-3', 1.5e-3), ('.5', 0.5),
    ],
)  # fmt: skip
def test_numbers_are_read_as_ros_reads_them(text, value):
    read = one(text)
    assert (read, type(read)) == (value, float)


@pytest.mark.parametrize('word', ['y', 'Y', 'n', 'N'])
def test_an_unquoted_y_is_a_name_where_signals_are_named_and_a_bool_where_one_is_meant(word):
    for text in (f'[w, {word}]', f"[w, '{word}']", f'[w, !!str {word}]'):
        assert one(text, 'spike_monitor', 'signals') == ['w', word]
    assert one(word, 'plant', 'output') == word
    assert load('exact', [f'plant.output:={word}']).nodes['plant']['output'] == word
    assert one(word, 'plant', 'lockstep') is (word in 'yY')
    assert one(f'[{word}]', 'controller', 'excitatory') == [word]
    message = complaint(f'plant: {{ros__parameters: {{hold: {word}}}}}')
    assert 'plant.hold must be one of zero, linear' in message


@pytest.mark.parametrize('word', ['yes', 'true', 'on', 'NO', 'False'])
def test_other_words_for_true_and_false_are_no_names(word):
    assert 'quote words' in complaint(f'plant: {{ros__parameters: {{output: {word}}}}}')
    assert "Value type 'bool' do not belong" in complaint(
        f'spike_monitor: {{ros__parameters: {{signals: [w, {word}]}}}}'
    )


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('plant:\n\tros__parameters:\n\t\tk: 2\n', 'line 2: not valid YAML'),
        ('plant:\n\tros__parameters:\n', 'indent with spaces, not tabs'),
        ('plant: [', 'Sequences can only be values and not keys in params'),
        ('plant: {ros__parameters: {x0: [', 'not valid YAML'),
        ('plant: {? [a, b] : 1}', 'ROS refuses it: Sequences cannot be key; write NODE:'),
        (
            'plant:\n  ros__parameters:\n    k: 2\n    tau: 40\n    k: 3\n',
            "scenario mine, line 5: 'k' is given twice; keep one",
        ),
        ('plant: {ros__parameters: {k: !!python/name:os.system }}', 'ROS refuses it: No value; '),
        ('plant: {ros__parameters: {k: !!int "3"}}', "a finite number >= 0, got '3'"),
        ('plant: {ros__parameters: {k: 2024-13-45}}', "got '2024-13-45'"),
        ('plant: {ros__parameters: {k: 12:30}}', "got '12:30'"),
        ('plant: {ros__parameters: {k: 1_000}}', "got '1_000'"),
        ('plant: {ros__parameters: {k: 1e400}}', "got '1e400'"),
        ('plant: &a {ros__parameters: *a}', 'Will not support aliasing; write the value out'),
        ('plant: {ros__parameters: {<<: &a {k: 1}, <<: *a}}', 'Will not support aliasing'),
        ('plant: {ros__parameters: {x0: [1, 0.5]}}', "of same type. Value type 'double' do not"),
        ('plant: {ros__parameters: {k: {}}}', 'plant.k must be a finite number >= 0, got None'),
        ('---\nplant: {}\n---\nplant: {}\n', "'plant' must hold ros__parameters"),
        ('\x07', 'not valid YAML'),
        ('', 'names no node; name at least one of'),
        ('- plant', 'Sequences cannot be key; write NODE:, below it ros__parameters:'),
        ('hello', 'names no node; name at least one of'),
        ('{}', 'names no node; name at least one of exosystem, plant'),
        ('/**: {ros__parameters: {rate: 100}}', 'names no node'),
        ('plnt: {ros__parameters: {}}', "no node 'plnt'; did you mean 'plant'?"),
        ('1: {ros__parameters: {}}', "'1' is no name of a node"),
        ('plant: {k: 2}', 'a node must hold ros__parameters: and below it one line per parameter'),
        ('plant: {ros__parameters: 2}', 'must hold ros__parameters:'),
        ('plant: {ros__parameters: {}, k: 2}', 'must hold ros__parameters:'),
        ('plant:', 'must hold ros__parameters:'),
        ('plant: {ros__parameters: {kk: 2}}', "plant has no parameter 'kk'; did you mean 'k'?"),
        ('plant: {ros__parameters: {k: [2]}}', 'plant.k must be a finite number >= 0, got [2]'),
        ('plant: {ros__parameters: {k: two}}', "plant.k must be a finite number >= 0, got 'two'"),
        ('plant: {ros__parameters: {k: .nan}}', 'plant.k must be a finite number >= 0, got nan'),
        ('plant: {ros__parameters: {k: yes}}', 'plant.k must be a finite number >= 0, got True'),
        ('plant: {ros__parameters: {tau: 0}}', 'plant.tau must be a finite number > 0, got 0'),
        ('plant: {ros__parameters: {k: 2024-01-02}}', 'plant.k must be a finite number >= 0'),
        (
            'plant: {ros__parameters: {x0: {a: 1}}}',
            "plant.x0 must be a list of at most 10000 finite numbers, got a mapping with 'a'",
        ),
        ('plant: {ros__parameters: {use_sim_time: 8.0}}', 'plant.use_sim_time must be true or'),
        (
            '/**: {ros__parameters: {rte: 1}}\nplant: {ros__parameters: {}}',
            "/**.rte: no node has the parameter 'rte'; did you mean 'rate'?",
        ),
        (
            'plant: {ros__parameters: {}}\ncontroller: {ros__parameters: '
            "{output: 'y', excitatory: [w]}}",
            "plant and controller both publish 'y'; set controller.output to another signal",
        ),
    ],
)
def test_every_error_is_one_line_that_says_how_to_mend_it(text, words):
    assert words in complaint(text)


def test_nodes_must_agree_on_their_time():
    text = (
        'plant: {ros__parameters: {rate: 100, time_scale: 5}}\ncontroller: {ros__parameters: {}}\n'
    )
    scenario = parse(text, 'mine')
    for name in ('rate', 'time_scale'):
        with pytest.raises(ScenarioError) as caught:
            getattr(scenario, name)
        assert f'all nodes must have the same {name}, got plant ' in str(caught.value)
        assert f'-p /**.{name}:=VALUE' in str(caught.value)


def test_a_scenario_without_a_block_has_no_time():
    scenario = parse('spike_monitor: {ros__parameters: {threshold: 2}}', 'mine')
    assert scenario.criteria == Criteria(2.0)
    with pytest.raises(ScenarioError, match='names no block'):
        scenario.time_scale  # noqa: B018


def test_the_monitor_is_what_the_file_says_or_the_default():
    assert parse(MINIMAL, 'mine').criteria == Criteria()
    given = (
        'threshold: 1.5, reset: -1, settle: 600, window: 2, blind: 1, refractory: 3, min_width: 4'
    )
    text = MINIMAL + f'spike_monitor: {{ros__parameters: {{{given}}}}}'
    assert parse(text, 'mine').criteria == Criteria(1.5, -1.0, 600.0, 2.0, 1.0, 3.0, 4.0)


# Overrides --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('override', 'node', 'parameter', 'value'),
    [
        ('plant.k:=3', 'plant', 'k', 3.0),
        ('/plant.k:=3', 'plant', 'k', 3.0),
        ('plant.k:=1e-3', 'plant', 'k', 1e-3),
        ('plant.x0:=[1, 2]', 'plant', 'x0', [1.0, 2.0]),
        ('plant.hold:=zero', 'plant', 'hold', 'zero'),
        ("plant.output:='y'", 'plant', 'output', 'y'),
        ('/**.rate:=50', 'plant', 'rate', 50.0),
        ('/**.rate:=50', 'controller', 'rate', 50.0),
        ('spike_monitor.threshold:=2', 'spike_monitor', 'threshold', 2.0),
    ],
)
def test_overrides(override, node, parameter, value):
    assert load('exact', [override]).nodes[node][parameter] == value


def test_later_overrides_win():
    def k(*overrides):
        nodes = load('exact', overrides).nodes
        return nodes['plant']['k'], nodes['controller']['k']

    assert k('plant.k:=3', 'plant.k:=4') == (4.0, 2.0)
    assert k('plant.k:=3', '/**.k:=4') == (4.0, 4.0)
    assert k('/**.k:=4', 'plant.k:=3') == (3.0, 4.0)
    assert k('/**.k:=4', '/**.k:=5') == (5.0, 5.0)


def test_overrides_do_not_outlive_their_scenario():
    load('exact', ['plant.k:=9'])
    assert load('exact').nodes['plant']['k'] == 1.0


@pytest.mark.parametrize(
    ('override', 'words'),
    [
        ('nonsense', "an override must be NODE.PARAM:=VALUE (plant.k:=2), got 'nonsense'"),
        ('plant.k=2', 'an override must be NODE.PARAM:=VALUE'),
        ('k:=2', 'an override must be NODE.PARAM:=VALUE'),
        ('plant.:=2', 'an override must be NODE.PARAM:=VALUE'),
        ('', 'an override must be NODE.PARAM:=VALUE'),
        ('controller.tau:=-1', 'controller.tau must be a finite number > 0, got -1'),
        ('plant.k:=', 'plant.k:= has no value; write it behind :='),
        ('plant.k:=[', 'plant.k:=[, line 2: not valid YAML'),
        ('plant.k:={a: 1}', 'a value must be a scalar or a list of them'),
        ('plant.k:=two', "plant.k must be a finite number >= 0, got 'two'"),
        ('plant.output:=yes', 'quote words that YAML takes for true or false'),
        ('plant.kk:=2', "plant has no parameter 'kk'; did you mean 'k'?"),
        ('reference.k:=2', "the scenario has no node 'reference'; it has exosystem, plant"),
        ('plnt.k:=2', "the scenario has no node 'plnt'; it has exosystem, plant"),
        ('/**.kk:=2', "/**.kk: no node has the parameter 'kk'; did you mean 'k'?"),
        ('/**.hold:=cubic', "hold must be one of zero, linear, got 'cubic'"),
        ('spike_monitor.reset:=3', 'spike_monitor.reset must be < threshold (1), got 3'),
        ('plant.k:=\udc80', 'it is not valid UTF-8'),  # a byte of the command line
    ],
)
def test_bad_overrides_are_one_line(override, words):
    with pytest.raises((ParameterError, ScenarioError)) as caught:
        load('exact', [override])
    message = str(caught.value)
    assert words in message
    assert '\n' not in message


@pytest.mark.parametrize('tool', [simulate, certificates, margins], ids=lambda tool: tool.__name__)
def test_offline_tools_refuse_links_instead_of_cutting_the_wire(tool):
    linked = load('exact').with_links(['u:delay=0.001'])
    with pytest.raises(ScenarioError, match='has link_u, and links are for real nodes only'):
        tool(linked)


@pytest.mark.parametrize(
    ('text', 'value'), [('1/16', 0.0625), ('-1/4', -0.25), ('1.5/3', 0.5), (' 2/5 ', 0.4)]
)
def test_a_command_line_takes_fractions(text, value):
    assert load('exact', [f'controller.k_y:={text}']).nodes['controller']['k_y'] == value


@pytest.mark.parametrize('text', ['1/0', '1/', '/2', '1/2/3', 'a/b'])
def test_what_is_no_fraction_is_refused(text):
    with pytest.raises(ParameterError, match=r'controller\.k must be a finite number >= 0'):
        load('exact', [f'controller.k:={text}'])


@pytest.mark.parametrize(
    ('override', 'words'),
    [
        ('plant.qos_overrides./yy.publisher.depth:=7', "no publisher of /yy; did you mean '/y'?"),
        ('plant.qos_overrides./y.subscription.depth:=7', 'no subscription of /y'),
        ('/**.qos_overrides./x.publisher.depth:=7', 'no publisher of /x'),
        ('plant.qos_overrides.y.publisher.depth:=7', 'write qos_overrides./y.publisher.depth'),
        ('plant.qos_overrides./y.publisher.lifespan:=7', "no policy 'lifespan'"),
        ('plant.qos_overrides./y.depth:=7', 'must be qos_overrides.TOPIC.publisher.POLICY'),
    ],
)
def test_a_qos_key_that_acts_on_nothing_is_refused(override, words):
    with pytest.raises(ParameterError) as caught:
        load('exact', [override])
    assert words in str(caught.value)


def test_qos_keys_have_the_resolved_name():
    text = 'r1/plant: {ros__parameters: {qos_overrides./y.publisher.depth: 3}}'
    assert 'y is /r1/y here; write qos_overrides./r1/y.publisher.depth' in complaint(text)
    text = text.replace('/y.', '/r1/y.')
    within = parse(text, 'mine').to_yaml(anywhere=True, namespace='/lab')
    assert within == (
        '/**/r1/plant:\n  ros__parameters: {qos_overrides./lab/r1/y.publisher.depth: 3}\n'
    )
    everybody = ['w.subscription', 'u.publisher']  # each of them of one node only
    load('exact', [f'/**.qos_overrides./{each}.depth:=7' for each in everybody])


@pytest.mark.parametrize('key', ['plant', '/plant', '/lab/plant', '/**/plant', '/*/plant', '/**'])
def test_a_further_file_may_name_nodes_with_their_namespace_or_without(key):
    scenario = with_file(load('exact'), f'{key}: {{ros__parameters: {{k: 3}}}}', 'more', '/lab')
    assert scenario.nodes['plant']['k'] == 3.0


def test_what_comes_later_in_a_file_wins_as_in_ros():
    text = 'plant: {ros__parameters: {k: 2}}\n/**: {ros__parameters: {k: 3}}\n'
    assert parse(text, 'mine').nodes['plant']['k'] == 3.0


def test_a_file_counts_from_the_file_that_names_it(tmp_path, monkeypatch):
    """From wherever it is read, and when it is written elsewhere; -p counts from here."""
    inner = tmp_path / 'inner'
    inner.mkdir()
    (inner / 'v.csv').write_text('t,v\n0,0.25\n')
    text = (
        '{}: {{ros__parameters: {{waveform: csv, file: v.csv}}}}\nplant: {{ros__parameters: {{}}}}'
    )
    monkeypatch.chdir(tmp_path)
    for key in ('stimulus', '/**/stimulus', '/r1/stimulus_2'):
        (inner / 'mine.yaml').write_text(text.format(key))
        scenario = load('inner/mine.yaml')
        (stimulus,) = scenario.stimuli.values()
        assert stimulus(3.0) == 0.25
        (again,) = parse(scenario.to_yaml(), 'copy').stimuli.values()
        assert again == stimulus
    more = with_file(load('open'), text.format('stimulus'), 'more', base=inner)
    assert more.nodes['stimulus']['file'] == str(inner / 'v.csv')
    given = load('open', ['stimulus.file:=inner/v.csv', 'stimulus.waveform:=csv'])
    assert given.nodes['stimulus']['file'] == str(inner / 'v.csv')


def test_a_file_of_another_package_is_its_own_matter():
    text = 'stimulus: {ros__parameters: {package: theirs, executable: x, file: v.csv}}'
    assert parse(text, 'mine').nodes['stimulus']['file'] == 'v.csv'


@pytest.mark.parametrize(
    ('key', 'topic'),
    [
        ('qos_overrides./yy.publisher.depth', '/y'),
        ('qos_overrides./y.publisher.depth', None),
        ('qos_overrides./w.publisher.depth', None),  # of another node, as below /**
        ('qos_overrides./yy.subscription.depth', None),
        ('k', None),
    ],
)
def test_a_qos_key_that_is_nearly_one_is_recognised(key, topic):
    endpoints = [Endpoint('y', '/y', 'publisher'), Endpoint('w', '/w', 'subscription')]
    assert misspelt(key, endpoints) == topic
