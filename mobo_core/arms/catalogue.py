"""Arms that can be bought or built, with axes, offsets and limits, and where those numbers are from.

The numbers were taken from packages by ``docs/experiments/real_arms.py``. What no source says (masses of most arms) is
estimated and marked so.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

from mobo_core.arms.arm_joint import ArmJoint
from mobo_core.arms.real import Order, RealArm
from mobo_core.arms.rigid import Placement
from mobo_core.errors import InputError

# Named in Kawaharazuka et al., Advanced Robotics 2025, sections 3.1 and 3.2, by joint orders: the orders as built,
# or the first joints where the paper names no more, and the number of joints.
NAMED = (
    ("ALOHA", "YPPYPY", 6), ("COBOTTA", "YPPYPY", 6), ("xArm 6", "YPPYPY", 6), ("Spot's arm", "YPPYPY", 6),
    ("ARX", "YPPPRY", 6), ("myCobot", "YPPPYP", 6), ("Panda", "YPYPYPR", 7), ("Sawyer", "YPYPYPY", 7),
    ("Kinova Gen3", "YPYPYPY", 7), ("Cyton Gamma", "YPRP", 7), ("Unimate", "YPSPY", 5),
)  # fmt: skip
# Of the arms that the paper names, those that neither source holds.
MISSING = ("COBOTTA", "Spot's arm", "ARX", "myCobot", "Sawyer", "Cyton Gamma", "Unimate")
_MOST_NAMES = 4


@cache
def catalogue() -> tuple[RealArm, ...]:
    """Return all arms, by maker and name."""
    rows = json.loads((files(__package__) / "data" / "arms.json").read_text(encoding="utf-8"))
    return tuple(
        RealArm(
            name=row["name"], maker=row["maker"],
            joints=tuple(
                ArmJoint(Placement(tuple(j[:3]), tuple(j[3:6])), tuple(j[6:9]), j[9], j[10]) for j in row["joints"]
            ),
            tip=Placement(tuple(row["tip"][:3]), tuple(row["tip"][3:])),
            bodies=tuple((b[0], tuple(b[1:])) for b in row["bodies"]) if "bodies" in row else None,
            order=_order(row["order"]),
            source=row["source"], licence=row["licence"], paper=row.get("paper", ""),
        )
        for row in rows
    )  # fmt: skip


def _order(row: dict[str, Any]) -> Order:
    return Order(row["joints"], tuple(row["q"]), row["skew"], row["offset"], tuple(row["lengths"]))


def find_arm(name: str) -> RealArm:
    """Return the arm of this name, capitals, spaces and dashes aside.

    Raises:
        InputError: there is none.
    """
    wanted = _plain(name)
    for arm in catalogue():
        if wanted in (_plain(arm.name), _plain(arm.maker + arm.name), _plain(arm.paper) or None):
            return arm
    near = [arm.name for arm in catalogue() if wanted and wanted in _plain(arm.maker + arm.name)]
    expected = f"one of {', '.join(near[:8])}" if near else "a name that `mobo arms list` prints"
    raise InputError(f"no arm {name[:60]!r}", where="arms", expected=expected)


def _plain(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())


@cache
def known_arms(joints: str) -> tuple[str, ...]:
    """Return the names of real arms that have this joint order: those that the paper names, then some of the others."""
    named = [name for name, order, n in NAMED if n == len(joints) and joints.startswith(order)]
    having = [arm for arm in catalogue() if arm.order is not None and arm.order.joints == joints]
    others = [arm.name for arm in having if not arm.paper]
    names = named + others
    if len(names) > _MOST_NAMES:
        kept = max(len(named), _MOST_NAMES - 1)
        names = [*names[:kept], f"{len(names) - kept} more"] if len(names) > kept else names
    return tuple(names)
