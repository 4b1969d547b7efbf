"""The tables of starts of ``ik_mode: complete``."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.kernel.arguments import Starts, Table
from mobo_core.evaluation.kernel.evidence import TURN
from mobo_core.evaluation.kernel.near import CELLS, codes_of, sort_samples
from mobo_core.evaluation.kernel.rows import LANES
from mobo_core.evaluation.kernel.starts import GRID, sort_table, unit_samples

# Configurations sampled, by rules; whole numbers of LANES.
TABLE_SAMPLES = {1: 20_000, 2: 20_000}
# Starts of a pose differ in some joint by this (rad or m), or by this share of the range it is sampled in.
APART, APART_SHARE = 1.0, 0.25


def share(work: Callable[[int, int], None], parts: Iterable[tuple[int, int]], threads: int) -> None:
    """Have ``threads`` threads, this one among them, do ``work`` on the parts, each taking the next one in turn."""
    left = iter(list(parts))

    def take() -> None:
        for low, high in left:
            work(low, high)

    if threads == 1:
        return take()
    with ThreadPoolExecutor(threads - 1) as pool:
        others = [pool.submit(take) for _ in range(threads - 1)]
        take()
    for other in others:
        other.result()


@functools.lru_cache(4)
def _unit_samples(seed: int, n: int, count: int) -> Array:
    """Return the sampled configurations that all arms of ``n`` joints share, as shares of their joint ranges."""
    samples = np.empty((count, n))
    unit_samples(seed, samples)
    return samples


class _Workspace(threading.local):
    """The arrays of a table of starts, kept from one evaluation of a thread to the next.

    They are 5 MB; fresh ones each time would cost as much in page faults as all else about the table.
    """

    def __init__(self) -> None:
        self._arrays: dict[int, tuple[Starts, Array, NDArray[np.int64]]] = {}
        m = TABLE_SAMPLES[2]
        self.cells, self.order = np.empty(m, np.int64), np.empty(m, np.int64)
        self.cell_first = np.empty(CELLS**3 + 1, np.int64)
        self.unsorted, self.poses = np.empty((m, 12), np.float32), np.empty((m, 12), np.float32)

    def arrays(self, n: int) -> tuple[Starts, Array, NDArray[np.int64]]:
        """Return a table, tips (12, m) and cells (m,) for arms of ``n`` joints."""
        if n not in self._arrays:
            m = TABLE_SAMPLES[1]
            self._arrays[n] = (
                Starts(np.empty((m, n)), np.empty(m, np.int64), np.empty(GRID**3 + 1, np.int64), np.empty((12, m))),
                np.empty((12, m)),
                np.empty(m, np.int64),
            )
        return self._arrays[n]


_workspace = _Workspace()


def start_table_1(compiled: ModuleType, chain: Chain, constants: Array, seed: int, threads: int) -> Starts:
    """Return the arm's table of starts by rules 1. The arrays are this thread's, and the next call's too."""
    unit = _unit_samples(seed, chain.n, TABLE_SAMPLES[1])
    table, tips, cells = _workspace.arrays(chain.n)
    q = table.q
    span = chain.upper - chain.lower

    def sample(low: int, high: int) -> None:
        np.multiply(unit[low:high], span, out=q[low:high])
        np.add(q[low:high], chain.lower, out=q[low:high])
        compiled.table_tips(constants, q, low, high, tips)

    share(sample, _parts(len(unit), threads), threads)
    sort_table(tips, chain.placement_p[0], chain.reach_radius, cells, table.order, table.cell_first, table.poses)
    return table


@functools.lru_cache(4)
def _samples(
    seed: int, lower: tuple[float, ...], upper: tuple[float, ...], turns: tuple[bool, ...]
) -> tuple[Array, Array, NDArray[np.int64], Array, Array]:
    """Return configurations (m, n), the same as (m / LANES, n, LANES), their codes, and from where, how far apart.

    Arms of these limits share them, if the same joints turn.

    A joint of more than a full turn is sampled within the turn in the middle of its limits, which holds every angle
    once.
    """
    low, span = np.array(lower), np.array(upper) - np.array(lower)
    most = np.where(turns, TURN, np.inf)
    low = np.where(span > most, low + 0.5 * (span - most), low)
    span = np.minimum(span, most)
    q, apart = _unit_samples(seed, len(lower), TABLE_SAMPLES[2]) * span + low, np.minimum(APART, APART_SHARE * span)
    codes = np.empty(len(q), np.int64)
    codes_of(q, low, apart, codes)
    in_lanes = np.ascontiguousarray(q.reshape(-1, LANES, len(low)).transpose(0, 2, 1))
    return q, in_lanes, codes, low, apart


def start_table_2(compiled: ModuleType, chain: Chain, constants: Array, seed: int, threads: int) -> Table:
    """Return the arm's table of starts by rules 2. The arrays are this thread's, and the next call's too."""
    limits = tuple(chain.lower.tolist()), tuple(chain.upper.tolist())
    q, in_lanes, codes, lower, apart = _samples(seed, *limits, tuple((chain.slide == 0.0).tolist()))
    w, (x, y, z), radius = _workspace, chain.placement_p[0].tolist(), chain.reach_radius
    # This thread's arrays, for the others too.
    cells, unsorted = w.cells, w.unsorted

    def place(low: int, high: int) -> None:
        compiled.table_places(constants, in_lanes, low, high, x, y, z, radius, cells, unsorted)

    share(place, _parts(len(in_lanes), threads), threads)
    sort_samples(cells, unsorted, w.cell_first, w.order, w.poses)
    return Table(q, codes, w.order, w.cell_first, w.poses, lower, apart)


def _parts(m: int, threads: int) -> list[tuple[int, int]]:
    return [(m * i // threads, m * (i + 1) // threads) for i in range(threads)]
