# SPDX-License-Identifier: Apache-2.0
"""What pip and colcon install: eventreg in bin/, where both put it on the path, the rest below."""

from pathlib import Path

from setuptools import Distribution, find_packages, setup

PACKAGE = 'eventreg_ros'
PAPER = 'https://arxiv.org/abs/2505.11133'

ROOT = Path(__file__).resolve().parent
"""Where the sources are: colcon build --symlink-install runs a link to this file from elsewhere."""

ROS_WHEELS = (
    "; sys_platform == 'linux' and platform_machine == 'x86_64' and python_version < '3.14'"
)
ROS = [
    'ros-jazzy-rclpy==7.1.6' + ROS_WHEELS,
    'ros-jazzy-common-interfaces==5.3.6' + ROS_WHEELS,
    'ros-jazzy-rmw-fastrtps-cpp==8.4.3' + ROS_WHEELS,
]
DOCS = ['sphinx>=7.3', 'myst-nb>=1.1', 'jupytext>=1.16', 'furo>=2024.1', 'latex2mathml>=3.77']
FRAMES = ['pandas>=2.1', 'xarray>=2024.1', 'pyarrow>=14']
TEST = [
    *FRAMES,
    'argcomplete>=2.0',
    'foxglove-sdk>=0.30',
    'pytest>=7.4',
    'pytest-xdist>=3.6',
    'hypothesis>=6.98',
    'ruff==0.17.6',
    'mypy==2.4.1',
    'types-PyYAML>=6.0',
    'colcon-common-extensions>=0.3',
    'setuptools>=70.1,<80',  # builds wheels by itself, and still links for colcon
]


class WithData(Distribution):
    """A distribution whose editable wheels hold the data files too."""

    def has_data(self):
        """Answer what setuptools asks for, where distutils says has_data_files."""
        return self.has_data_files()


def files(pattern):
    """Return the files that match, from the folder of the sources."""
    return sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob(pattern))


setup(
    distclass=WithData,
    name=PACKAGE,
    version='0.1.0',
    description='Neuromorphic disturbance rejection: spiking plants, internal models, event counts',
    long_description=(ROOT / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    url=PAPER,
    project_urls={'Paper': PAPER},
    author='eventreg_ros maintainers',
    author_email='maintainers@users.noreply.github.com',
    maintainer='eventreg_ros maintainers',
    maintainer_email='maintainers@users.noreply.github.com',
    license='Apache-2.0',
    keywords=[
        'ROS 2', 'neuromorphic control', 'spiking neurons', 'event regulation',
        'disturbance rejection', 'internal model principle', 'FitzHugh-Nagumo',
    ],
    classifiers=[
        'Development Status :: 4 - Beta',
        'Intended Audience :: Developers',
        'Intended Audience :: Education',
        'Intended Audience :: Science/Research',
        'Operating System :: OS Independent',
        'Programming Language :: Python :: 3',
        'Programming Language :: Python :: 3.10',
        'Programming Language :: Python :: 3.11',
        'Programming Language :: Python :: 3.12',
        'Programming Language :: Python :: 3.13',
        'Topic :: Scientific/Engineering',
        'Typing :: Typed',
    ],
    python_requires='>=3.10',
    packages=find_packages(include=[PACKAGE, PACKAGE + '.*']),
    package_data={PACKAGE: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + PACKAGE]),
        ('share/' + PACKAGE, ['package.xml']),
        ('share/' + PACKAGE + '/config', files('config/*.yaml')),
        ('share/' + PACKAGE + '/launch', files('launch/*.launch.py')),
        ('share/' + PACKAGE + '/layouts', files('layouts/*')),
        ('lib/' + PACKAGE, files('resource/executables/*')),
    ],
    install_requires=[
        'numpy>=1.26',
        'scipy>=1.11',
        'matplotlib>=3.6',
        'PyYAML>=6.0',
        'rosbags>=0.11.6,<0.12',  # bags/writer.py gives its writer a storage
        'lz4>=4.0',
        "backports.zstd>=1.0; python_version < '3.14'",
    ],
    extras_require={
        'ros': ROS,
        'fast': ['numba>=0.59'],
        'frames': FRAMES,
        'live': ['foxglove-sdk>=0.30'],
        'indices': ['SALib>=1.5'],
        'cluster': ['distributed>=2024.1'],
        'completion': ['argcomplete>=2.0'],
        'docs': DOCS,
        'test': TEST,
    },
    zip_safe=False,
    entry_points={'console_scripts': [f'eventreg = {PACKAGE}.__main__:main']},
)  # fmt: skip
