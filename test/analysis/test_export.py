# SPDX-License-Identifier: Apache-2.0
"""Files and objects for other programs hold the same floats; what is not installed is named."""

import importlib.util

import numpy as np
import pytest

from eventreg_ros import simulate
from eventreg_ros.analysis.export import check_path, to_dataframe, to_xarray, write_signals
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.errors import EventregError

T = np.arange(5) * 0.1
SIGNALS = {'w': np.array([0.1, 1 / 3, -0.0, 1e-308, np.nan]), 'y': np.sqrt(np.arange(5.0))}


@pytest.mark.slow
def test_a_parquet_file_holds_the_same_bits(tmp_path):
    parquet = pytest.importorskip('pyarrow.parquet')
    path = tmp_path / 'run.parquet'
    write_signals(path, T, SIGNALS)
    read = parquet.read_table(path)
    assert read.column_names == ['t', 'w', 'y']
    for name, x in {'t': T, **SIGNALS}.items():
        assert read[name].to_numpy().tobytes() == x.tobytes()


def test_a_run_as_a_dataframe_and_as_a_dataset():
    pytest.importorskip('pandas')
    run = simulate('exact', 20.0)
    frame = run.to_dataframe()
    assert list(frame.columns) == list(run.signals)
    assert frame.index.name == 't'
    assert frame.attrs == {'scenario': 'exact', 'verdict': 'undecided'}
    np.testing.assert_array_equal(frame.index, run.t)
    np.testing.assert_array_equal(frame['y'], run['y'])
    pytest.importorskip('xarray')
    dataset = run.to_xarray()
    assert dataset.attrs == frame.attrs
    assert dataset['u'].dims == ('t',)
    assert dataset['t'].attrs['units'] == 'model time'
    np.testing.assert_array_equal(dataset['u'], run['u'])


def test_signals_with_times_of_their_own():
    pytest.importorskip('pandas')
    signals = {
        'y': (np.array([0.0, 1.0, 1.0, 3.0]), np.array([5.0, 6.0, 7.0, 8.0])),
        'u': (np.array([0.0, 2.0]), np.array([1.0, 2.0])),
    }
    frame = to_dataframe(signals)
    assert frame.index.tolist() == [0.0, 1.0, 2.0, 3.0]
    np.testing.assert_array_equal(frame['y'], [5.0, 7.0, np.nan, 8.0])
    np.testing.assert_array_equal(frame['u'], [1.0, np.nan, 2.0, np.nan])


@pytest.mark.slow
def test_a_bag_as_a_dataframe(make_bag):
    pytest.importorskip('xarray')
    analysis = analyze(make_bag(w=[110, 150, 190], y=[], u=[110]))
    frame = analysis.to_dataframe()
    assert frame.attrs == {'scenario': 'made', 'verdict': 'rejected'}
    t, w = analysis.signals['w']
    np.testing.assert_array_equal(frame.index, t)
    np.testing.assert_array_equal(frame['w'], w)
    np.testing.assert_array_equal(analysis.to_xarray()['w'], w)


@pytest.mark.parametrize(
    ('package', 'call'),
    [
        ('pyarrow', lambda path: check_path(path / 'run.parquet')),
        ('pandas', lambda _: to_dataframe({})),
        ('xarray', lambda _: to_xarray({})),
    ],
)
def test_what_is_not_installed_is_named(package, call, tmp_path, monkeypatch):
    found = importlib.util.find_spec
    hidden = {package}
    monkeypatch.setattr(
        importlib.util, 'find_spec', lambda name: None if name in hidden else found(name)
    )
    with pytest.raises(EventregError, match=rf'needs {package}.*pip install {package}'):
        call(tmp_path)
