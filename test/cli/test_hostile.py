# SPDX-License-Identifier: Apache-2.0
"""Small inputs that would hang, fill the memory or end in a traceback: refused, or answered."""

import json
import os

import pytest

NODES = 'exosystem: {ros__parameters: {}}\nplant: {ros__parameters: {excitatory: [w, v]}}\n'

STIMULI = {
    'sine': '{waveform: sine, period: 1.0e-9, phase: -1.0e+308}',
    'square': '{waveform: square, period: 1.0e-9, phase: -1.0e+308}',
    'pulses': '{waveform: square, period: 1.0e-6, width: 5.0e-7}',
    'zero': '{waveform: csv, file: /dev/zero}',
    'fifo': '{waveform: csv, file: FIFO}',
    'onsets': f'{{waveform: pulses, onsets: [{", ".join(["1.0"] * 20_000)}]}}',
}


@pytest.fixture
def write(tmp_path):
    """Write a scenario with a stimulus, or a parameter of the plant; return its path."""

    def make(stimulus='', plant=''):
        text = NODES.replace('excitatory', f'{plant}, excitatory') if plant else NODES
        os.mkfifo(tmp_path / 'fifo')
        text += f'stimulus: {{ros__parameters: {stimulus}}}\n' if stimulus else ''
        (tmp_path / 'it.yaml').write_text(text.replace('FIFO', str(tmp_path / 'fifo')))
        return tmp_path / 'it.yaml'

    return make


@pytest.mark.parametrize(
    ('stimulus', 'more', 'words'),
    [
        ('sine', ['--sampled'], 'stimulus.phase must be a finite number >= -1e+09 and <= 1e+09'),
        ('square', [], 'stimulus.phase must be a finite number >= -1e+09 and <= 1e+09'),
        ('pulses', [], 'jumps 4e+07 times within 20 (model time)'),
        ('zero', [], "got '/dev/zero': it is a device; give a regular file"),
        ('fifo', ['--sampled'], 'it is a pipe; give a regular file'),
        ('onsets', [], 'a list of more than 10000 entries'),
    ],
)
def test_a_hostile_stimulus_is_refused(write, refused, stimulus, more, words):
    line = refused('simulate', write(STIMULI[stimulus]), '--duration', '20', *more)
    assert words in line
    assert len(line) <= 301


@pytest.mark.parametrize(
    ('plant', 'words'),
    [
        (f'x0: [{", ".join(["1.0"] * 100_000)}]', 'a list of more than 10000 entries'),
        (f'inhibitory: [{", ".join(f"s{i}" for i in range(300))}]', 'at most 256 strings'),
        ('time_scale: 1.0e-300', 'plant.time_scale must be a finite number >= 1e-09 and <= 1e+09'),
        (f'x{"y" * 900}: 1', 'plant has no parameter'),
        (f'output: {"y" * 100_000}.', 'must name relative topics'),
    ],
)
def test_a_hostile_parameter_is_refused(write, refused, plant, words):
    line = refused('simulate', write(plant=plant))
    assert words in line
    assert len(line) <= 301


@pytest.mark.slow
@pytest.mark.parametrize('more', [[], ['--sampled']])
def test_many_inputs_are_no_deep_recursion(eventreg, tmp_path, write, more):
    names = ', '.join(f's{i}' for i in range(256))
    path = write(plant=f'inhibitory: [{names}]')
    result = eventreg('simulate', path, '--duration', '2', *more)
    assert (result.returncode, result.stderr) == (3, '')


@pytest.mark.parametrize('more', [[], ['--sampled']])
def test_more_steps_than_fit_the_memory_are_refused_with_their_number(refused, more):
    line = refused('simulate', 'exact', '--duration', '1e6', '-p', '/**.rate:=1e5', *more)
    assert 'is more than ' in line
    assert ' steps, the most for this scenario' in line


@pytest.mark.slow
def test_exponents_that_would_take_for_ever_are_not_measured(eventreg, tmp_path):
    neuron = ['controller.model:=neuron', 'controller.x0:=[0.5,0.0]', 'controller.tau:=1e298']
    arguments = [word for override in neuron for word in ('-p', override)]
    result = eventreg('certify', 'exact', *arguments, '--json', tmp_path / 'x.json')
    assert (result.returncode, result.stderr) == (0, '')
    found = json.loads((tmp_path / 'x.json').read_text())['certificates']
    assert 'Not measured: the equations are too stiff' in json.dumps(found)


def test_exponents_are_not_averaged_for_ever(refused):
    assert 'at most 100000 of model time' in refused('certify', 'exact', '--time', '1e308')
