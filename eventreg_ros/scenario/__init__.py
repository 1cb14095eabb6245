"""What is asked: the table of parameters, YAML, the scenario and what may be made of one."""

from .files import config_directory, find, shipped
from .reader import load, parse, with_file, with_overrides
from .scenario import Scenario, block_spec, monitor_defaults

__all__ = [
    'Scenario',
    'block_spec',
    'config_directory',
    'find',
    'load',
    'monitor_defaults',
    'parse',
    'shipped',
    'with_file',
    'with_overrides',
]
