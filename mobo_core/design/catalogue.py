"""Known arms as joint orders, to say where they stand.

The orders are those named in Kawaharazuka et al., Advanced Robotics 2025, sections 3.1 and 3.2,
written in this project's letters under the yaw rule.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class KnownArm:
    """A robot arm that exists.

    Attributes:
        name: as its maker or users call it.
        joints: its joint order, or the first four joints where the paper names no more.
    """

    name: str
    joints: str


CATALOGUE = (
    KnownArm("ALOHA", "YPPYPY"),
    KnownArm("COBOTTA", "YPPYPY"),
    KnownArm("xArm 6", "YPPYPY"),
    KnownArm("Spot's arm", "YPPYPY"),
    KnownArm("ARX", "YPPPRY"),
    KnownArm("myCobot", "YPPPYP"),
    KnownArm("Panda", "YPYPYPR"),
    KnownArm("Sawyer", "YPYPYPY"),
    KnownArm("Kinova Gen3", "YPYPYPY"),
    KnownArm("Cyton Gamma", "YPRP"),
)


def known_arms(joints: str) -> list[str]:
    """Return the names of the known arms that have this joint order."""
    return [
        arm.name
        for arm in CATALOGUE
        if arm.joints == joints or (len(arm.joints) < 6 and joints.startswith(arm.joints))
    ]
