"""What pip and colcon install; the entry points are the table of contents."""

from glob import glob

from setuptools import find_packages, setup

package_name = 'eventreg_ros'
NODES = (
    'exosystem',
    'plant',
    'controller',
    'reference',
    'stimulus',
    'spike_monitor',
    'recorder',
    'clock',
    'link',
)
ROS = [
    'ros-jazzy-rclpy==7.1.6',
    'ros-jazzy-common-interfaces==5.3.6',
    'ros-jazzy-rmw-fastrtps-cpp==8.4.3',
]
FRAMES = ['pandas', 'xarray', 'pyarrow']
TEST = [
    *FRAMES,
    'pytest',
    'hypothesis',
    'ruff==0.17.6',
    'mypy==2.4.1',
    'types-PyYAML',
    'colcon-common-extensions',
]

setup(
    name=package_name,
    version='0.1.0',
    description='Neuromorphic disturbance rejection: spiking plants, internal models, event counts',
    long_description=open('README.md', encoding='utf-8').read(),
    long_description_content_type='text/markdown',
    license='Apache-2.0',
    maintainer='eventreg_ros maintainers',
    maintainer_email='maintainers@users.noreply.github.com',
    python_requires='>=3.10',
    packages=find_packages(include=[package_name, package_name + '.*']),
    package_data={package_name: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
        ('share/' + package_name + '/config', sorted(glob('config/*.yaml'))),
        ('share/' + package_name + '/launch', sorted(glob('launch/*.launch.py'))),
    ],
    install_requires=['setuptools', 'numpy', 'scipy', 'matplotlib', 'PyYAML', 'rosbags'],
    extras_require={'ros': ROS, 'fast': ['numba'], 'frames': FRAMES, 'test': TEST},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            *(f'{node} = {package_name}.nodes.executables:{node}' for node in NODES),
            f'eventreg = {package_name}.cli.main:main',
        ],
    },
)
