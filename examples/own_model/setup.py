# SPDX-License-Identifier: Apache-2.0
"""What pip and colcon install; the entry point adds the model to eventreg_ros."""

from setuptools import setup

setup(
    name='own_model',
    version='0.1.0',
    description='A model of your own for eventreg_ros',
    license='Apache-2.0',
    packages=['own_model'],
    install_requires=['eventreg_ros'],
    entry_points={'eventreg_ros.models': ['van_der_pol = own_model:VAN_DER_POL']},
)
