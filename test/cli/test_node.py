# SPDX-License-Identifier: Apache-2.0
"""eventreg node: what it hands on, and what it refuses."""

import sys

from eventreg_ros.cli.main import main
from eventreg_ros.nodes import executables


def test_it_hands_on_what_follows_the_node(monkeypatch):
    calls = []
    monkeypatch.setattr(executables, 'run', lambda *call: calls.append(call) or 0)
    assert main(['node', 'plant', '--ros-args', '-p', 'k:=2.0', '-r', 'y:=other', '--']) == 0
    assert main(['node', 'link', '--help']) == 0
    assert calls == [
        ('plant', ['--ros-args', '-p', 'k:=2.0', '-r', 'y:=other', '--']),
        ('link', ['--help']),
    ]


def test_help_of_a_node_needs_no_ros(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, 'rclpy', None)
    assert main(['node', 'plant', '--help']) == 0
    assert 'The plant: an excitable neuron' in capsys.readouterr().out


def test_an_unknown_node_is_refused_with_the_names_of_all(refused):
    line = refused('node', 'plnt')
    assert "'plnt'" in line
    assert "'plant'" in line


def test_without_ros_it_says_so_in_one_line(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, 'eventreg_ros.nodes.plant', None)
    monkeypatch.setitem(sys.modules, 'rclpy', None)
    assert main(['node', 'plant']) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.count('\n') == 1
    assert err.startswith('eventreg_ros: plant needs ROS 2')
