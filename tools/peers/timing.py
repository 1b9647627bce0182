"""CPU and wall time of a piece of work."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

Result = TypeVar("Result")


@dataclass
class Timed:
    """Seconds of processor time (user + system, all threads) and of wall time."""

    cpu_s: float
    wall_s: float


def measure_children(work: Callable[[], Result]) -> tuple[Result, Timed]:
    """Runs work that is done by child processes; their processor time counts."""
    return _measure(work, resource.RUSAGE_CHILDREN)


def measure_self(work: Callable[[], Result]) -> tuple[Result, Timed]:
    """Runs work that is done by this process and its threads."""
    return _measure(work, resource.RUSAGE_SELF)


def _measure(work: Callable[[], Result], who: int) -> tuple[Result, Timed]:
    start_cpu, start_wall = _cpu(who), time.perf_counter()
    result = work()
    return result, Timed(_cpu(who) - start_cpu, time.perf_counter() - start_wall)


def _cpu(who: int) -> float:
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime
