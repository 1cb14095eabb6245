# SPDX-License-Identifier: Apache-2.0
"""What is asked: the table of parameters, YAML, the scenario and what may be made of one."""

from .blocks import block_spec
from .criteria import Criteria
from .files import config_directory, find, shipped
from .reader import Override, load, parse, with_file, with_overrides
from .scenario import Scenario

__all__ = [
    'Criteria',
    'Override',
    'Scenario',
    'block_spec',
    'config_directory',
    'find',
    'load',
    'parse',
    'shipped',
    'with_file',
    'with_overrides',
]
