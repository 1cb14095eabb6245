# SPDX-License-Identifier: Apache-2.0
"""A report as JUnit XML, which CI servers show: a test case for each plant that was judged."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from .rejection import NOT_REJECTED, REJECTED
from .report_table import table
from .verdict import PlantReport, Report

_UNFIT = re.compile('[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
"""What XML cannot hold."""


def as_junit(report: Report) -> str:
    """Return the report as JUnit XML: not rejected is a failure, undecided an error."""
    verdicts = [plant.verdict for plant in report.plants]
    failures = verdicts.count(NOT_REJECTED)
    counts = {
        'tests': str(len(verdicts)),
        'failures': str(failures),
        'errors': str(len(verdicts) - failures - verdicts.count(REJECTED)),
        'time': f'{report.duration / report.time_scale:.3f}',
    }
    suites = ElementTree.Element('testsuites', counts)
    suite = ElementTree.SubElement(suites, 'testsuite', {'name': 'eventreg', **counts})
    for plant in report.plants:
        _add(suite, plant, report, counts['time'])
    out = ElementTree.SubElement(suite, 'system-out')
    out.text = _fit(table(report))
    if report.evidence.warnings:
        said = ElementTree.SubElement(suite, 'system-err')
        said.text = _fit('\n'.join(finding.text for finding in report.evidence.warnings))
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, 'unicode', xml_declaration=True) + '\n'


def _add(suite: ElementTree.Element, plant: PlantReport, report: Report, time: str) -> None:
    name = f'events of {plant.plant.output} are rejected'
    names = {'classname': _fit(report.scenario), 'name': _fit(name), 'time': time}
    case = ElementTree.SubElement(suite, 'testcase', names)
    if plant.verdict != REJECTED:
        kind = 'failure' if plant.verdict == NOT_REJECTED else 'error'
        what = {'type': plant.verdict, 'message': _fit(plant.reason)}
        ElementTree.SubElement(case, kind, what)


def _fit(text: str) -> str:
    return _UNFIT.sub('?', text)
