# SPDX-License-Identifier: Apache-2.0
"""``eventreg run``: processes over DDS, recorded and judged; its errors, deaths and interrupts."""

import json
import os
import shutil
import signal
import time

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2: pip install .[ros]')

pytestmark = pytest.mark.ros

SHORT = ['--settle', '40', '--duration', '17']
"""Three events of w lie between model times 40 and 170: at 71.7, 109.3 and 146.8 (the truth)."""


def wait_for(condition, seconds=40.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, 'the condition never came true'
        time.sleep(0.05)


def gone(pid):
    try:
        with open(f'/proc/{pid}/stat') as file:
            return file.read().rpartition(')')[2].split()[0] == 'Z'
    except OSError:
        return True


@pytest.mark.parametrize(
    ('scenario', 'code', 'spurious'), [('exact', 0, 0), ('uncontrolled', 1, 3)]
)
def test_the_verdict_over_real_topics_is_that_of_the_paper(
    run, children, tmp_path, scenario, code, spurious
):
    process = run(scenario, *SHORT, '--bag', 'bag', '--json', '-', '--report', 'page.html')
    out, err = process.communicate(timeout=80)
    assert process.returncode == code, err
    report = json.loads(out)
    assert report['rejection']['disturbance_events'] == 3
    assert report['rejection']['spurious'] == spurious
    assert report['scenario'] == scenario
    assert report['signals']['w']['events'][:4] == pytest.approx(
        [34.1671, 71.7138, 109.2605, 146.8072], abs=0.3
    )  # truth/trajectories.json; a sample is 0.05 of model time
    page = (tmp_path / 'page.html').read_text(encoding='utf-8')
    assert f'<title>{scenario}: {report["verdict"]}</title>' in page
    assert f'verdict: {report["verdict"]}\n' in err
    assert 'eventreg:' not in err
    assert not children(process)


def test_a_bag_that_is_deleted_ends_the_run_at_once(run, children, tmp_path):
    process = run('exact', '--duration', '600', '--bag', 'bag')
    wait_for(lambda: list(tmp_path.glob('bag/*.mcap')))
    for line in process.stdout:
        if 's of 600 s' in line or ' of 600 s' in line:
            break
    shutil.rmtree(tmp_path / 'bag')
    _, err = process.communicate(timeout=60)
    assert process.returncode == 4, err
    (line,) = [line for line in err.splitlines() if line.startswith('eventreg:')]
    assert line.startswith(f'eventreg: recorder: bag {tmp_path / "bag"} was deleted or moved')
    assert not children(process)


def test_a_death_is_reported_the_bag_is_kept_and_the_run_fails(run, children, tmp_path):
    at = ['--at', '6.5:controller.k:=2', '--at', '7:plant.k:=2']
    storage = ['-p', 'recorder.storage:=sqlite3']
    process = run('exact', '--duration', '8', '--bag', 'bag', *storage, *at)
    assert 'ROS_DOMAIN_ID' in process.stdout.readline()
    assert '0.0 of 8 s' in process.stdout.readline()
    assert 'of 8 s' in process.stdout.readline()  # five seconds on, all signals are there
    os.kill(children(process)['controller'], signal.SIGKILL)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 4
    assert 'controller was killed by SIGKILL' in err
    assert '6.5:controller.k:=2 was not done: controller was killed by SIGKILL\n' in err
    assert 'changed: plant.k:=2 at 7' in out
    assert 'Traceback' not in err
    assert 'bag: bag' in out
    assert (tmp_path / 'bag' / 'metadata.yaml').exists()
    assert (tmp_path / 'bag' / 'bag.db3').exists()


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_stops_its_nodes_and_judges_what_there_is(
    run, children, tmp_path, number
):
    process = run('exact', '--bag', 'bag')
    assert 'exact: exosystem' in process.stdout.readline()
    assert 'of 40 s' in process.stdout.readline()
    nodes = children(process)
    assert set(nodes) == {'exosystem', 'plant', 'controller', 'spike_monitor', 'recorder'}
    time.sleep(1.5)  # something to judge
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 3, err  # too few events of w: undecided
    assert 'interrupted' in err
    assert 'verdict: undecided' in out
    assert all(gone(pid) for pid in nodes.values())


def test_the_nodes_of_a_killed_run_end_with_it(run, children):
    process = run('exact', '--bag', 'bag')
    process.stdout.readline()
    assert 'of 40 s' in process.stdout.readline()
    nodes = children(process)
    process.kill()
    wait_for(lambda: all(gone(pid) for pid in nodes.values()))


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['exact', '-p', 'controller.tau:=-1'], 'controller.tau must be a finite number > 0'),
        (['exact', '-p', 'nonsense'], 'NODE.PARAM:=VALUE'),
        (['missing.yaml'], 'missing.yaml'),
        (['missing'], 'shipped are'),
        (['tab.yaml'], 'spaces, not tabs'),
        (['list.yaml'], 'plant.k must be a finite number'),
        (['exact', '--bag', 'there'], 'exists already'),
        (['exact', '--duration', '-3'], 'finite number > 0'),
        (['exact', '--duration', 'long'], 'finite number > 0'),
        (['exact', '-p', 'plant.time_scale:=5'], 'the same time_scale'),
        (['exact', '--json', 'no/such/file'], 'name another file'),
        (['exact', '-p', 'recorder.storage:=tape'], 'one of mcap, sqlite3'),
        (['lonely.yaml'], 'no plant'),
        ([], 'SCENARIO'),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(run, tmp_path, arguments, words):
    (tmp_path / 'tab.yaml').write_text('plant:\n\tros__parameters: {}\n')
    (tmp_path / 'list.yaml').write_text('plant:\n  ros__parameters:\n    k: [1.0]\n')
    (tmp_path / 'there').mkdir()
    (tmp_path / 'lonely.yaml').write_text('exosystem:\n  ros__parameters: {}\n')
    process = run(*arguments)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 2
    assert len(err.splitlines()) == 1
    assert words in err
    assert out == ''


def test_an_action_after_the_end_is_refused_before_anything_starts(run, tmp_path):
    process = run('exact', '--duration', '8', '--settle', '40', '--at', '8:plant.k:=2')
    out, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert err.count('\n') == 1
    assert 'at 8:plant.k:=2: 8 is not before the end, the duration is 8 s' in err
    assert not out
    assert not list(tmp_path.iterdir())
