# SPDX-License-Identifier: Apache-2.0
"""The library: ``from eventreg_ros import ...``."""

import json

import numpy as np
import pytest

import eventreg_ros
from eventreg_ros import certificates, events, judge, load, simulate
from eventreg_ros.analysis.events import detect
from eventreg_ros.analysis.report_json import as_json
from eventreg_ros.cli.main import main
from eventreg_ros.errors import EventregError, ParameterError, ScenarioError
from eventreg_ros.simulation.continuous import simulate as continuous
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.sampled import simulate_sampled
from eventreg_ros.theory.certify import certify


@pytest.fixture(scope='module')
def exact():
    return simulate('exact', 200.0)


@pytest.mark.slow
def test_importing_the_package_does_not_import_the_library(python):
    code = (
        'import sys, eventreg_ros; before = set(sys.modules); eventreg_ros.load;'
        'print("eventreg_ros.api" in before, "numpy" in before, "eventreg_ros.api" in sys.modules)'
    )
    assert python('-c', code).stdout.split() == ['False', 'False', 'True']


def test_every_public_name_is_there_and_documented():
    for name in eventreg_ros.__all__:
        assert getattr(eventreg_ros, name).__doc__
        assert name in dir(eventreg_ros)
    assert set(eventreg_ros.__all__) == set(eventreg_ros.api.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match='nonsense'):
        _ = eventreg_ros.nonsense


def test_public_names_are_not_hidden_by_submodules(python):
    # A submodule of the same name would take its place once it is imported.
    code = (
        'import pkgutil, eventreg_ros;'
        'print({m.name for m in pkgutil.iter_modules(eventreg_ros.__path__)}'
        ' & set(eventreg_ros.__all__))'
    )
    assert python('-c', code).stdout == 'set()\n'


@pytest.mark.slow
@pytest.mark.parametrize('more', [{}, {'sampled': True, 'delay': 0.1, 'loss': 0.1, 'seed': 3}])
def test_the_report_is_that_of_the_command(tmp_path, more, capsys):
    run = simulate(load('mismatch', 'controller.k:=4'), 150.0, **more)
    flags = [f'--{k}' if v is True else f'--{k}={v}' for k, v in more.items()]
    out = tmp_path / 'report.json'
    arguments = ['simulate', 'mismatch', '-p', 'controller.k:=4', '--duration', '150']
    assert main([*arguments, *flags, '--json', str(out)]) in (0, 1, 3)
    assert json.loads(out.read_text()) == json.loads(json.dumps(as_json(run.report)))
    assert str(run) + '\n' == capsys.readouterr().out


def test_a_continuous_run_is_on_the_grid_of_the_nodes(exact):
    loop = load('exact').loop
    direct = continuous(loop, 200.0)
    np.testing.assert_allclose(exact.t, direct.t, rtol=0.0, atol=1e-12)
    assert exact.t[1] == pytest.approx(loop.blocks['plant'].h)
    for name, x in direct.signals.items():
        np.testing.assert_allclose(exact[name], x, rtol=0.0, atol=1e-9)


def test_a_sampled_run_is_the_sampled_simulation_to_the_bit():
    scenario = load('open')
    run = simulate(scenario, 100.0, sampled=True, jitter=0.2, seed=1)
    direct = simulate_sampled(scenario.loop, 100.0, Impairment(jitter=0.2, seed=1))
    assert list(run.signals) == list(direct.signals)
    for name, x in direct.signals.items():
        np.testing.assert_array_equal(run[name], x)


def test_a_run_knows_its_events_and_verdict(exact):
    assert exact.verdict == exact.report.verdict == 'rejected'
    assert exact.events['y'] == []
    found = detect(exact.fine.t, exact.fine.signals['w'])
    assert exact.events['w'] == found
    assert all(type(t) is float for t in exact.events['w'])
    assert repr(exact) == '<Run of exact: w, y, u; 200 of model time; rejected>'
    with pytest.raises(KeyError, match='there are w, y, u'):
        exact['nonsense']
    assert (list(exact), len(exact), 'y' in exact, 'v' in exact) == (
        ['w', 'y', 'u'],
        3,
        True,
        False,
    )
    assert list(dict(exact)) == list(exact.keys())


def test_too_short_a_run_is_undecided():
    assert simulate('exact', 110.0).verdict == 'undecided'


def test_events_and_judge_take_their_own_limits(exact):
    assert events(exact.t, exact['w'], 1.0, 0.0) == detect(exact.t, exact['w'])
    assert len(events(exact.t, exact['w'], threshold=1.95)) == 0
    report = judge(exact, settle=0.0)
    assert report.settle == 0.0
    assert report.rejection.disturbance_events == len(exact.events['w'])
    assert report.verdict == 'rejected'


def test_the_scenario_decides_what_an_event_is():
    run = simulate(load('linear', 'spike_monitor.threshold:=0.9'), 60.0)
    assert run.events['w'] == detect(run.fine.t, run.fine.signals['w'], 0.9, 0.0)


def test_the_stimulus_goes_by_the_name_that_the_scenario_gives_it():
    run = simulate(load('open', 'stimulus.output:=drive'), 70.0)
    assert run['drive'].max() == 1.5
    assert np.abs(run['y_r']).max() == 0.0  # nobody publishes v any more


@pytest.mark.slow
def test_certificates_are_those_of_certify():
    assert certificates('linear') == certify(load('linear').loop)


def test_bad_input_raises_what_the_commands_report():
    with pytest.raises(ParameterError, match=r'controller\.tau'):
        load('exact', 'controller.tau:=-1')
    with pytest.raises(ScenarioError, match='no scenario'):
        simulate('nonsense')
    with pytest.raises(EventregError, match='duration'):
        simulate('exact', -1.0)
    with pytest.raises(EventregError, match="did you mean 'exact'"):
        simulate('exat')
    with pytest.raises(EventregError, match="or take the shipped 'exact'"):
        simulate('exact.yaml')
    with pytest.raises(EventregError, match=r"overrides are a dictionary .* got \['plant.k:=2'\]"):
        simulate('exact', ['plant.k:=2'])
    with pytest.raises(EventregError, match='a scenario is one of'):
        simulate(3)
    with pytest.raises(EventregError, match="duration must be a number, of model time, got 'x'"):
        simulate('exact', duration='x')
    with pytest.raises(EventregError, match='loss'):
        simulate('exact', 10.0, sampled=True, loss=2.0)


def test_impairments_belong_to_a_sampled_simulation():
    with pytest.raises(EventregError, match='add sampled=True'):
        simulate('exact', 10.0, delay=0.6)


@pytest.mark.slow
def test_the_examples_of_the_docstrings_run():
    import doctest

    shown, runner = set(), doctest.DocTestRunner()
    for name in eventreg_ros.__all__:
        public = getattr(eventreg_ros, name)
        for test in doctest.DocTestFinder(recurse=False).find(public, name):
            globs = {each: getattr(eventreg_ros, each) for each in eventreg_ros.__all__}
            test.globs.update(globs)
            runner.run(test)
            shown |= {name} if test.examples else set()
    functions = {x for x in eventreg_ros.__all__ if not isinstance(getattr(eventreg_ros, x), type)}
    assert functions - shown == set()
    assert runner.failures == 0
    assert runner.tries >= 12


@pytest.mark.slow
def test_results_are_short_in_a_list_and_tables_when_printed(exact, tmp_path):
    from eventreg_ros import analyze, border, compare, identify, read_bag, sweep

    over = {'exosystem.tau': '1/20..1/12/9', 'controller.k': '0.7..1/9'}
    main(['simulate', 'exact', '--sampled', '--duration', '250', '--bag', str(tmp_path / 'bag')])
    found = [
        exact,
        exact.report,
        exact.scenario,
        compare('exact', 'mismatch'),
        identify('exact'),
        sweep('exact', {'controller.k': [1, 2]}),
        analyze(tmp_path / 'bag'),
        read_bag(tmp_path / 'bag'),
        border('exact', over, *over),
        certificates('linear')[0],
    ]
    for each in found:
        assert '\n' not in repr(each)
        assert len(repr(each)) < 200
    for each in found[1:2] + found[3:7]:
        assert len(str(each).splitlines()) > 2
        assert str(each).splitlines()[0] in each._repr_html_()


def test_a_run_is_saved_in_what_other_programs_read(exact, tmp_path):
    exact.save(tmp_path / 'run.npz')
    with np.load(tmp_path / 'run.npz') as saved:
        np.testing.assert_array_equal(saved['t'], exact.t)
        np.testing.assert_array_equal(saved['y'], exact['y'])
    with pytest.raises(EventregError, match='must end in'):
        exact.save(tmp_path / 'run.xls')


def test_overrides_are_dictionaries_or_texts():
    numpy = {'controller.k': np.int64(3), 'plant.x0': np.array([0.5, 0.0])}
    run = simulate('exact', numpy, np.int64(20))
    assert run.scenario.nodes['controller']['k'] == 3.0
    assert run['y'][0] == 0.5
    assert simulate('exact', np.float32(20)).t[-1] == run.t[-1] == 20.0
    text = simulate('exact', 'controller.k:=3', 20.0)
    assert text.scenario.nodes['controller']['k'] == 3.0
    scenario = load('exact', {'controller.k': 3, '/**.rate': 100.0}, 'plant.tau:=1/10')
    assert scenario.nodes['controller']['k'] == 3.0
    assert scenario.rate == 100.0
    assert scenario.nodes['plant']['tau'] == 0.1
    assert simulate('exact', {'controller.k': 3}, 20.0).scenario.nodes['controller']['k'] == 3.0
    with pytest.raises(EventregError, match=r'NODE\.PARAM'):
        load('exact', {'k': 3})
    with pytest.raises(EventregError, match='no node'):
        load('exact', {'contoller.k': 3})


def test_a_bag_is_read_and_judged_like_a_run(tmp_path):
    from eventreg_ros import analyze, read_bag
    from eventreg_ros.cli.main import main

    main(['simulate', 'exact', '--sampled', '--duration', '250', '--bag', str(tmp_path / 'bag')])
    found, run = analyze(tmp_path / 'bag'), simulate('exact', 250.0, sampled=True)
    assert (found.verdict, found.events, found.reason) == (run.verdict, run.events, run.reason)
    np.testing.assert_array_equal(found['y'], run['y'])
    np.testing.assert_allclose(found.t, run.t, atol=1e-7)
    assert 'rejected' in found._repr_html_()
    assert 'w, y, u' in repr(found).replace('v, ', '')
    read = read_bag(tmp_path / 'bag')
    assert set(read.signals) == set(read.recording.signals) == {'w', 'y', 'u'}
    assert (read.signals['y'] == found.signals['y']).all()
    assert (read.t == found.t).all()
    assert read.events == found.events
    assert (read.verdict, read.reason, read.findings) == (found.verdict, found.reason, [])
