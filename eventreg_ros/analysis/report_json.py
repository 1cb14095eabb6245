# SPDX-License-Identifier: Apache-2.0
"""A report as JSON, key for key as the contract has it; here and nowhere else."""

from __future__ import annotations

from typing import Any

from ..bags.finding import Finding
from .evidence import Evidence
from .learning import Learned
from .messages import Messages, messages
from .rejection import Rejection
from .verdict import PlantReport, Report, SignalSummary


def as_json(report: Report) -> dict[str, Any]:
    """Return what ``--json`` of simulate, run and analyze writes; times are model time."""
    sent = messages(report)
    found: dict[str, Any] = {
        'scenario': report.scenario,
        'time_scale': report.time_scale,
        'duration': report.duration,
        'settle': report.settle,
        'verdict': report.verdict,
        'reason': report.reason,
        'evidence': _evidence(report.evidence),
        'rejection': _rejection(report.rejection),
        'residual': report.residual._asdict(),
        'synchronisation': report.synchronisation._asdict(),
        'signals': {
            name: _signal(summary, sent.get(name)) for name, summary in report.signals.items()
        },
    }
    if len(report.plants) > 1:
        found['plants'] = {each.plant.output: _plant(each) for each in report.plants}
    if report.learned:
        found['learned'] = {each.signal: _learned(each) for each in report.learned}
    if report.changes:
        found['changes'] = [change._asdict() for change in report.changes]
    return found


def _evidence(evidence: Evidence) -> dict[str, Any]:
    return {
        'span': list(evidence.span),
        'seen': dict(evidence.seen),
        'warnings': [_finding(finding) for finding in evidence.warnings],
    }


def _finding(finding: Finding) -> dict[str, Any]:
    return finding._asdict()


def _rejection(rejection: Rejection) -> dict[str, Any]:
    return {**vars(rejection), 'ratio': rejection.ratio}


def _plant(plant: PlantReport) -> dict[str, Any]:
    return {
        'verdict': plant.verdict,
        'rejection': _rejection(plant.rejection),
        'residual': plant.residual._asdict(),
    }


def _learned(learned: Learned) -> dict[str, Any]:
    return {key: value for key, value in vars(learned).items() if key != 'signal'}


def _signal(summary: SignalSummary, sent: Messages | None) -> dict[str, Any]:
    found: dict[str, Any] = {
        'samples': summary.samples,
        'min': summary.min,
        'max': summary.max,
        'events': list(summary.events),
    }
    if summary.timing is not None:
        found['timing'] = summary.timing._asdict()
    if sent is not None:
        found['messages'] = sent._asdict()
    if summary.energy is not None:
        found['energy'] = summary.energy
    return found
