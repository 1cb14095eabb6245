# SPDX-License-Identifier: Apache-2.0
"""``eventreg analyze`` on bags whose events are known."""

import json
import shutil

import numpy as np
import pytest

from eventreg_ros import scenario as scenarios
from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.writer import BagWriter, write_bag
from eventreg_ros.cli.main import main
from eventreg_ros.runtime.cdr import packed

W = [110, 150, 190, 230]
U = [111, 151, 191, 231]


@pytest.fixture
def analyze(capsys):
    """Run ``eventreg analyze ARGUMENTS`` in this process: (exit code, output, errors)."""

    def run(*arguments):
        code = main(['analyze', *map(str, arguments)])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


# Exit codes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
@pytest.mark.parametrize(
    ('w', 'y', 'code', 'verdict'),
    [
        (W, [], 0, 'rejected'),
        (W, [130], 1, 'not rejected'),
        (W[:2], [130], 3, 'undecided'),
        ([], [], 3, 'undecided'),
    ],
)
def test_the_exit_code_is_the_verdict(make_bag, analyze, storage, w, y, code, verdict):
    bag = make_bag(w=w, y=y, u=U, storage=storage)
    result, output, error = analyze(bag)
    assert (result, error) == (code, '')
    assert output.splitlines()[-1] == f'verdict: {verdict}'
    assert 'rate Hz' in output


@pytest.mark.slow
def test_as_a_process(make_bag, eventreg):
    for y, code in (([], 0), ([130], 1)):
        result = eventreg('analyze', make_bag(f'bag_{code}', w=W, y=y, u=U))
        assert (result.returncode, result.stderr) == (code, '')
        assert '\nmade: 260.0 model time units, counted after 100\n' in result.stdout


def test_a_noisy_signal_is_named_with_limits_that_help(tmp_path, loop_signals, stamped, analyze):
    signals = loop_signals(w=W, y=[], u=U)
    t, y = signals['y']
    signals['y'] = (t, y + 1.0 + np.random.default_rng(1).normal(0.0, 0.5, len(t)))
    write_bag(tmp_path / 'noisy', stamped(signals), 'made', 'plant: {ros__parameters: {}}')
    code, output, _ = analyze(tmp_path / 'noisy')
    assert code == 1
    (line,) = (line for line in output.splitlines() if 'noisy' in line)
    assert line.startswith('y is noisy (sd 0.5')
    assert 'events, 0 with min_width' in line
    assert '  because noise alone lasts up to' in output


# Arguments ----------------------------------------------------------------------------------------


def test_json_is_the_contract(make_bag, analyze, tmp_path):
    analyze(make_bag(w=W, y=[50, 130], u=U), '--json', tmp_path / 'out.json')
    report = json.loads((tmp_path / 'out.json').read_text())
    assert report['scenario'] == 'made'
    assert (report['time_scale'], report['settle'], report['verdict']) == (10, 100, 'not rejected')
    assert report['duration'] == pytest.approx(260.0)
    assert report['rejection'] == {
        'disturbance_events': 4, 'reference_events': 0, 'preserved': 0, 'spurious': 1, 'missed': 0,
        'ratio': 0.75,
    }  # fmt: skip
    assert list(report['signals']) == ['w', 'y', 'u']
    assert report['signals']['y']['events'] == pytest.approx([50, 130], abs=1e-6)
    timing = report['signals']['w']['timing']
    assert list(timing) == ['rate', 'period_p50', 'period_p99', 'period_max', 'gaps']
    assert timing['rate'] == pytest.approx(50.0)  # every 0.2 at 10 units per second
    assert timing['period_max'] == pytest.approx(2e-2)
    assert timing['gaps'] == 0


@pytest.mark.parametrize(
    ('arguments', 'code'),
    [
        (['--settle', '100'], 1),
        (['--settle', '140'], 0),
        (['--settle', '0'], 1),
        (['--settle', '200'], 3),
    ],
)
def test_settle(make_bag, analyze, arguments, code):
    assert analyze(make_bag(w=W, y=[130], u=U), *arguments)[0] == code


@pytest.mark.parametrize(('window', 'code'), [('5', 1), ('6.001', 0), ('0', 1)])
def test_window(make_bag, analyze, window, code):
    text = scenarios.load('open').to_yaml()
    bag = make_bag(w=W, y=[136], y_r=[130], v=[130], u=U, text=text)
    assert analyze(bag, '--window', window)[0] == code


@pytest.mark.parametrize('option', ['--settle', '--from'])
def test_a_span_beyond_the_end_is_refused(make_bag, refused, analyze, option):
    bag = make_bag(w=W, y=[], u=U)
    assert analyze(bag, option, '260')[0] == 3
    assert 'ends at 260 of model time, got 261' in refused('analyze', bag, option, '261')
    assert 'until must be later than 150' in refused(
        'analyze', bag, option, '150', '--until', '120'
    )


def test_the_span_may_be_chosen(make_bag, analyze, tmp_path):
    bag, out = make_bag(w=[*W, 245], y=[105, 240], u=U), tmp_path / 'out.json'
    assert analyze(bag, '--from', '108', '--until', '235', '--json', out)[0] == 0
    report = json.loads(out.read_text())
    assert report['evidence']['span'] == [108.0, 235.0]
    assert (report['settle'], report['rejection']['disturbance_events']) == (108.0, 4)


def test_criteria_of_the_scenario_are_in_the_bag(make_bag, analyze, tmp_path):
    limits = ['settle:=140', 'window:=6.5', 'blind:=0.1', 'refractory:=3', 'min_width:=1']
    text = scenarios.load('open', [f'spike_monitor.{limit}' for limit in limits]).to_yaml()
    bag = make_bag(w=W, y=[156, 158, 200], y_r=[150, 200], v=[], u=U, text=text)
    out = tmp_path / 'out.json'
    assert analyze(bag, '--json', out)[0] == 3  # a sample every 0.2
    report = json.loads(out.read_text())
    assert report['settle'] == 140.0
    assert len(report['signals']['y']['events']) == 2  # 158 is within the refractory time of 156
    assert report['rejection']['preserved'] == 2
    assert analyze(bag, '--blind', '5')[0] == 0
    assert analyze(bag, '--blind', '5', '--window', '5')[0] == 1


def test_what_was_not_seen_is_said_once_and_judged_only_when_asked_for(
    tmp_path, loop_signals, stamped, analyze
):
    signals = loop_signals(w=W, y=[], u=U)
    t, y = signals['y']
    signals['y'] = (t[(t < 120.0) | (t > 140.0)], y[(t < 120.0) | (t > 140.0)])
    text = scenarios.load('exact').to_yaml()
    write_bag(tmp_path / 'bag', stamped(signals), 'exact', text)
    out = tmp_path / 'out.json'
    code, output, error = analyze(tmp_path / 'bag', '--json', out)
    assert code == 3
    words = 'y was not seen for 20.4 of 160.0 units of model time: from 119.8 to 140.2'
    assert error == f'eventreg: {words}\n'
    assert f'\n{words}\nverdict: undecided\n' in output
    report = json.loads(out.read_text())
    assert report['reason'] == words
    assert [w['text'] for w in report['evidence']['warnings']] == [words]
    code, output, error = analyze(tmp_path / 'bag', '--lenient', '--json', out)
    assert (code, error) == (0, f'eventreg: {words}\n')
    assert 'as far as it was seen' in json.loads(out.read_text())['reason']
    assert analyze(tmp_path / 'bag', '--from', '141')[::2] == (0, '')


def test_the_scenario_of_the_bag_decides_unless_another_is_given(make_bag, analyze, tmp_path):
    text = 'plant: {ros__parameters: {}}\nspike_monitor: {ros__parameters: {threshold: 2.0}}\n'
    bag = make_bag(w=W, y=[130], text=text)
    output = tmp_path / 'out.json'
    analyze(bag, '--json', output)
    own = json.loads(output.read_text())
    assert own['signals']['y']['events'] == pytest.approx([130.25], abs=1e-6)

    other = tmp_path / 'other.yaml'
    other.write_text('plant: {ros__parameters: {time_scale: 5.0}}')
    analyze(bag, '--scenario', other, '--json', output, '--settle', 50)
    given = json.loads(output.read_text())
    assert (given['scenario'], given['time_scale']) == ('other', 5.0)
    assert given['duration'] == pytest.approx(130.0)
    assert given['signals']['y']['events'] == pytest.approx([65.0], abs=1e-6)


def test_a_shipped_scenario_may_be_named(make_bag, analyze):
    bag = make_bag(w=W, y=[], u=U, text=None)
    assert analyze(bag, '--scenario', 'exact')[::2] == (0, '')


def test_without_any_scenario_the_defaults_are_taken_and_reported(make_bag, analyze):
    code, output, error = analyze(make_bag(w=W, y=[], u=U, text=None))
    assert (code, '\nunknown: ' in output) == (0, True)
    assert error.count('\n') == 1
    assert '--scenario is not given; taking time_scale 10' in error


def test_a_namespace_may_be_chosen(analyze, tmp_path, loop_signals, refused):
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    for home, y in (('/a', []), ('/b', [130])):
        for name, (t, x) in loop_signals(w=W, y=y, u=U).items():
            writer.add(f'{home}/{name}', FLOAT64)
            for i in range(len(t)):
                writer.write(f'{home}/{name}', i * 20_000_000, packed(x[i]))
    writer.close()
    assert analyze(tmp_path / 'bag', '--namespace', '/a')[0] == 0
    assert analyze(tmp_path / 'bag', '--namespace', 'b')[0] == 1
    assert 'choose one with --namespace' in refused('analyze', tmp_path / 'bag')
    assert 'in namespace /c' in refused('analyze', tmp_path / 'bag', '--namespace', 'c')


def test_signals_may_be_named_by_their_topics_and_stamps_chosen(
    tmp_path, loop_signals, stamped, analyze, refused
):
    signals = stamped(loop_signals(w=W, y=[130], u=U))
    signals['arm/membrane'] = signals.pop('y')
    write_bag(tmp_path / 'bag', signals, 'exact', scenarios.load('exact').to_yaml())
    assert 'no sample of y' in refused('analyze', tmp_path / 'bag')
    topic = ['--topic', 'y:=/arm/membrane']
    assert analyze(tmp_path / 'bag', *topic)[::2] == (1, '')
    assert analyze(tmp_path / 'bag', *topic, '--time', 'log')[::2] == (1, '')
    assert 'has no topic /arm/none' in refused(
        'analyze', tmp_path / 'bag', '--topic', 'y:=/arm/none'
    )


def test_one_robot_of_two_may_be_judged(tmp_path, loop_signals, stamped, analyze):
    robots = {'r1': [], 'r2': [130]}
    text = ''.join(
        f'/{r}/{n}: {{ros__parameters: {{}}}}\n' for r in robots for n in ('exosystem', 'plant')
    )
    signals = {
        f'{r}/{name}': signal
        for r, y in robots.items()
        for name, signal in stamped(loop_signals(w=W, y=y)).items()
    }
    write_bag(tmp_path / 'bag', signals, 'robots', text)
    out = tmp_path / 'out.json'
    assert analyze(tmp_path / 'bag', '--json', out)[::2] == (1, '')
    assert [p['verdict'] for p in json.loads(out.read_text())['plants'].values()] == [
        'rejected', 'not rejected',
    ]  # fmt: skip
    for robot, code in (('r1', 0), ('/r2', 1)):
        assert analyze(tmp_path / 'bag', '--namespace', robot, '--json', out)[::2] == (code, '')
        assert list(json.loads(out.read_text())['signals']) == ['w', 'y']


@pytest.mark.slow
def test_a_verdict_for_ci_and_a_picture(make_bag, analyze, tmp_path):
    xml, picture = tmp_path / 'out.xml', tmp_path / 'out.svg'
    assert analyze(make_bag(w=W, y=[130], u=U), '--junit', xml, '--plot', picture)[0] == 1
    assert '<failure type="not rejected"' in xml.read_text()
    assert picture.read_text().count('<svg') == 1


# What is refused ----------------------------------------------------------------------------------


def test_no_bag(refused, tmp_path):
    (tmp_path / 'text.txt').write_text('hello')
    assert 'does not exist; check the path' in refused('analyze', tmp_path / 'none')
    assert 'is no bag' in refused('analyze', tmp_path)
    assert 'cannot be read' in refused('analyze', tmp_path / 'text.txt')


def test_a_scenario_that_does_not_fit_the_bag(make_bag, refused):
    bag = make_bag(w=W, y=[])
    assert 'holds no sample of u (of controller), which scenario made publishes' in refused(
        'analyze', bag
    )
    error = refused('analyze', bag, '--scenario', 'open')
    for missing in ('v (of stimulus)', 'y_r (of reference)', 'u (of controller)'):
        assert missing in error


def test_a_bag_without_y(make_bag, refused):
    bag = make_bag(w=W, u=U, text=None)
    assert "no samples of y, the plant's output, to judge" in refused('analyze', bag)
    assert 'no sample of y (of plant)' in refused('analyze', bag, '--scenario', 'exact')


@pytest.mark.parametrize(
    'text', ['plant: [', 'plnt: {}', 'spike_monitor: {ros__parameters: {}}', '']
)
def test_a_bag_whose_scenario_is_broken(make_bag, refused, analyze, text):
    bag = make_bag(w=W, y=[], u=U, text=text)
    assert 'scenario made' in refused('analyze', bag)
    assert analyze(bag, '--scenario', 'exact')[0] == 0


def test_a_scenario_that_is_not_there(make_bag, refused):
    assert "no scenario 'none'" in refused(
        'analyze', make_bag(w=W, y=[], u=U), '--scenario', 'none'
    )


def test_places_that_cannot_be_written(make_bag, refused, tmp_path):
    bag = make_bag(w=W, y=[], u=U)
    for option in ('--json', '--report', '--junit'):
        assert 'name another file' in refused('analyze', bag, option, tmp_path)
        assert 'name another file' in refused('analyze', bag, option, tmp_path / 'no' / 'such')


# What it needs ------------------------------------------------------------------------------------

BLOCKED = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.partition('.')[0] in {'rclpy', 'std_msgs', 'rcl_interfaces', 'launch'}:
            raise ImportError(f'{name} is not installed here')
sys.meta_path.insert(0, Block())
from eventreg_ros.cli.main import main
code = main(sys.argv[1:])
print(*sorted({name.partition('.')[0] for name in sys.modules}), file=sys.stderr)
sys.exit(code)
"""


@pytest.mark.slow
def test_it_needs_neither_ros_nor_what_it_does_not_use(make_bag, python):
    result = python('-c', BLOCKED, 'analyze', str(make_bag(w=W, y=[], u=U)))
    assert result.returncode == 0
    loaded = set(result.stderr.split())
    assert 'numpy' in loaded
    assert not loaded & {'rclpy', 'rosbags', 'scipy', 'matplotlib', 'numba'}


@pytest.mark.slow
def test_the_report_needs_no_more_than_that(make_bag, python, tmp_path):
    bag, page = make_bag(w=W, y=[], u=W), tmp_path / 'page.html'
    result = python('-c', BLOCKED, 'analyze', str(bag), '--report', str(page))
    assert result.returncode == 0
    assert page.read_text(encoding='utf-8').startswith('<!DOCTYPE html>')
    loaded = set(result.stderr.split())
    assert not loaded & {'rclpy', 'rosbags', 'scipy', 'matplotlib', 'numba'}


@pytest.mark.parametrize(('until', 'code'), [(200.0, 0), (160.0, 3)])
def test_a_killed_recording_is_judged_as_far_as_it_goes(
    tmp_path, analyze, loop_signals, until, code
):
    text = 'plant: {ros__parameters: {}}\nspike_monitor: {ros__parameters: {threshold: 2.0}}\n'
    writer = BagWriter(tmp_path / 'bag', 'mcap', text, 'cut short')
    signals = loop_signals(until, w=W, y=[])
    for name in signals:
        writer.add(f'/{name}', FLOAT64)
    for i, t in enumerate(signals['w'][0]):
        for name, (_, x) in signals.items():
            writer.write(f'/{name}', i * 20_000_000, packed(x[i]))
        if t == until:
            writer.flush()
    shutil.copytree(tmp_path / 'bag', tmp_path / 'killed')
    writer.close()
    result, output, error = analyze(tmp_path / 'killed')
    assert result == code
    assert 'ends without its end' in error
    assert error.count('\n') == 1
    assert f'\ncut short: {until} model time units' in output


def test_a_bag_may_be_moved(make_bag, analyze, tmp_path, loop_signals):
    bag = make_bag(w=W, y=[], u=U)
    shutil.move(bag, tmp_path / 'elsewhere')
    assert analyze(tmp_path / 'elsewhere')[0] == 0


def test_the_same_bag_gives_the_same_json(tmp_path, analyze, loop_signals, stamped):
    text = scenarios.load('exact').to_yaml()
    for i in range(2):
        write_bag(tmp_path / f'{i}', stamped(loop_signals(w=W, y=[], u=U)), 'exact', text)
        analyze(tmp_path / f'{i}', '--json', tmp_path / f'{i}.json')
    assert (tmp_path / '0.json').read_text() == (tmp_path / '1.json').read_text()


def test_a_warning_is_no_longer_than_an_error(make_bag, analyze):
    bag = make_bag(w=W, y=[], u=U)
    text = (bag / 'metadata.yaml').read_text()
    name = next(bag.glob('*.mcap')).name
    longer = text.replace(f'- {name}', f'- {name}\n  - {"long_" * 100}.mcap', 1)
    (bag / 'metadata.yaml').write_text(longer)
    code, _, errors = analyze(bag)
    assert code == 3
    assert 'is not there' in errors
    assert max(map(len, errors.splitlines())) <= 300
