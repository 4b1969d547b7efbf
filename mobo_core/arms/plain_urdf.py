"""The plain URDF of an arm: the links on the way to its tip, joints as they were, capsules for shapes."""

from __future__ import annotations

from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

from mobo_core.arms.collision import Fitted
from mobo_core.arms.held import placed_at
from mobo_core.arms.rigid import Inertial, Placement, joined
from mobo_core.arms.robot import Joint, Robot
from mobo_core.arms.srdf import Pairs
from mobo_core.evaluation.urdf_xml import text


def plain_urdf(
    robot: Robot,
    way: list[Joint],
    at: Mapping[str, float],
    homes: Mapping[str, tuple[str, Placement]],
    fitted: Mapping[str, Fitted],
    apart: Pairs | None,
) -> str:
    """Return the links on the way, each with all that hangs on it, as URDF.

    Args:
        robot: the whole.
        way: its joints on the way to the tip.
        at: joints that are held, and where.
        homes: link -> the link of the way that it is part of, and where it stands in that.
        fitted: link -> its capsules.
        apart: pairs of links that may touch; None: nothing is said of it.
    """
    lines = [f"<robot name={quoteattr(robot.name)}>"]
    for link in (robot.root, *(joint.child for joint in way)):
        parts = [part for part in robot.links if homes[part][0] == link]
        lines.append(f"  <link name={quoteattr(link)}>")
        lines += _inertial([(robot.bodies[part], homes[part][1]) for part in parts if part in robot.bodies])
        for part in parts:
            for shape in fitted[part].shapes if part in fitted else ():
                placed = homes[part][1].then(shape.placed)
                size = f'radius="{shape.radius!r}" length="{shape.length!r}"'
                kind = f"<cylinder {size}/>" if shape.length > 0 else f'<sphere radius="{shape.radius!r}"/>'
                lines.append(
                    f"    <collision name={quoteattr(part)}>{_origin(placed)}<geometry>{kind}</geometry></collision>"
                )
        lines.append("  </link>")
    lines += [_joint_line(joint, at) for joint in way]
    if apart is not None:
        lines.append("  <self_collision>")
        lines += [
            f"    <disable_collisions link1={quoteattr(a)} link2={quoteattr(b)}/>"
            for a, b in sorted(tuple(sorted(pair)) for pair in apart if len(pair) == 2)
            if a in fitted and b in fitted
        ]
        lines.append("  </self_collision>")
    return "\n".join([*lines, "</robot>", ""])


def _origin(placed: Placement) -> str:
    return f'<origin xyz="{text(placed.xyz)}" rpy="{text(placed.rpy)}"/>'


def _inertial(parts: list[tuple[tuple[Inertial, Placement], Placement]]) -> list[str]:
    if not parts:
        return []
    (own, own_placed), home = parts[0]
    if len(parts) == 1 and home == Placement():
        body, placed = own, own_placed
    else:
        body = joined([inertial.moved(inner).moved(home) for (inertial, inner), home in parts])
        placed, body = Placement(tuple(body.com.tolist())), Inertial(body.mass, body.com * 0.0, body.moments)
    moments = " ".join(f'i{"xyz"[i]}{"xyz"[j]}="{float(body.moments[i, j])!r}"' for i in range(3) for j in range(i, 3))
    return [f'    <inertial>{_origin(placed)}<mass value="{float(body.mass)!r}"/><inertia {moments}/></inertial>']


def _joint_line(joint: Joint, at: Mapping[str, float]) -> str:
    ends = f"<parent link={quoteattr(joint.parent)}/><child link={quoteattr(joint.child)}/>"
    if not joint.moves or joint.name in at:
        return f'  <joint name={quoteattr(joint.name)} type="fixed">{_origin(placed_at(joint, at))}{ends}</joint>'
    limits = "" if joint.kind == "continuous" else f'<limit lower="{joint.lower!r}" upper="{joint.upper!r}"/>'
    slide = "" if joint.slide is None else f'<slide radius="{joint.slide!r}"/>'
    return (
        f'  <joint name={quoteattr(joint.name)} type="{joint.kind}">{_origin(joint.placed)}{ends}'
        f'<axis xyz="{text(joint.axis)}"/>{limits}{slide}</joint>'
    )
