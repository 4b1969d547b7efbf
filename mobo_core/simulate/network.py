"""A simulated network: messages come late, twice, in another order, or not at all."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from mobo_core.simulate.world import Process, World

# Candidates are latched: who starts gets so many of the last.
_LATCHED = 64
_LATENCY_S = (0.0005, 0.005)


@dataclass
class Weather:
    """How bad the network is for the moment.

    Attributes:
        delay_s, jitter_s: s that each message takes longer; up to so many s, differently for each.
        loss, twice: share of messages that get lost, and that come twice.
        cut: hosts that the others do not reach.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    twice: float = 0.0
    cut: set[str] = field(default_factory=set)

    @property
    def fair(self) -> bool:
        """Whether nothing is wrong."""
        return self == Weather()


class Network:
    """Brings what one process publishes to the others.

    Args:
        world: says what happens.
    """

    def __init__(self, world: World) -> None:
        self.weather = Weather()
        self._world, self._random = world, world.chance("network")
        self._takers: dict[str, list[tuple[Process, Callable[[bytes], None]]]] = {}
        self._latched: dict[Process, deque[bytes]] = {}

    def subscribe(self, process: Process, topic: str, take: Callable[[bytes], None]) -> None:
        """Have a process take what others publish on a topic."""
        self._takers.setdefault(topic, []).append((process, take))
        if topic == "candidates":
            for sender, sent in self._latched.items():
                if sender.alive:
                    for data in sent:
                        self._send(sender, process, take, data)

    def publish(self, sender: Process, topic: str, data: bytes) -> None:
        """Send bytes to all who take this topic."""
        if topic == "candidates":
            self._latched.setdefault(sender, deque(maxlen=_LATCHED)).append(data)
        takers = self._takers.get(topic, [])
        if not all(process.alive for process, _ in takers):
            takers = self._takers[topic] = [taker for taker in takers if taker[0].alive]
        for process, take in takers:
            if process is not sender:
                self._send(sender, process, take, data)

    def reaches(self, one: Process, other: Process) -> bool:
        """Return whether messages pass between two processes."""
        return (one.host in self.weather.cut) == (other.host in self.weather.cut)

    def _send(self, sender: Process, process: Process, take: Callable[[bytes], None], data: bytes) -> None:
        weather, random = self.weather, self._random
        if not self.reaches(sender, process) or (weather.loss and random.random() < weather.loss):
            return
        for _ in range(2 if weather.twice and random.random() < weather.twice else 1):
            late = weather.delay_s + (random.uniform(0.0, weather.jitter_s) if weather.jitter_s else 0.0)
            self._world.after(random.uniform(*_LATENCY_S) + late, lambda: process.do(lambda: take(data)))
