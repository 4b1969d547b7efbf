"""Known arms as joint orders, to say where they stand.

The orders are those named in Kawaharazuka et al., Advanced Robotics 2025, sections 3.1 and 3.2,
written in this project's letters as built.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class KnownArm:
    """A robot arm that exists.

    Attributes:
        name: as its maker or users call it.
        joints: its joint order, or the first joints where the paper names no more.
        n_joints: how many it has in all.
    """

    name: str
    joints: str
    n_joints: int


CATALOGUE = (
    KnownArm("ALOHA", "YPPYPY", 6),
    KnownArm("COBOTTA", "YPPYPY", 6),
    KnownArm("xArm 6", "YPPYPY", 6),
    KnownArm("Spot's arm", "YPPYPY", 6),
    KnownArm("ARX", "YPPPRY", 6),
    KnownArm("myCobot", "YPPPYP", 6),
    KnownArm("Panda", "YPYPYPR", 7),
    KnownArm("Sawyer", "YPYPYPY", 7),
    KnownArm("Kinova Gen3", "YPYPYPY", 7),
    KnownArm("Cyton Gamma", "YPRP", 7),
)


def known_arms(joints: str) -> list[str]:
    """Return the names of the known arms that have this joint order."""
    return [arm.name for arm in CATALOGUE if arm.n_joints == len(joints) and joints.startswith(arm.joints)]
