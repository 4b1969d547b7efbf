"""Which of several optimizers gets a namespace: exactly one. Pure logic: time comes in as an argument."""

from __future__ import annotations

from typing import NamedTuple

from mobo_core.errors import InUseError

# Twice as long as optimizers on one network take to find each other, when all is well.
LISTEN_S = 1.0
# A claim is repeated ten times in this time.
CLAIM_FRESH_S = 1.0
# A rival to a holder is believed after so long, in which it was heard without a gap.
_RIVAL_S, _RIVAL_GAP_S, _MOST_RIVALS = 2.0, 2.5, 100


class Claimant(NamedTuple):
    """An optimizer that holds or claims a namespace; the smaller one goes first.

    Attributes:
        since_ns: when it began to, ns since the epoch by its own clock.
        host, pid, node: who it is.
    """

    since_ns: int
    host: str
    pid: int
    node: str

    def __str__(self) -> str:
        return f"{self.node} on {self.host}, pid {self.pid}"


class NamespaceClaim:
    """A claim to a namespace, from the first moment to the verdict.

    It succeeds after ``listen_s`` in which neither a holder nor an earlier claimant was heard of. It fails
    once others have stood in its way for ``lease_s``: a holder that was killed is gone by then.

    Args:
        me: who claims.
        now: s, of the clock that all methods take.
        lease_s: s to wait for a holder that may have vanished.
        listen_s: s to listen.
    """

    def __init__(self, me: Claimant, now: float, *, lease_s: float, listen_s: float = LISTEN_S) -> None:
        self.me, self._lease_s, self._listen_s = me, lease_s, listen_s
        self._claims: dict[Claimant, float] = {}
        self._holder: Claimant | None = None
        self._holder_heard = -1e9
        self._alive = False
        self._clear_since: float | None = now
        self._in_the_way_since: float | None = None

    def claimed(self, other: Claimant, now: float) -> None:
        """Take another's claim."""
        self._claims[other] = now

    def held(self, holder: Claimant, now: float) -> None:
        """Take a holder's word that it holds the namespace."""
        self._holder, self._holder_heard = holder, now

    def alive(self, holders: int) -> None:
        """Take from the network how many holders are alive."""
        self._alive = holders > 0

    def known(self, pid: int) -> Claimant | None:
        """Return whom of those on this host, by its process id, this claim has heard of."""
        heard = [*self._claims, *([] if self._holder is None else [self._holder])]
        return next((other for other in heard if (other.host, other.pid) == (self.me.host, pid)), None)

    def in_the_way(self, now: float) -> Claimant | None:
        """Return whom this claim waits for, if anyone."""
        rivals = [other for other, heard in self._claims.items() if now - heard < CLAIM_FRESH_S and other < self.me]
        if self._alive or now - self._holder_heard < CLAIM_FRESH_S:
            return self._holder or Claimant(0, "an unknown host", 0, "an optimizer")
        return min(rivals, default=None)

    def may_go(self, now: float, where: str) -> bool:
        """Return whether the namespace is this claimant's, which ``where`` describes.

        Raises:
            InUseError: others have been in the way for ``lease_s``.
        """
        other = self.in_the_way(now)
        if other is None:
            self._in_the_way_since = None
            if self._clear_since is None:
                self._clear_since = now
            return now - self._clear_since >= self._listen_s
        self._clear_since = None
        if self._in_the_way_since is None:
            self._in_the_way_since = now
        if now - self._in_the_way_since >= self._lease_s:
            raise in_use(other, where)
        return False


class Rivals:
    """Who else says that it holds the namespace, and began earlier, while this one runs.

    A holder repeats its name every second. One that is heard once, or now and then, is none: a forged or late message
    shall not end a study.

    Args:
        me: who holds it.
    """

    def __init__(self, me: Claimant) -> None:
        self._me = me
        self._heard: dict[Claimant, tuple[float, float]] = {}  # first and last time without a gap

    def heard(self, other: Claimant, now: float) -> bool:
        """Take that another says so; return whether this one shall end."""
        if other >= self._me:
            return False
        first, last = self._heard.get(other, (now, now))
        first = first if now - last <= _RIVAL_GAP_S else now
        if other in self._heard or len(self._heard) < _MOST_RIVALS:
            self._heard[other] = first, now
        return now - first >= _RIVAL_S


def in_use(other: Claimant, where: str) -> InUseError:
    """Return the error that names who has the namespace."""
    return InUseError(f"in use by {other}", where=where, expected="a namespace in which no optimizer runs")
