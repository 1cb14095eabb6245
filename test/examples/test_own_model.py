# SPDX-License-Identifier: Apache-2.0
"""The example of a model of one's own: simulated, compiled, certified, in lockstep."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

SCENARIO = Path(__file__).resolve().parents[2] / 'examples' / 'own_model' / 'van_der_pol.yaml'


@pytest.fixture(scope='module')
def run(installed):
    return installed('own_model')


@pytest.mark.slow
def test_it_is_rejected_and_meets_an_independent_integration(run):
    run('-m', 'eventreg_ros', 'simulate', SCENARIO, '--out', 'run.npz', '--json', 'run.json')
    assert json.loads((run.work / 'run.json').read_text())['verdict'] == 'rejected'
    data = np.load(run.work / 'run.npz')

    def rhs(t, s):
        w, p, c = s[:2], s[2:4], s[4:]
        return [
            3 * (w[0] - w[0] ** 3 / 3 - w[1]), w[0] / 3,
            p[0] - p[0] ** 3 / 3 - p[1] + (w[0] - c[0] - p[0]), (p[0] - p[1]) / 11,
            3 * (c[0] - c[0] ** 3 / 3 - c[1]) + 2 * p[0], c[0] / 3,
        ]  # fmt: skip

    start = [1.0, 0.0, 0.0, 0.0, 0.5, 0.5]
    t = data['t'][: 20 * 60 + 1]
    truth = solve_ivp(rhs, (0, 60), start, 'DOP853', t, rtol=1e-12, atol=1e-13).y
    for name, row in (('w', 0), ('y', 2), ('u', 4)):
        np.testing.assert_allclose(data[name][: len(t)], truth[row], rtol=0, atol=1e-6)


@pytest.mark.slow
def test_compiled_and_plain_agree_to_the_bit(run):
    pytest.importorskip('numba')
    code = f"""
from eventreg_ros.scenario import load
from eventreg_ros.simulation.sampled import SampledLoop
loop = SampledLoop(load({str(SCENARIO)!r}).loop)
plain, fast = (loop.run(50.0, compiled=c).signals for c in (False, True))
assert all((plain[s].view('i8') == fast[s].view('i8')).all() for s in plain)
"""
    run('-c', code)


@pytest.mark.slow
def test_its_jacobian_gives_an_exponent_and_its_own_parameters_are_checked(run):
    out = run('-m', 'eventreg_ros', 'certify', SCENARIO, '--time', '100').stdout
    assert 'largest conditional Lyapunov exponent' in out
    bad = ('-p', 'controller.mu:=0')
    err = run('-m', 'eventreg_ros', 'simulate', SCENARIO, *bad, code=2).stderr
    assert 'controller.mu must be a finite number > 0, got 0' in err


@pytest.mark.ros
def test_in_lockstep_the_nodes_give_the_bits_of_the_simulation(run):
    pytest.importorskip('rclpy', reason='needs ROS 2: pip install eventreg_ros[ros]')
    seconds, settle = ('--duration', '13'), ('--settle', '20')
    run('-m', 'eventreg_ros', 'run', SCENARIO, '--lockstep', *seconds, *settle, '--bag', 'bag')
    simulated = ('--sampled', '--duration', '130', *settle, '--bag', 'simulated')
    run('-m', 'eventreg_ros', 'simulate', SCENARIO, *simulated)
    code = """
from eventreg_ros.bags.reader import read_bag
a, b = (read_bag(bag).signals for bag in ('bag', 'simulated'))
assert set(a) == set(b) == {'w', 'y', 'u'}
assert all((a[s][1].view('i8') == b[s][1].view('i8')).all() for s in a)
"""
    run('-c', code)
