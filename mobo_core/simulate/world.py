"""Time and chance of a simulation, and the processes that live in it."""

from __future__ import annotations

import heapq
import traceback
from collections import deque
from collections.abc import Callable
from itertools import count
from random import Random

from mobo_core.errors import MoboError
from mobo_core.simulate.violation import KilledError, Violation

# The wall clock at the beginning, ns since the epoch.
_EPOCH_NS = 1_800_000_000 * 10**9
_TRACE_LINES = 60

Action = Callable[[], None]


class World:
    """What happens next, and when; all chance comes from one seed.

    Args:
        seed: of all that is drawn while time passes.

    Attributes:
        now: s since the beginning.
        wall_shift_s: s by which the wall clock is wrong.
        trace: the latest lines on what happened.
        failures: trial -> how often an evaluation of it was made to fail.
        lies: answers (CDR bytes) that are false, and do not look it.
    """

    def __init__(self, seed: int) -> None:
        self.now = 0.0
        self._seed = seed
        self.wall_shift_s = 0.0
        self.trace: deque[str] = deque(maxlen=_TRACE_LINES)
        self.failures: dict[int, int] = {}
        self.lies: set[bytes] = set()
        self._events: list[tuple[float, int, Action]] = []
        self._numbers = count()

    def chance(self, whose: str) -> Random:
        """Return where the chance of one of many comes from: what the others draw is no matter to it."""
        return Random(f"{self._seed} {whose}")

    def after(self, seconds: float, action: Action) -> None:
        """Let something happen so many seconds from now."""
        heapq.heappush(self._events, (self.now + seconds, next(self._numbers), action))

    def run(self, until: float, done: Callable[[], bool]) -> bool:
        """Let time pass until ``done`` holds, and return true; false if it does not by ``until``."""
        while not done():
            if not self._events or self._events[0][0] > until:
                self.now = until
                return False
            self.now, _, action = heapq.heappop(self._events)
            action()
        return True

    def wall_ns(self) -> int:
        """Return the wall clock's time, ns since the epoch."""
        return _EPOCH_NS + int((self.now + self.wall_shift_s) * 1e9)

    def say(self, text: str) -> None:
        """Add a line to the trace."""
        self.trace.append(f"{self.now:9.3f} s  {text}")

    def may_fail(self, trial: int, most: int) -> bool:
        """Return whether one more evaluation of a trial may fail without the trial failing, and count it."""
        if self.failures.get(trial, 0) >= most:
            return False
        self.failures[trial] = self.failures.get(trial, 0) + 1
        return True


class Process:
    """A simulated process: it may be dead, or hang, and has a clock of its own.

    Args:
        world: it lives in.
        name: of its node.
        host: it runs on.

    Attributes:
        alive: whether it runs.
        rate: how fast its clock goes.
        shift_s: s it is ahead.
    """

    def __init__(self, world: World, name: str, host: str) -> None:
        self.world, self.name, self.host = world, name, host
        self.alive = True
        self.rate = 1.0
        self.shift_s = 1000.0
        self._held: list[Action] = []
        self._hung_until = 0.0

    def clock(self) -> float:
        """Return s of its own monotonic clock."""
        return self.shift_s + self.world.now * self.rate

    @property
    def hangs(self) -> bool:
        """Whether it does nothing for the moment."""
        return self.world.now < self._hung_until

    def do(self, action: Action) -> None:
        """Do something in this process: now, when it wakes up, or never."""
        if not self.alive:
            return
        if self.hangs:
            self._held.append(action)
            return
        try:
            action()
            self.look()
        except KilledError:
            self.kill()
        except MoboError as error:
            self.world.say(f"{self.name} ends: {error}")
            self.ends(error)
        except Violation:
            raise
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            raise Violation("no crash", f"{self.name}: {error!r} ({where.name}, line {where.lineno})") from error

    def every(self, seconds: float, action: Action, first: float = 0.0) -> None:
        """Do something again and again, as a timer does."""

        def ring() -> None:
            if self.alive:
                self.do(action)
                # A timer that comes late does not ring for what it missed.
                self.world.after(max(seconds / self.rate, self._hung_until - self.world.now), ring)

        self.world.after(first, ring)

    def hang(self, seconds: float) -> None:
        """Do nothing for so long; what comes in meanwhile waits."""
        if not self.hangs:
            self.world.after(seconds, self._wake)
            self._hung_until = self.world.now + seconds
            self.world.say(f"{self.name} hangs for {seconds:.1f} s")

    def _wake(self) -> None:
        held, self._held = self._held, []
        for action in held:
            self.do(action)

    def kill(self) -> None:
        """End at once."""
        if self.alive:
            self.alive = False
            self.world.say(f"{self.name} killed")
            self.is_gone()

    def ends(self, error: MoboError) -> None:
        """End with an error."""
        self.alive = False
        self.is_gone()

    def is_gone(self) -> None:
        """Give back what the kernel takes back of a process that has ended."""

    def look(self) -> None:
        """See that all is well after each thing it did."""
