# SPDX-License-Identifier: Apache-2.0
"""metadata.yaml of every version, and such as were made to hurt."""

import pytest

from eventreg_ros.bags.metadata import custom_data, parse

TEXT = """\
rosbag2_bagfile_information:
  version: {version}
  storage_identifier: sqlite3
  relative_file_paths: [{files}]
  duration: {{nanoseconds: 5}}
  starting_time: {{nanoseconds_since_epoch: 1}}
  message_count: 12
  topics_with_message_count:
    - {{topic_metadata: {{name: /y, type: std_msgs/msg/Float64, serialization_format: cdr{qos}}},
        message_count: 12}}
  {more}
"""

VERSIONS = {
    1: ('bag/bag_0.db3, bag/bag_1.db3', '', ''),
    2: ('bag/bag_0.db3, bag/bag_1.db3', '', ''),
    3: ('bag/bag_0.db3, bag/bag_1.db3', '', 'compression_format: ""\n  compression_mode: ""'),
    4: ('bag_0.db3, bag_1.db3', ', offered_qos_profiles: "- history: 3"', 'compression_mode: ""'),
    5: ('bag_0.db3, bag_1.db3', ', offered_qos_profiles: ""', 'files: []'),
    6: ('bag_0.db3, bag_1.db3', '', 'custom_data: ~'),
    7: ('bag_0.db3, bag_1.db3', ', type_description_hash: RIHS01_7', 'custom_data: {a: b}'),
    8: ('bag_0.db3, bag_1.db3', '', 'ros_distro: jazzy'),
    9: ('bag_0.db3, bag_1.db3', ', offered_qos_profiles: [{history: keep_last}]', 'files: ~'),
}


@pytest.mark.parametrize('version', VERSIONS)
def test_every_version(version):
    files, qos, more = VERSIONS[version]
    found = parse(TEXT.format(version=version, files=files, qos=qos, more=more))
    assert found.files == ('bag_0.db3', 'bag_1.db3')
    assert found.counts == {'/y': 12}
    assert found.types == {'/y': 'std_msgs/msg/Float64'}
    assert found.custom == ({'a': 'b'} if version == 7 else {})


LAUGHS = '\n'.join(
    ['a0: &a0 [1, 1]', *(f'a{i}: &a{i} [{", ".join([f"*a{i - 1}"] * 9)}]' for i in range(1, 30))]
)


@pytest.mark.parametrize(
    'text',
    [
        '[' * 100_000, '{a: ' * 100_000, '- ' * 100_000, '!!python/object/apply:os.getcwd []',
        'rosbag2_bagfile_information: 1', 'rosbag2_bagfile_information: [', '\x00', '',
        'a: &a {b: 1}\nc: {<<: [*a, *a]}', LAUGHS,
    ],
)  # fmt: skip
def test_what_is_no_metadata_is_none_at_once(text):
    assert parse(text) is None
    assert custom_data(text) == {}


def test_types_that_are_not_those_are_left_out():
    found = parse(
        'rosbag2_bagfile_information: {relative_file_paths: [3, x, [y]], custom_data: {a: 1, b: c},'
        ' topics_with_message_count: [3, {topic_metadata: 4}, {message_count: x}]}'
    )
    assert found.files == ('x',)
    assert found.custom == {'b': 'c'}
    assert found.counts == {}


def test_aliases_are_not_expanded():
    found = parse('rosbag2_bagfile_information:\n  ' + LAUGHS.replace('\n', '\n  '))
    assert found.custom == {}
