# SPDX-License-Identifier: Apache-2.0
"""The stimulus, the spike monitor and the recorder."""

import shutil

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_msgs.msg import Float64, Header, UInt64

from eventreg_ros.bags.reader import read_bag, read_messages
from eventreg_ros.errors import EventregError
from eventreg_ros.nodes.recorder import Recorder
from eventreg_ros.nodes.spike_monitor import SpikeMonitor
from eventreg_ros.nodes.stimulus import StimulusNode
from eventreg_ros.nodes.topics import COUNT, VERDICT
from eventreg_ros.runtime.cdr import packed
from eventreg_ros.runtime.figures import MARGIN_USED


def test_the_stimulus_publishes_its_waveform_in_model_time(bench):
    heard = bench.heard_with_stamps(Float64, 'v')
    node = bench.add(
        StimulusNode, 'waveform:=pulses', 'onsets:=[3, 8]', 'width:=2', 'amplitude:=1.5'
    )
    bench.until(lambda: node.n > 250)
    for stamp, value in heard:
        n = node.pace.grid.index(stamp) - node.pace.origin
        t = n * 10.0 / 200.0
        edges = min(abs(t - edge) for edge in (3.0, 5.0, 8.0, 10.0))
        if edges > 0.05:  # a tick that comes late may carry the stamp of the next one
            assert value == (1.5 if 3.0 <= t < 5.0 or 8.0 <= t < 10.0 else 0.0)


def test_the_time_scale_of_the_stimulus_changes_without_a_jump(bench):
    node = bench.add(StimulusNode, 'waveform:=sine', 'period:=100.0')
    bench.until(lambda: node.n > 20)
    n, before = node.n, node._model_time(node.n)
    node.set_parameters([Parameter('time_scale', value=20.0)])
    assert node._model_time(n) == before
    assert node._model_time(n + 10) == pytest.approx(before + 10 * 20.0 / 200.0)


def test_a_stimulus_without_its_file_refuses_to_start(bench, tmp_path):
    missing = tmp_path / 'none.csv'
    with pytest.raises(EventregError, match=r'none\.csv'):
        bench.add(StimulusNode, 'waveform:=csv', f'file:={missing}')


def test_the_monitor_counts_events_and_tells_when_they_were(bench):
    events = bench.heard(Header, 'spikes/y/event')
    bench.add(SpikeMonitor, "signals:=['y']", 'threshold:=1.0', 'reset:=0.0')
    y = bench.peer.create_publisher(Float64, 'y', 10)
    bench.until(lambda: y.get_subscription_count() == 1)
    before = bench.peer.get_clock().now().nanoseconds
    for value in (0.0, 0.5, 1.5, 0.5, 1.5, -0.1, 2.0):  # two events: 0.5 is above reset
        y.publish(Float64(data=value))
    bench.until(lambda: len(events) == 2)
    counts = bench.heard(UInt64, 'spikes/y/count', COUNT.qos)  # subscribes late
    bench.until(lambda: counts)
    assert [m.data for m in counts] == [2]
    stamps = [m.stamp.sec * 10**9 + m.stamp.nanosec for m in events]
    assert before <= stamps[0] < stamps[1] <= bench.peer.get_clock().now().nanoseconds
    assert {m.frame_id for m in events} == {'y'}


def test_the_monitor_tells_zero_before_the_first_event(bench):
    bench.add(SpikeMonitor, "signals:=['y']")
    counts = bench.heard(UInt64, 'spikes/y/count', COUNT.qos)
    bench.until(lambda: [m.data for m in counts] == [0])


def test_the_limits_of_the_monitor_are_in_model_time(bench):
    limits = ('refractory:=20', 'min_width:=4')
    node = bench.add(SpikeMonitor, "signals:=['y']", 'time_scale:=2.0', *limits)
    detector = node.detectors['y']
    assert (detector.refractory, detector.min_width) == (10.0, 2.0)
    node.set_parameters([Parameter('time_scale', value=20.0)])
    assert (detector.refractory, detector.min_width) == (1.0, 0.2)


def test_the_monitor_publishes_the_verdict_so_far_with_its_reason(bench):
    node = bench.add(SpikeMonitor, "signals:=['w', 'y']", 'settle:=0.0', 'time_scale:=1.0')
    for signal, values in (('w', [0.0, 2.0] * 3), ('y', [0.0, 2.0, 0.0])):
        receive = node._receiver(signal)
        for value in values:
            now = bench.peer.get_clock().now().nanoseconds
            info = {'source_timestamp': now, 'received_timestamp': now}
            receive(packed(value), {**info, 'publication_sequence_number': None})
    used = DiagnosticStatus(name='/plant: plant', values=[KeyValue(key=MARGIN_USED, value='0.3')])
    other = DiagnosticStatus(name='plant', values=[KeyValue(key=MARGIN_USED, value='0.9')])
    node._on_diagnostics(DiagnosticArray(status=[used, other]))
    node._publish_verdict()
    found = bench.heard(DiagnosticStatus, 'verdict', VERDICT.qos)  # subscribes late
    bench.until(lambda: found)
    assert (found[0].level, found[0].name) == (DiagnosticStatus.ERROR, '/spike_monitor: verdict')
    values = {pair.key: pair.value for pair in found[0].values}
    assert (values['verdict'], values['w.seen'], values['y.spurious']) == (
        'not rejected', '1.0000', '1'
    )  # fmt: skip
    assert (values['y.disturbance_events'], values['margin_used']) == ('3', '0.300')
    assert found[0].message == f'not rejected: {values["reason"]}'
    assert 'y had 1 event that nothing asks for' in values['reason']


def test_a_scenario_that_the_monitor_cannot_read_is_refused(bench, tmp_path):
    (tmp_path / 'broken.yaml').write_text('plant: [')
    for name, words in (('none.yaml', 'must be a readable file'), ('broken.yaml', 'of the run')):
        with pytest.raises(EventregError, match=words):
            bench.add(SpikeMonitor, f'scenario:={tmp_path / name}')


def test_the_recorder_keeps_the_verdict(bench, tmp_path):
    node = bench.add(Recorder, "signals:=['y']", f'path:={tmp_path / "bag"}')
    verdict = bench.peer.create_publisher(DiagnosticStatus, 'verdict', VERDICT.qos)
    verdict.publish(DiagnosticStatus(name='x', message='undecided: run longer'))
    bench.until(lambda: node.recorded['verdict'] == 1)
    node.close()
    bench.nodes.remove(node)
    (message,) = read_messages(tmp_path / 'bag', ['/verdict'])['/verdict']
    assert message.type == 'diagnostic_msgs/msg/DiagnosticStatus'
    assert b'undecided: run longer' in message.data


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_the_recorder_keeps_values_and_the_time_of_sending(bench, tmp_path, storage):
    scenario = tmp_path / 'mine.yaml'
    scenario.write_text('plant:\n  ros__parameters:\n    k: 2.0\n')
    node = bench.add(
        Recorder,
        "signals:=['y', 'u']",
        f'path:={tmp_path / "bag"}',
        f'storage:={storage}',
        f'scenario:={scenario}',
        'scenario_name:=mine',
    )
    y = bench.peer.create_publisher(Float64, 'y', 10)
    bench.until(lambda: y.get_subscription_count() == 1)
    heard = bench.heard_with_stamps(Float64, 'y')
    bench.until(lambda: y.get_subscription_count() == 2)
    values = [0.1, -2.5e-17, 1e300, 3.0]
    for value in values:
        y.publish(Float64(data=value))
    bench.until(lambda: node.recorded['y'] == len(values) and len(heard) == len(values))
    node.close()
    bench.nodes.remove(node)
    recording = read_bag(tmp_path / 'bag')
    stamps, found = recording.signals['y']
    assert found.tolist() == values
    assert stamps.tolist() == [stamp for stamp, _ in heard]
    assert len(recording.signals['u'][0]) == 0
    assert recording.scenario == scenario.read_text()
    assert recording.name == 'mine'


def test_the_recorder_records_a_remapped_signal_and_says_which_it_is(bench, tmp_path):
    node = bench.add(
        Recorder, "signals:=['y', 'u']", f'path:={tmp_path / "bag"}',
        arguments=['-r', 'y:=/arm/membrane', '-r', '__ns:=/lab'],
    )  # fmt: skip
    y = bench.peer.create_publisher(Float64, '/arm/membrane', 10)
    bench.until(lambda: y.get_subscription_count() == 1)
    y.publish(Float64(data=0.25))
    bench.until(lambda: node.recorded['y'] == 1)
    node.close()
    bench.nodes.remove(node)
    recording = read_bag(tmp_path / 'bag')
    assert recording.signals['y'].values.tolist() == [0.25]
    assert recording.topics['y'] == '/arm/membrane'


def test_the_recorder_keeps_what_is_changed_in_its_namespace(bench, tmp_path):
    home = ['-r', '__ns:=/r1']
    recorder = bench.add(
        Recorder, "signals:=['v']", f'path:={tmp_path / "bag"}', arguments=home, start=False
    )
    recorder.trigger_configure()
    inside = bench.add(StimulusNode, arguments=home)
    outside = bench.add(StimulusNode, arguments=['-r', '__node:=stimulus_2'])
    recorder.trigger_activate()
    bench.until(lambda: '/r1/stimulus/transition_event' in recorder.tap.heard)
    bench.until(lambda: recorder.recorded['v'] > 0)
    for node in (outside, inside):
        node.set_parameters([Parameter('amplitude', value=2.5)])
        node.trigger_deactivate()
    bench.until(lambda: recorder.recorded.get('/r1/stimulus/transition_event', 0) == 2)
    bench.until(lambda: recorder.recorded.get('/parameter_events', 0) == 1)
    recorder.close()
    bench.nodes.remove(recorder)
    changes = read_bag(tmp_path / 'bag').changes
    assert sorted((c.node, c.what) for c in changes) == [
        ('r1/stimulus', 'amplitude:=2.5'), ('r1/stimulus', 'deactivate'),
    ]  # fmt: skip


def test_the_recorder_refuses_a_bag_that_exists(bench, tmp_path):
    with pytest.raises(EventregError, match='exists already'):
        bench.add(Recorder, f'path:={tmp_path}')


def test_a_file_that_cannot_be_read_is_refused_and_changes_nothing(bench, tmp_path):
    missing = tmp_path / 'none.csv'
    node = bench.add(StimulusNode, f'file:={missing}')
    node.trigger_deactivate()
    result = node.set_parameters([Parameter('waveform', value='csv')])[0]
    assert not result.successful
    assert 'none.csv' in result.reason
    assert node.values['waveform'] == 'constant'
    assert node.get_parameter('waveform').value == 'constant'


@pytest.mark.parametrize(
    ('make', 'name'),
    [
        (Recorder, 'path'),
        (Recorder, 'scenario'),
        (Recorder, 'scenario_name'),
        (SpikeMonitor, 'scenario'),
        (StimulusNode, 'file'),
    ],
)
def test_no_other_process_says_which_files_a_node_reads_and_writes(bench, tmp_path, make, name):
    """Whoever reaches a node can set its parameters; whoever starts it alone names its files."""
    arguments = [f'path:={tmp_path / "bag"}'] if make is Recorder else []
    node = bench.add(make, *arguments, start=False)
    client = bench.peer.create_client(SetParameters, f'{node.get_name()}/set_parameters')
    bench.until(client.service_is_ready)
    before = node.get_parameter(name).value

    def told(value):
        wanted = Parameter(name, value=value).to_parameter_msg()
        future = client.call_async(SetParameters.Request(parameters=[wanted]))
        bench.until(future.done)
        return future.result().results[0]

    refused = told('/etc/hostname')
    assert not refused.successful
    assert refused.reason.endswith(f'start it anew with -p {name}:=VALUE')
    assert node.get_parameter(name).value == node.values[name] == before
    assert told(before).successful  # so that what was dumped can be loaded again


def test_a_recorder_whose_bag_is_deleted_says_so_and_stops(bench, tmp_path):
    recorder = bench.add(Recorder, "signals:=['v']", f'path:={tmp_path / "bag"}')
    heard = bench.heard(DiagnosticArray, '/diagnostics')
    bench.add(StimulusNode)
    bench.until(lambda: recorder.recorded['v'] > 10)
    shutil.rmtree(tmp_path / 'bag')
    bench.until(lambda: recorder.fault is not None)
    assert recorder.stage == 'unconfigured'
    assert recorder.fault.startswith(f'bag {tmp_path / "bag"} was deleted or moved while')

    def said():
        return [s for m in heard for s in m.status if s.name == '/recorder: recorder']

    bench.until(lambda: said() and said()[-1].level == DiagnosticStatus.ERROR)
    assert said()[-1].message == recorder.fault
    assert not (tmp_path / 'bag').exists()
