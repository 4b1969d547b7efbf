"""The types of joints that an arm is made of, and the orders that they make."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from mobo_core.registry import Registry


@dataclass(frozen=True)
class JointType:
    """A type of joint.

    Attributes:
        letter: a capital, the type's name in joint orders such as ``YPPYPY``.
        long_name: for people, such as ``roll``.
        xacro: name of the macro that makes such a joint and the link that follows it; its parameters are ``index``
            (from 1), ``parent`` (a link), ``offset`` (m, from the parent's joint) and ``length`` (m, of the link).
        axis: x, y, z of its axis when all joints are at zero and the arm points straight up (z).
        colour: of the joint in pictures, ``#rrggbb``.
        motion: of the joint: it turns about its axis, or slides along it.
        file: with the macro; None: ``<xacro>.xacro`` in mobo's own folder. It may call the macros and use the
            materials of mobo's ``common.xacro``.
        next_built: letter of the joint that is built after this one whatever was sampled, since every other one would
            be redundant; None if there is no such rule.
        second_built: letter of the joint that is built after this one where another of this type was sampled, since
            that would be redundant; None if there is no such rule.
    """

    letter: str
    long_name: str
    xacro: str
    axis: tuple[float, float, float]
    colour: str
    motion: Literal["revolute", "prismatic"] = "revolute"
    file: Path | None = None
    next_built: str | None = None
    second_built: str | None = None

    def __post_init__(self) -> None:
        """Check the letter."""
        if len(self.letter) != 1 or not "A" <= self.letter <= "Z":
            raise ValueError(f"joint letter {self.letter!r}; expected a capital, A to Z")

    @property
    def name(self) -> str:
        """The letter."""
        return self.letter


# The colours can be told apart by all eyes. After Y comes P: a second yaw would be redundant, and a roll there is a
# pitch seen from a yaw turned by a right angle (Kawaharazuka et al., Advanced Robotics 2025, section 2.1). Two slides
# in a row move along one axis: in place of the second comes a pitch, as after a yaw. A slide right before a yaw does
# what one right after it would.
JOINTS = Registry(
    "joint type",
    "mobo.joints",
    JointType,
    (
        JointType("R", "roll", "roll", (1.0, 0.0, 0.0), "#cc79a7"),
        JointType("P", "pitch", "pitch", (0.0, 1.0, 0.0), "#0072b2"),
        JointType("Y", "yaw", "yaw", (0.0, 0.0, 1.0), "#e69f00", next_built="P"),
        JointType("S", "slide", "slide", (0.0, 0.0, 1.0), "#009e73", motion="prismatic", second_built="P"),
    ),
)


# Of the types that a space draws unless it says otherwise.
DEFAULT_LETTERS = "RPY"


def joint_letters() -> str:
    """Return all letters with their names, as people read them: ``R (roll), P (pitch) or Y (yaw)``."""
    *others, last = (f"{joint.letter} ({joint.long_name})" for joint in JOINTS.values())
    return f"{', '.join(others)} or {last}"


def yaw_rule(letters: str) -> str:
    """Return which joints are built whatever was sampled, for people: ``after a yaw comes a pitch``.

    Args:
        letters: of the types that are sampled.
    """
    types = [joint for joint in JOINTS.values() if joint.letter in letters]
    rules = [("after a {} comes a {}", joint, joint.next_built) for joint in types]
    rules += [("in place of a second {} in a row comes a {}", joint, joint.second_built) for joint in types]
    return ", ".join(rule.format(joint.long_name, JOINTS[built].long_name) for rule, joint, built in rules if built)


def _built(before: str, sampled: str) -> str:
    """Return the joint that is built after ``before`` ("": none) where ``sampled`` was drawn."""
    if not before:
        return sampled
    joint = JOINTS[before]
    return joint.next_built or (joint.second_built if sampled == before else None) or sampled


def effective_joints(sampled_joints: str) -> str:
    """Return the joint order that is built from a sampled one, see :attr:`JointType.next_built` and
    :attr:`JointType.second_built`.

    Raises:
        KeyError: an unknown letter.
    """
    joints = ""
    for sampled in sampled_joints:
        joints += _built(joints[-1:], sampled)
    return joints


def effective_orders(n_joints: int, letters: str) -> Iterator[str]:
    """Yield every joint order of ``n_joints`` that can be built from these letters, once each."""
    orders: Iterable[str] = [""]
    for _ in range(n_joints):
        orders = [order + joint for order in orders for joint in _choices(order[-1:], letters)]
    yield from orders


def count_orders(n_joints: int, letters: str) -> int:
    """Return how many orders :func:`effective_orders` yields, without going through them."""
    return count_built([letters] * n_joints)


def count_built(places: Sequence[str]) -> int:
    """Return how many orders can be built if joint by joint one of these letters is drawn."""
    last = Counter({"": 1})  # orders by their last joint
    for letters in places:
        longer: Counter[str] = Counter()
        for before, count in last.items():
            longer.update(dict.fromkeys(_choices(before, letters), count))
        last = longer
    return last.total()


def _choices(before: str, letters: str) -> list[str]:
    return list(dict.fromkeys(_built(before, sampled) for sampled in letters))


def built_types(letters: str) -> list[JointType]:
    """Return the types of all joints that arms of these sampled letters can have."""
    found: dict[str, JointType] = {}
    rest = list(letters)
    while rest:
        joint = JOINTS[rest.pop(0)]
        if joint.letter not in found:
            found[joint.letter] = joint
            rest += [letter for letter in (joint.next_built, joint.second_built) if letter]
    return list(found.values())
