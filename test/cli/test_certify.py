# SPDX-License-Identifier: Apache-2.0
"""``eventreg certify`` says of each shipped scenario what the paper says."""

import json
import subprocess
import sys

import pytest

from eventreg_ros import scenario
from eventreg_ros.cli import certify as verb
from eventreg_ros.cli.main import main
from eventreg_ros.theory import certify as certificates
from eventreg_ros.theory.floquet import Floquet
from eventreg_ros.theory.lyapunov import Exponent

THEORY = {
    'exact': {
        'exosystem lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'controller lemma_2': 'pass',
        'controller internal_model': 'pass',
        'controller gain_and_delay': 'none',
    },
    'mismatch': {
        'exosystem lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'controller lemma_2': 'pass',
        'controller internal_model': 'fail',
        'controller gain_and_delay': 'none',
    },
    'open': {
        'exosystem lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'controller lemma_2': 'pass',
        'reference lemma_1': 'pass',
        'plant and reference error_system': 'marginal',
        'reference reference_copy': 'fail',
        'controller internal_model': 'fail',
        'controller gain_and_delay': 'none',
    },
    'uncontrolled': {
        'exosystem lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'exosystem internal_model': 'fail',
    },
    'quiescent': {
        'plant lemma_1': 'marginal',
        'controller lemma_2': 'pass',
        'controller gain_and_delay': 'none',
    },
    'single_neuron': {
        'exosystem lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'controller lemma_1': 'pass',
        'controller internal_model': 'fail',
        'controller single_neuron': 'fail',
    },
    'linear': {
        'controller internal_model': 'pass',
        'linear loop hurwitz': 'pass',
        'linear loop francis': 'pass',
    },
    'morris_lecar': {'controller internal_model': 'pass'},
    'late': {
        'exosystem lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'controller lemma_2': 'pass',
        'controller internal_model': 'pass',
        'controller learning': 'pass',
        'controller gain_and_delay': 'none',
    },
    'two_generators': {
        'exosystem lemma_2': 'pass',
        'exosystem_2 lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'controller lemma_2': 'pass',
        'controller_2 lemma_2': 'pass',
        'exosystem internal_model': 'pass',
        'exosystem_2 internal_model': 'pass',
    },
    'unknown': {
        'exosystem lemma_2': 'pass',
        'exosystem_2 lemma_2': 'pass',
        'plant lemma_1': 'marginal',
        'controller lemma_2': 'pass',
        'controller_2 lemma_2': 'pass',
        'exosystem internal_model': 'none',
        'exosystem_2 internal_model': 'none',
        'controller learning': 'pass',
        'controller_2 learning': 'pass',
    },
}
EXPONENTS = {
    'exact': ['driven', 'quiet'],
    'mismatch': ['driven', 'quiet'],
    'open': ['driven', 'driven_by_v', 'quiet'],
    'uncontrolled': ['driven', 'quiet'],
    'quiescent': ['quiet'],
    'single_neuron': ['driven', 'quiet'],
    'linear': ['driven', 'quiet'],
    'morris_lecar': ['driven', 'quiet'],
    'late': ['driven', 'quiet'],
    'two_generators': ['driven', 'quiet'],
    'unknown': ['driven', 'quiet'],
}


@pytest.fixture
def no_multipliers(monkeypatch):
    """For tests of what does not depend on the multipliers, which have a test of their own."""
    found = Floquet(37.5, (0.02 + 0.0j,))
    monkeypatch.setattr('eventreg_ros.theory.certify.floquet', lambda loop: found)


@pytest.fixture
def no_integration(monkeypatch, no_multipliers):
    """For tests of what does not depend on the exponents."""

    def exponent(loop, time):
        return Exponent(-0.1, 0.01, (-0.1,) * 5, time)

    monkeypatch.setattr('eventreg_ros.theory.certify.conditional_exponent', exponent)


def certify(tmp_path, *words):
    """Run the command; return its certificates by subject and claim."""
    file = tmp_path / 'certificates.json'
    assert main(['certify', *words, '--json', str(file)]) == 0
    found = json.loads(file.read_text())
    assert found['scenario'] == words[0]
    return {f'{c["subject"]} {c["claim"]}': c for c in found['certificates']}


def by_claim(found):
    return {certificate['claim']: certificate for certificate in found.values()}


def test_the_tables_cover_every_shipped_scenario():
    assert sorted(THEORY) == sorted(EXPONENTS) == scenario.shipped()


@pytest.mark.slow
@pytest.mark.usefixtures('no_multipliers')
@pytest.mark.parametrize('name', THEORY)
def test_theory(name, tmp_path):
    found = certify(tmp_path, name, '--time', '20')
    measured = ('input_induced_contraction', 'floquet')
    theory = {key: c['status'] for key, c in found.items() if c['claim'] not in measured}
    exponents = [key for key in theory if 'exponent' in key]
    assert [key.rsplit('exponent_')[1] for key in exponents] == EXPONENTS[name]
    assert {key: theory[key] for key in theory if key not in exponents} == THEORY[name]


@pytest.mark.slow
def test_exact_contracts_because_of_w(tmp_path, capsys):
    found = by_claim(certify(tmp_path, 'exact'))
    driven, quiet = found['exponent_driven'], found['exponent_quiet']
    assert driven['status'] == 'pass'
    assert driven['value'] + driven['numbers']['half_width'] < -0.05
    assert quiet['status'] == 'none'
    assert abs(quiet['value']) < quiet['numbers']['half_width'] < 0.01
    assert found['input_induced_contraction']['status'] == 'pass'
    assert found['floquet']['value'] == pytest.approx(-0.102246, abs=1e-6)
    assert abs(found['floquet']['value'] - driven['value']) < driven['numbers']['half_width']
    text = capsys.readouterr().out
    assert 'marginal  plant: Lemma 1 (contraction), rate 0\n' in text
    assert 'only just misses Lemma 1' in text
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.usefixtures('no_integration')
def test_numbers_of_the_lemmas(tmp_path):
    found = certify(tmp_path, 'open')
    reference, plant = found['reference lemma_1'], found['plant lemma_1']
    assert reference['value'] == pytest.approx(1 / 13)
    assert reference['numbers']['largest_eigenvalue'] == pytest.approx(-1.0)
    assert plant['value'] == plant['numbers']['largest_eigenvalue'] == 0.0
    copy = found['controller internal_model']['numbers']
    assert (copy['k'], copy['tau']) == pytest.approx((3.0, 12 / 15 - 1))
    copy = found['reference reference_copy']['numbers']
    assert (copy['k'], copy['tau']) == pytest.approx((2.0, 11 / 13 - 1))


@pytest.mark.usefixtures('no_integration')
def test_own_parameters_change_what_is_said(tmp_path):
    found = certify(tmp_path, 'exact', '-p', 'plant.k:=1.5', '-p', 'controller.k:=3')
    assert found['plant lemma_1']['status'] == 'pass'
    assert found['plant lemma_1']['value'] == pytest.approx(1 / 11)
    assert found['controller internal_model']['status'] == 'pass'
    assert 'k by +50 %' in found['controller internal_model']['text']
    found = certify(
        tmp_path, 'exact', '-p', 'plant.k:=0.5', '-p', 'exosystem.k:=0.4', '--time', '5'
    )
    assert found['plant lemma_1']['status'] == found['exosystem lemma_2']['status'] == 'none'
    assert found['plant lemma_1']['value'] is None


@pytest.mark.usefixtures('no_integration')
@pytest.mark.parametrize(
    ('k', 'words'), [(2, 'k = 2 > 1'), (0.95, '1 - tau = 0.9'), (0.5, 'orbit')]
)
def test_single_neuron_fails_for_a_reason_that_fits(k, words, tmp_path):
    found = certify(tmp_path, 'single_neuron', '-p', f'controller.k:={k}')
    certificate = found['controller single_neuron']
    assert certificate['status'] == 'fail'
    assert words in certificate['text']


@pytest.mark.usefixtures('no_integration')
def test_linear_with_k_y_is_beyond_the_condition_of_the_paper(tmp_path):
    """K = (0.5, 1.5): not allowed by the paper's condition, but Hurwitz with k_y = 1."""
    gains = ['-p', 'controller.gain:=[0.5, 1.5]', '--time', '5']
    plain = by_claim(certify(tmp_path, 'linear', *gains))['hurwitz']
    assert plain['status'] == 'fail'
    assert plain['numbers']['paper_condition'] is plain['numbers']['routh_hurwitz'] is False
    direct = by_claim(certify(tmp_path, 'linear', *gains, '-p', 'controller.k_y:=1'))['hurwitz']
    assert direct['status'] == 'pass'
    assert direct['numbers']['paper_condition'] is None
    assert direct['numbers']['routh_hurwitz'] is True


@pytest.mark.slow
def test_linear_that_diverges_is_said_to(tmp_path):
    found = by_claim(certify(tmp_path, 'linear', '-p', 'controller.gain:=[-1.0, 0.5]'))
    for claim in ('hurwitz', 'francis', 'exponent_driven'):
        assert found[claim]['status'] == 'fail'
    assert 'diverges' in found['exponent_driven']['text']
    assert found['exponent_driven']['value'] is None


@pytest.mark.usefixtures('no_integration')
def test_another_wiring_has_no_theory_of_the_loop(tmp_path):
    swapped = ['-p', "controller.excitatory:=['w']", '-p', "controller.inhibitory:=['y']"]
    found = by_claim(certify(tmp_path, 'exact', *swapped))
    assert found['wiring']['status'] == 'none'
    assert not {'internal_model', 'hurwitz'}.intersection(found)
    unused = ['-p', "plant.excitatory:=['w', 'nobody']"]
    assert 'wiring' not in by_claim(certify(tmp_path, 'exact', *unused))


@pytest.mark.slow
@pytest.mark.parametrize(
    'words',
    [['exact', '--time', '0'], ['nonsense'], ['exact', '-p', 'plant.k:=-1'],
     ['exact', '--time', '5', '--json', '/nowhere/f.json']],
)  # fmt: skip
def test_bad_input_is_one_line_and_exit_code_2(words, refused):
    refused('certify', *words)


@pytest.mark.slow
@pytest.mark.usefixtures('no_integration')
@pytest.mark.usefixtures('no_integration')
def test_every_claim_has_a_title_and_is_documented(tmp_path):
    claims = set()
    for name in THEORY:
        claims |= set(by_claim(certify(tmp_path, name)))
    assert claims | {'wiring'} == set(verb.TITLES)
    assert all(f'``{claim}``' in verb.__doc__ for claim in verb.TITLES)


@pytest.mark.usefixtures('no_integration')
def test_a_certificate_prints_as_one_line():
    found = [str(c) for c in certificates.certify(scenario.load('exact').loop)]
    assert found[1].startswith('marginal: plant, lemma_1: k = 1 only just misses Lemma 1')
    assert not any('\n' in line for line in found)


@pytest.mark.slow
def test_needs_no_ros():
    code = (
        'import sys; from eventreg_ros.cli.main import main; main(["certify", "quiescent", '
        '"--time", "1"]); sys.exit(any(name.startswith("rclpy") for name in sys.modules))'
    )
    subprocess.run([sys.executable, '-c', code], check=True, capture_output=True)
