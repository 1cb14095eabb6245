# SPDX-License-Identifier: Apache-2.0
"""Any number of blocks: several generators and controllers on one plant, several plants, robots."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eventreg_ros import scenario as scenarios
from eventreg_ros.errors import ScenarioError
from eventreg_ros.simulation.continuous import simulate
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.sampled import SampledLoop

STARTS = ([1.0, 0.0, -1.0, 0.0], [-0.4, 0.6, 0.9, -0.3], [0.2, -0.7, -1.1, 0.4])
TAUS = (1 / 12, 1 / 19, 1 / 8)


def bank(generators, controllers=None):
    """A scenario of so many generators, and controllers like them, on one plant."""
    controllers = generators if controllers is None else controllers
    names = ['', '_2', '_3']
    lines = []
    for i in range(generators):
        lines.append(f'exosystem{names[i]}: {{ros__parameters: '
                     f'{{k: 2.0, tau: {TAUS[i]!r}, x0: {STARTS[i]}}}}}')  # fmt: skip
    for i in range(controllers):
        lines.append(f'controller{names[i]}: {{ros__parameters: {{k: 2.0, tau: {TAUS[i]!r}}}}}')
    w, u = ([f'{s}{n}' for n in names[:m]] for s, m in (('w', generators), ('u', controllers)))
    lines.append(f'plant: {{ros__parameters: {{excitatory: {w}, inhibitory: {u}}}}}')
    return scenarios.parse('\n'.join(lines), 'bank')


def by_hand(generators, t):
    """The bank written down again, in vectors: voltages and recoveries of w, u and y."""
    n = generators
    tau = np.array(TAUS[:n])

    def rhs(_, s):
        w, u, p = s[: 4 * n].reshape(4, n), s[4 * n : 8 * n].reshape(4, n), s[8 * n :]
        cubic = lambda x: x - x**3 / 3  # noqa: E731
        dw = [cubic(w[0]) - w[1] - 2 * (w[2] + w[0]), tau * (w[0] - w[1]),
              cubic(w[2]) - w[3] - 2 * (w[0] + w[2]), tau * (w[2] - w[3])]  # fmt: skip
        du = [cubic(u[0]) - u[1] + 2 * (p[0] - u[2] - u[0]), tau * (u[0] - u[1]),
              cubic(u[2]) - u[3] - 2 * (u[0] + u[2]), tau * (u[2] - u[3])]  # fmt: skip
        dp = [cubic(p[0]) - p[1] + (w[0].sum() - u[0].sum() - p[0]), (p[0] - p[1]) / 11]
        return np.concatenate([*dw, *du, dp])

    w0 = np.array(STARTS[:n]).T.ravel()
    u0 = np.repeat([0.5, 0.0, -0.5, 0.0], n)
    start = np.concatenate([w0, u0, [0.0, 0.0]])
    return solve_ivp(rhs, (0, t[-1]), start, 'DOP853', t, rtol=1e-12, atol=1e-13).y


@pytest.mark.slow
@pytest.mark.parametrize('generators', [2, 3])
def test_a_bank_meets_an_independent_integration(generators):
    found = simulate(bank(generators).loop, 200.0)
    truth = by_hand(generators, found.t)
    np.testing.assert_allclose(found.signals['y'], truth[8 * generators], rtol=0, atol=1e-6)
    for i, suffix in enumerate(('', '_2', '_3')[:generators]):
        np.testing.assert_allclose(found.signals[f'w{suffix}'], truth[i], rtol=0, atol=1e-6)
        u = truth[4 * generators + i]
        np.testing.assert_allclose(found.signals[f'u{suffix}'], u, rtol=0, atol=1e-6)


@pytest.mark.slow
def test_each_controller_finds_its_generator_and_y_vanishes():
    found = simulate(bank(2).loop, 1500.0)
    late = found.t >= 1490.0
    assert np.abs(found.signals['y'][late]).max() < 1e-9
    for suffix in ('', '_2'):
        difference = found.signals[f'w{suffix}'] - found.signals[f'u{suffix}']
        assert np.abs(difference[late]).max() < 1e-9


@pytest.mark.slow
def test_a_generator_without_a_controller_stays():
    found = simulate(bank(2, 1).loop, 1500.0)
    assert np.abs(found.signals['y'][found.t >= 1400.0]).max() > 1.0


def test_compiled_has_the_bits_of_plain_for_a_bank():
    pytest.importorskip('numba')
    loop = SampledLoop(bank(3).loop)
    impaired = Impairment(delay=0.1, loss=0.1, jitter=0.1, seed=3)
    plain, fast = (loop.run(40.0, impaired, compiled=c).signals for c in (False, True))
    for name in plain:
        np.testing.assert_array_equal(plain[name].view(np.int64), fast[name].view(np.int64))


def test_a_suffix_goes_into_the_output_and_nowhere_else():
    made = scenarios.parse(
        'plant_left: {ros__parameters: {}}\nreference_left: {ros__parameters: {}}\n'
        'controller_b: {ros__parameters: {}}\nstimulus_2: {ros__parameters: {}}\n'
        'spike_monitor_x: {ros__parameters: {}}',
        'names',
    )
    assert made.publishers == {
        'y_left': 'plant_left', 'y_r_left': 'reference_left', 'u_b': 'controller_b',
        'v_2': 'stimulus_2',
    }  # fmt: skip
    assert made.nodes['plant_left']['excitatory'] == ['w', 'v']
    assert made.nodes['controller_b']['inhibitory'] == ['y_r']
    assert made.loop.reference_of('plant_left').output == 'y_r_left'
    with pytest.raises(ScenarioError, match="no node 'plants'"):
        scenarios.parse('plants: {ros__parameters: {}}', 'names')


ROBOTS = """
/r1/exosystem: {ros__parameters: {}}
/r1/plant: {ros__parameters: {}}
r2:
  exosystem: {ros__parameters: {tau: 0.05}}
  plant: {ros__parameters: {k: 2}}
/**/plant: {ros__parameters: {tau: 0.1}}
/r2/*: {ros__parameters: {rate: 100.0}}
/r1/**: {ros__parameters: {rate: 100.0}}
"""


def test_namespaces_are_read_as_ros_reads_them():
    robots = scenarios.parse(ROBOTS, 'robots')
    assert set(robots.nodes) == {'r1/exosystem', 'r1/plant', 'r2/exosystem', 'r2/plant'}
    assert set(robots.publishers) == {'r1/w', 'r1/y', 'r2/w', 'r2/y'}
    assert [robots.nodes[f'{r}/plant']['k'] for r in ('r1', 'r2')] == [1.0, 2.0]
    assert {robots.nodes[f'{r}/plant']['tau'] for r in ('r1', 'r2')} == {0.1}
    assert robots.rate == 100.0
    again = scenarios.parse(robots.to_yaml(), 'robots')
    assert again.nodes == robots.nodes


def test_two_robots_stay_apart():
    robots = scenarios.parse(ROBOTS, 'robots')
    both = SampledLoop(robots.loop).run(30.0).signals
    for robot, tau, k in (('r1', 1 / 12, 1.0), ('r2', 0.05, 2.0)):
        overrides = [f'exosystem.tau:={tau!r}', f'plant.k:={k}', 'plant.tau:=0.1', '/**.rate:=100']
        alone = SampledLoop(scenarios.load('uncontrolled', overrides).loop).run(30.0).signals
        for signal in ('w', 'y'):
            np.testing.assert_array_equal(both[f'{robot}/{signal}'], alone[signal])
