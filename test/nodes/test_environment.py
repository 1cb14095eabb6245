# SPDX-License-Identifier: Apache-2.0
"""What of the environment ROS would fail on: refused before it does, with the remedy."""

import tempfile

import pytest

from eventreg_ros.errors import EventregError
from eventreg_ros.nodes import environment


@pytest.fixture(autouse=True)
def _fine(tmp_path, monkeypatch):
    monkeypatch.setitem(FINE, 'HOME', str(tmp_path))


FINE: dict[str, str] = {}


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        ({'ROS_DOMAIN_ID': 'abc'}, "must be a whole number from 0 to 232, got 'abc'"),
        ({'ROS_DOMAIN_ID': '300'}, "must be a whole number from 0 to 232, got '300'"),
        ({'ROS_DOMAIN_ID': '9' * 400}, 'must be a whole number from 0 to 232'),
        ({'ROS_STATIC_PEERS': '127.0.0.1;not a host;'}, "names 'not a host', which has no address"),
        ({'ROS_STATIC_PEERS': 'é..'}, 'has no address'),
        ({'HOME': ''}, 'no place for its logs: HOME is not set'),
        ({'ROS_LOG_DIR': '/dev/null/x'}, "cannot write its logs to '/dev/null/x': not a directory"),
        ({'ROS_HOME': '/dev/null'}, "cannot write its logs to '/dev/null/log': not a directory"),
        ({'ROS_LOG_DIR': '/proc'}, "cannot write its logs to '/proc'"),
    ],
)
def test_what_ros_would_fail_on_is_refused(given, words):
    with pytest.raises(EventregError) as caught:
        environment.check(FINE | given)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    'given',
    [
        {},
        {'ROS_DOMAIN_ID': ''},
        {'ROS_DOMAIN_ID': '232'},
        {'ROS_STATIC_PEERS': '127.0.0.1;;'},
        {'ROS_STATIC_PEERS': 'nobody here', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'},
        {'HOME': '', 'ROS_LOG_DIR': tempfile.gettempdir()},
    ],
)
def test_what_ros_takes_passes(given):
    environment.check(FINE | given)


@pytest.mark.parametrize(
    ('text', 'domain'),
    [('', 0), ('7', 7), (' 5', 5), ('5x', 5), ('0x10', 16), ('010', 10), ('-1', 0)],
)
def test_a_domain_is_read_as_ros_reads_it(text, domain):
    assert environment.domain_of({'ROS_DOMAIN_ID': text}) == domain


def test_a_middleware_that_is_not_installed_is_named_with_those_that_are(tmp_path, monkeypatch):
    monkeypatch.setattr('sys.prefix', str(tmp_path / 'none'))
    packages = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages'
    packages.mkdir(parents=True)
    for name in ('rmw_fastrtps_cpp', 'rmw_fastrtps_shared_cpp', 'rmw_implementation'):
        (packages / name).touch()
    given = {**FINE, 'AMENT_PREFIX_PATH': str(tmp_path)}
    environment.check({**given, 'RMW_IMPLEMENTATION': 'rmw_fastrtps_cpp'})
    with pytest.raises(EventregError, match=r'rmw_nope.* \(there is rmw_fastrtps_cpp\)'):
        environment.check({**given, 'RMW_IMPLEMENTATION': 'rmw_nope'})
    environment.check({**FINE, 'RMW_IMPLEMENTATION': 'rmw_nope'})  # nobody knows


def test_security_is_refused_where_there_is_none(monkeypatch):
    for without in (True, False):
        monkeypatch.setattr(environment, 'without_security', lambda without=without: without)
        environment.check_security({'ROS_SECURITY_ENABLE': 'false'})
        if without:
            with pytest.raises(EventregError, match='built without security, as the wheels'):
                environment.check_security({'ROS_SECURITY_ENABLE': 'true'})
        else:
            environment.check_security({'ROS_SECURITY_ENABLE': 'true'})


@pytest.mark.parametrize(
    'given', [{'ROS_DOMAIN_ID': '300'}, {'RMW_IMPLEMENTATION': 'rmw_nope'}, {'HOME': ''}]
)
def test_a_node_and_a_run_end_with_2_and_one_line(eventreg, given, tmp_path, domain, monkeypatch):
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    for arguments in (['node', 'plant'], ['run', 'exact', '--bag', tmp_path / 'bag']):
        result = eventreg(*arguments)
        assert (result.returncode, result.stdout, result.stderr.count('\n')) == (2, '', 1)
        assert next(iter(given)) in result.stderr
