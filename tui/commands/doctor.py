"""``sayso doctor``: looks for what is missing, says how to get it, and changes nothing."""

from __future__ import annotations

from argparse import Namespace

from engine.errors import ExitCode
from tui.commands.output import data, json_line
from tui.commands.settings import load_settings
from tui.diagnosis import Finding, examine

MARKS = {"ok": "✓", "limited": "!", "missing": "✗"}


def run(arguments: Namespace) -> int:
    """Examine everything. Exit code 3 when something is missing that sayso cannot do without."""
    settings = load_settings(arguments)
    findings: list[Finding] = []
    for finding in examine(settings):
        findings.append(finding)
        if arguments.json:
            json_line(finding)
        else:
            data(f"{MARKS[finding.state]} {finding.name:<18} {finding.detail}")
            if finding.fix:
                data(f"  {'':<18} → {finding.fix}")
    needed = [finding for finding in findings if finding.state == "missing" and finding.needed]
    return int(ExitCode.MISSING if needed else ExitCode.DONE)
