"""An optimizer's way to its namespace: it claims, listens, takes namespace and bag, and then holds both.

Messages and time come in as arguments, so that this is the same for a node and for a simulation.
"""

from __future__ import annotations

from collections.abc import Callable

from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.namespace_claim import Claimant, NamespaceClaim, Rivals, in_use
from mobo_core.errors import InputError, InUseError
from mobo_core.messages import OptimizerStatus, decode, encode

# Who is known on this host, by process id.
Known = Callable[[int], Claimant | None]


class Namespace:
    """What one optimizer says and hears of a namespace, which it claims from construction on.

    Call :meth:`repeat` every 0.1 s, and every second once :attr:`holding`.

    Args:
        message: who claims, and what it means to run.
        where: the namespace, for people.
        now: s, of the clock that all methods take.
        lease_s: s to wait for a holder that may have vanished.
        lock: takes the host's lock on the namespace, or raises InUseError.
        publish: sends bytes on a topic (relative name): ``claims``, and ``optimizers`` once it holds.
        say: takes lines for people.

    Attributes:
        holding: whether the namespace is taken.
    """

    def __init__(
        self,
        message: OptimizerStatus,
        where: str,
        now: float,
        *,
        lease_s: float,
        lock: Callable[[Known], object],
        publish: Callable[[str, bytes], None],
        say: Callable[[str], None],
    ) -> None:
        self._message, self._where, self._lease_s = message, where, lease_s
        self._take_lock, self._publish, self._say_line = lock, publish, say
        self._claim = NamespaceClaim(claimant(message), now, lease_s=lease_s)
        self._rivals = Rivals(self._claim.me)
        self._lock: object = None
        self._until: float | None = None
        self._said = ""
        self.holding = False

    def take(self, open_bag: Callable[[], StudyBag], now: float) -> StudyBag | None:
        """Return the bag once both it and the namespace are this optimizer's; None as long as they are not.

        Raises:
            InUseError: another optimizer has one of them, and still had after a lease.
        """
        if self._claim.may_go(now, self._where):
            try:
                if self._lock is None:
                    self._lock = self._take_lock(self._claim.known)
                return open_bag()
            except InUseError as error:
                self._until = self._until or now + self._lease_s
                if now >= self._until:
                    raise
                self._say(f"{error}; waiting {self._lease_s:g} s for it to vanish")
        elif (other := self._claim.in_the_way(now)) is not None and other.pid:
            self._say(f"{self._where} is in use by {other}; waiting {self._lease_s:g} s for it to vanish")
        return None

    def hold(self) -> None:
        """Tell the others from now on that the namespace is taken."""
        self.holding = True
        self.repeat()

    def repeat(self) -> None:
        """Say again who claims or holds the namespace."""
        self._publish("optimizers" if self.holding else "claims", encode(self._message))

    def alive(self, holders: int) -> None:
        """Take from the network how many holders are alive."""
        self._claim.alive(holders)

    def on_claim(self, data: bytes, now: float) -> None:
        """Take another's claim (CDR bytes of an OptimizerStatus); who holds the namespace answers with its name."""
        other = _read(data)
        if other is None or other == self._claim.me:
            return
        self._claim.claimed(other, now)
        if self.holding:
            self.repeat()

    def on_holder(self, data: bytes, now: float) -> None:
        """Take a holder's word (CDR bytes of an OptimizerStatus).

        Raises:
            InUseError: this one holds the namespace too, and began later.
        """
        other = _read(data)
        if other is None or other == self._claim.me:
            return
        if not self.holding:
            self._claim.held(other, now)
        elif self._rivals.heard(other, now):
            # Two networks that became one, say: the study that began later ends.
            raise in_use(other, self._where)

    def _say(self, text: str) -> None:
        if text != self._said:
            self._said = text
            self._say_line(text)


def claimant(message: OptimizerStatus) -> Claimant:
    """Return who sent a message."""
    return Claimant(message.header.time_ns, message.host_id, message.pid, message.optimizer)


def _read(data: bytes) -> Claimant | None:
    try:
        return claimant(decode(OptimizerStatus, data))
    except InputError:
        return None
