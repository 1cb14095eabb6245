# SPDX-License-Identifier: Apache-2.0
"""``eventreg identify``: from a bag or a scenario to a table, JSON, and a scenario that rejects."""

import json
import re

import pytest

from eventreg_ros.cli.main import main


@pytest.fixture
def bag(tmp_path, capsys):
    """The bag of a generator whose tau is 0.06, and of the plant that it disturbs."""
    path = tmp_path / 'recorded'
    code = main([
        'simulate', 'uncontrolled', '-p', 'exosystem.tau:=0.06', '--sampled', '--bag', str(path),
        '--duration', '260',
    ])  # fmt: skip
    assert code == 1
    capsys.readouterr()
    return path


@pytest.mark.slow
@pytest.mark.parametrize('signal', ['w', 'y'])
def test_from_a_bag_to_a_scenario_that_rejects(bag, tmp_path, capsys, signal):
    found, made = tmp_path / 'found.json', tmp_path / 'made.yaml'
    given = ['--from-signal', signal, '--json', str(found), '--out', str(made)]
    assert main(['identify', str(bag), *given]) == 0
    printed = capsys.readouterr()
    assert printed.err == ''
    assert printed.out.startswith(f'{signal}: 5201 samples over 260 of model time')
    tau = re.search(r'^tau     (\S+) = 1/(\S+); 95 %: (\S+) to (\S+)$', printed.out, re.MULTILINE)
    assert float(tau[1]) == pytest.approx(0.06, rel=1e-6)
    assert float(tau[2]) == pytest.approx(1 / 0.06, rel=1e-6)
    assert float(tau[3]) < 0.06 < float(tau[4])
    assert 'not identifiable: in antiphase the coupling cancels' in printed.out
    data = json.loads(found.read_text())
    assert list(data) == [
        'tau', 'tau_sd', 'k', 'k_sd', 'identifiable', 'period', 'residual_rms', 'signal',
    ]  # fmt: skip
    assert data['tau'] == pytest.approx(0.06, rel=1e-6)
    assert (data['k'], data['identifiable']) == (None, {'tau': True, 'k': False})
    assert data['signal'] == signal
    assert main(['simulate', str(made)]) == 0
    assert 'verdict: rejected' in capsys.readouterr().out


@pytest.mark.slow
def test_a_scenario_with_overrides_and_k(capsys):
    start = '-p', 'exosystem.x0:=[1.0, 0.5, 0.3, 0.2]', '-p', 'exosystem.k:=1.5'
    assert main(['identify', 'exact', *start]) == 0
    assert '\nk       1.5' in capsys.readouterr().out


@pytest.mark.slow
def test_two_generators_in_one_signal(tmp_path, capsys):
    found = tmp_path / 'found.json'
    assert main(['identify', 'two_generators', '--generators', '2', '--json', str(found)]) == 0
    data = json.loads(found.read_text())
    taus = [data['tau'], *(other['tau'] for other in data['others'])]
    assert taus == pytest.approx([1 / 19, 1 / 12], rel=1e-6)
    assert capsys.readouterr().out.count('\ntau ') == 2


@pytest.mark.slow
def test_what_cannot_be_is_one_line(bag, refused, tmp_path):
    assert 'changes a scenario' in refused('identify', bag, '-p', 'exosystem.tau:=0.1')
    assert 'no sample of u' in refused('identify', bag, '--from-signal', 'u')
    assert 'too few periods' in refused('identify', bag, '--until', '60')
    assert 'shows no spikes' in refused('identify', 'quiescent')
    assert '--generators' in refused('identify', bag, '--generators', '0')
    nowhere = tmp_path / 'no' / 'made.yaml'
    assert 'cannot write' in refused('identify', bag, '--out', nowhere)
    there = nowhere.parent.parent / 'there.yaml'
    there.touch()
    assert 'exists already' in refused('identify', bag, '--out', there)
    made = tmp_path / 'made.yaml'
    assert 'not separable' in refused('identify', bag, '--generators', '2', '--out', made)
    assert not made.exists()
