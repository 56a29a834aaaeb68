"""How every benchmark reports: one JSON object for programs, or the same figures as a table for people.

The object is ``{"bench", "n", "machine", "figures": {NAME: {"min", "median", "p95", "p99", "max", "unit"}}, "ratios":
{NAME: number}}``. Ratios are what to compare between machines; figures are what to read on one machine.
"""

from __future__ import annotations

import json as json_lines
import os
import platform
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from rich.console import Console
from rich.table import Table


class Figure(TypedDict):
    """Order statistics of one quantity, in ``unit``."""

    min: float
    median: float
    p95: float
    p99: float
    max: float
    unit: str


class Report(TypedDict):
    """What one run of a benchmark found."""

    bench: str
    n: int
    machine: dict[str, Any]
    figures: dict[str, Figure]
    ratios: dict[str, float]


def figures(samples: Iterable[float], unit: str) -> Figure:
    """Order statistics of ``samples``. Raises ``ValueError`` when there are none: nothing was measured."""
    values = np.asarray(list(samples), dtype=float)
    if values.size == 0:
        raise ValueError("no samples: nothing was measured")
    low, median, p95, p99, high = np.percentile(values, (0, 50, 95, 99, 100))
    return Figure(
        min=_rounded(low), median=_rounded(median), p95=_rounded(p95), p99=_rounded(p99), max=_rounded(high), unit=unit
    )


def machine() -> dict[str, Any]:
    """What the figures were measured on; the load average tells how quiet it was."""
    return {
        "cpu": _cpu(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1,
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
    }


def report(bench: str, n: int, found: Mapping[str, Figure], ratios: Mapping[str, float] | None = None) -> Report:
    """Put a report together; ``n`` is the number of trials."""
    return Report(
        bench=bench,
        n=n,
        machine=machine(),
        figures=dict(found),
        ratios={name: _rounded(value) for name, value in (ratios or {}).items()},
    )


def print_report(result: Report, json: bool) -> None:
    """Write the report to stdout, as one line of JSON or as a table."""
    if json:
        sys.stdout.write(json_lines.dumps(result) + "\n")
        sys.stdout.flush()
        return
    console = Console()
    where = result["machine"]
    table = Table(
        title=f"{result['bench']} (n = {result['n']})",
        caption=f"{where['cpu']}, {where['cores']} cores, load {where['load']}, Python {where['python']}",
    )
    table.add_column("figure")
    columns = ("min", "median", "p95", "p99", "max")
    for column in columns:
        table.add_column(column, justify="right")
    table.add_column("unit")
    for name, figure in result["figures"].items():
        values: Mapping[str, Any] = figure
        table.add_row(name, *(f"{values[column]:.4g}" for column in columns), figure["unit"])
    console.print(table)
    for name, ratio in result["ratios"].items():
        console.print(f"  {name}: {ratio:.4g}")


def _rounded(value: float) -> float:
    """Six significant digits: more is noise, fewer loses microseconds."""
    return float(f"{float(value):.6g}")


def _cpu() -> str:
    facts = Path("/proc/cpuinfo")
    if facts.exists():
        for line in facts.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
