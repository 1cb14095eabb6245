# SPDX-License-Identifier: Apache-2.0
"""Texts of all kinds: read as they are meant, or refused by an error of ours; written and read."""

import math

import numpy as np
import pytest

from eventreg_ros import api
from eventreg_ros.errors import EventregError
from eventreg_ros.scenario import Override, Scenario, load, parse, ros_yaml, shipped
from eventreg_ros.scenario.interventions import Intervention, read_all
from eventreg_ros.scenario.links import OPTIONS, LinkSpec
from eventreg_ros.scenario.parameters import parameters_of
from eventreg_ros.scenario.rcl_scalar import scalar

pytestmark = pytest.mark.slow

hypothesis = pytest.importorskip('hypothesis')
given, st = hypothesis.given, hypothesis.strategies

TEXT = st.text(st.characters(codec='utf-8', exclude_characters='\x00'))
NAMES = st.from_regex(r'[A-Za-z_][A-Za-z0-9_]{0,8}', fullmatch=True)
WORDS = st.sampled_from(
    ['y', 'n', 'Y', 'N', 'yes', 'no', 'on', 'off', 'true', 'null', 'nan', 'inf', 'e1', 'None', '_']
)
SIGNALS = NAMES | WORDS
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


def one_error(read, text):
    """What is read of a text; None where it is refused."""
    try:
        return read(text)
    except EventregError:
        return None


# What is typed ------------------------------------------------------------------------------------


@given(text=TEXT | st.from_regex(r'[0-9.einf-]{0,6}:[a-z/]{0,5}[.:][a-z]{0,9}(:=.*)?'))
def test_any_text_for_at_is_read_or_refused(text):
    found = one_error(Intervention.read, text)
    if found is not None:
        assert found.text == text
        assert 0.0 <= found.at < math.inf
        assert found.node in text
        assert found.action in ('set', 'activate', 'deactivate')
        one_error(lambda each: read_all([each], load('exact')), text)


@given(at=st.floats(0.0, 1e9), node=NAMES, parameter=NAMES, value=st.floats(1e-9, 1e9))
def test_what_at_says_is_what_is_done(at, node, parameter, value):
    text = f'{at!r}:{node}.{parameter}:={value!r}'
    assert Intervention.read(text) == (text, at, node, 'set', parameter, value)
    for word in ('activate', 'deactivate'):
        assert Intervention.read(f'{at!r}:/{node}:{word}')[1:4] == (at, node, word)


@given(text=TEXT | st.from_regex(r'[uy]:([a-z]{0,6}=[0-9.e-]{0,4},?){0,3}'))
def test_any_text_for_link_is_read_or_refused(text):
    found = one_error(LinkSpec.read, text)
    if found is not None:
        assert text.startswith(f'{found.signal}:') or text == found.signal
        assert found.options.keys() <= OPTIONS.keys()
        one_error(lambda link: load('exact').with_links([link]), text)


@given(
    signal=SIGNALS,
    options=st.fixed_dictionaries(
        {}, optional={'delay': st.floats(0.0, 10.0), 'jitter': st.floats(0.0, 10.0),
                      'loss': st.floats(0.0, 1.0), 'seed': st.integers(0, 2**31)},
    ),
)  # fmt: skip
def test_what_link_says_is_what_the_link_does(signal, options):
    text = f'{signal}:{",".join(f"{name}={value!r}" for name, value in options.items())}'
    assert LinkSpec.read(text) == (signal, options, f'link {text}')
    if signal != 'u':
        return
    link = load('exact').with_links([text]).nodes['link_u']
    assert {name: link[name] for name in options} == options


@given(text=TEXT | st.from_regex(r'[a-z/*]{0,6}\.[a-z]{0,4}:=.*'))
def test_any_text_for_an_override_is_read_or_refused(text):
    one_error(Override.read, text)
    one_error(lambda each: load('exact', [each]), text)


PYTHON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary()
    | st.sampled_from([np.float32(0.1), np.int64(2), np.arange(2.0), np.array(1.0), object(), int]),
    lambda each: st.lists(each) | st.tuples(each) | st.dictionaries(st.text(), each),
    max_leaves=5,
)  # fmt: skip
KEYS = st.sampled_from(['controller.k', 'plant.x0', '/**.rate', 'plant.output', 'plant.lockstep'])


@given(name=KEYS | TEXT, value=PYTHON)
def test_any_value_of_python_is_taken_or_refused(name, value):
    scenario = one_error(lambda each: api.load('exact', {each: value}), name)
    if scenario is not None:
        again = parse(scenario.to_yaml(), scenario.name)
        assert repr(again.nodes) == repr(scenario.nodes)


# Files --------------------------------------------------------------------------------------------


@given(text=TEXT)
def test_any_text_for_a_file_is_read_or_refused(text):
    one_error(lambda each: parse(each, 'mine'), text)
    one_error(lambda each: parse(f'plant:\n  ros__parameters:\n    {each}', 'mine'), text)


SCALARS = st.booleans() | st.integers(-(2**63), 2**63 - 1) | NUMBERS | TEXT | WORDS


@hypothesis.example(value=5e-324)
@hypothesis.example(value=[0.0, -2.2250738585e-313])
@given(value=SCALARS | st.lists(NUMBERS, min_size=1) | st.lists(TEXT | WORDS, min_size=1))
def test_what_is_written_is_read_to_the_last_bit(value):
    text = ros_yaml.dump({'plant': {'ros__parameters': {'file': value}}})
    (section,) = ros_yaml.load(text, 'mine')
    assert repr(section.values['file']) == repr(value)


@given(text=TEXT | st.from_regex(r'[-+.0-9a-fxXpPeE_:]{1,12}', fullmatch=True))
def test_a_scalar_of_any_text_is_itself_a_bool_or_a_number(text):
    found = scalar(text)
    assert isinstance(found, bool | int | float) or found == text


@st.composite
def scenarios(draw):
    """A shipped scenario with some of its parameters set to others that are allowed."""
    base = load(draw(st.sampled_from(shipped())))
    given = {node: dict(values) for node, values in base.given.items()}
    for node in draw(st.lists(st.sampled_from(list(given)), max_size=3)):
        rows = [row for row in parameters_of(node, given[node]).values() if row.name != 'model']
        row = draw(st.sampled_from(rows))
        kinds = {'bool': st.booleans(), 'int': st.integers(0, 2**62), 'double': NUMBERS,
                 'string': TEXT | SIGNALS, 'double[]': st.lists(NUMBERS, max_size=4),
                 'string[]': st.lists(SIGNALS, max_size=4)}  # fmt: skip
        given[node][row.name] = draw(kinds[row.type])
    return base.name, given


@given(made=scenarios())
def test_a_scenario_is_the_same_when_it_is_written_and_read(made):
    scenario = one_error(lambda each: Scenario.of(*each), made)
    if scenario is None:
        return
    for anywhere in (False, True):
        again = parse(scenario.to_yaml(anywhere), scenario.name)
        assert repr(again.nodes) == repr(scenario.nodes)
        assert repr(again.given) == repr(scenario.given)
