# SPDX-License-Identifier: Apache-2.0
"""What pip and colcon install."""

from setuptools import setup

package_name = 'own_plant'

setup(
    name=package_name,
    version='0.1.0',
    description='A plant of your own behind the controller of eventreg_ros',
    license='Apache-2.0',
    packages=[package_name],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
        ('share/' + package_name + '/config', ['config/membrane.yaml']),
    ],
    install_requires=['eventreg_ros'],
    entry_points={'console_scripts': ['membrane = own_plant.membrane:main']},
)
