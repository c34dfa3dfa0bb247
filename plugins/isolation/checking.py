"""The conformance suite in a process of its own, so that nothing a plugin does there spoils the verdict."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from ...agent.containment import describe
from ...files.messages import printable
from ..check import Finding, Report, check_behavior
from ..errors import BrokenPluginError, PluginError
from ..loading import BEHAVIORS
from .child import begin, plugins_of
from .process import Subprocess
from .wire import Kind

PATIENCE = 120.0
"""Seconds that the suite may take."""


def check_apart(spec: Mapping[str, Any], confined: bool = False) -> list[Report]:
    """Checks the behaviors of a spec in a subprocess. confined: one that can do no harm, as `--isolate` has.

    Raises: BrokenPluginError.
    """
    child = Subprocess({**spec, "confined": confined}, "checking", PATIENCE)
    child.kill()
    try:
        return [_report(*each) for each in child.hello]
    except (TypeError, ValueError) as fault:
        raise BrokenPluginError(f"the check of {dict(spec)} says nothing sensible: {fault}") from fault


def _report(name: str, findings: list[Mapping[str, Any]]) -> Report:
    found = tuple(
        Finding(printable(str(each["check"])), each["passed"] is True, printable(str(each["fix"])))
        for each in findings
    )
    return Report(printable(str(name)), found)


def main(arguments: list[str]) -> int:
    """Checks what the spec names and tells the reports."""
    spec, channel = begin(arguments)
    try:
        classes = [plugin.load() for plugin in plugins_of(spec) if plugin.group == BEHAVIORS]
        reports = [check_behavior(cls, fresh=True) for cls in classes]
    except BaseException as fault:
        channel.send(Kind.FAULT, describe(fault, kind=not isinstance(fault, PluginError)).encode())
        return 1
    told = [[report.name, [asdict(each) for each in report.findings]] for report in reports]
    channel.send(Kind.HELLO, json.dumps(told).encode())
    return 0


if __name__ == "__main__":
    status = main(sys.argv[1:])
    os._exit(status)
