"""Where an arm stands, and what changes of it would do, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mobo_core.errors import visible

if TYPE_CHECKING:
    from mobo_core.arms.place import Distance, Place, Rival
    from mobo_core.arms.real import RealArm
    from mobo_core.arms.resample import Interval
    from mobo_core.arms.what_if import WhatIf
    from mobo_core.atlas.atlas import Atlas

_ASKEW = math.radians(30)  # from here on an order says little of an arm


def percent(share: Interval) -> str:
    """Return a share as ``12 % ± 2``; what may be nothing is said to be."""
    value, half = 100 * share.value, 100 * share.half
    digits = 0 if half >= 0.95 else 1
    return f"{abs(value):.{digits}f} % ± {half:.{digits}f}" + ("" if share.sure else " (within chance)")


def _in_words(rival: Rival, wanted: str, atlas: Atlas) -> str:
    """Return what a rival does better, then what else differs, then which arm it is."""
    from mobo_core.report.lengths import lengths_text

    reach = f"{percent(rival.reach)} {'more' if rival.reach.value >= 0 else 'less'} reach"
    torque = f"{percent(rival.torque)} {'more' if rival.torque.value > 0 else 'less'} torque"
    first, second = (reach, torque) if wanted == "reach" else (torque, reach)
    which = f"{rival.design.joints} {lengths_text(rival.design.lengths).replace(',', '/')}"
    how = ""
    if rival.moves:
        moves = [f"{1e3 * by:.0f} mm from link {source} to link {sink}" for by, source, sink in rival.moves]
        how = f", its lengths with {', '.join(moves)}"
    return f"{first}, and {second}, with {which}{how} (trial {int(atlas.trial[rival.row])})"


def print_place(found: Place, atlas: Atlas, name: str, few: str) -> None:
    """Print where an arm stands.

    Args:
        found: where.
        atlas: in which.
        name: of the atlas.
        few: how partial it is; "" if it is not.
    """
    from mobo_core.report.lengths import lengths_text

    arm, voxels = found.arm, atlas.about.n_voxels
    assert arm.order is not None
    total = sum(atlas.lengths[0])
    print(
        f"{visible(arm.name)}, {arm.order.joints}, scaled: straightened {total:g} m high above its first joint, with "
        "the masses\nand radius of the atlas's arms, its own offsets and limits"
    )
    print(f"  reach {found.scaled.reach:.2f} of {voxels}, torque {found.scaled.torque:.1f} N m")
    if found.twin is not None:
        lengths = lengths_text(arm.order.twin(total)).replace(",", "/")
        print(
            f"its twin, order and lengths alone ({lengths}, limits of the space)\n"
            f"  reach {found.twin.reach:.2f}, torque {found.twin.torque:.1f} N m"
        )
    print(visible(f"front of all, in {name}: {atlas.about.trials:,} trials, {atlas.about.orders} orders"))
    if few:
        print(f"  {few}")
    _print_distance(found.of_all, atlas, "arm")
    if found.of_order is None:
        n = atlas.lengths.shape[1]
        slide = " that turn" if "S" in arm.order.joints and arm.n == n else ""
        print(f"its own order {arm.order.joints}: none in the atlas, whose arms have {n} joints{slide}")
        return
    print(f"front of its own order {arm.order.joints}: {found.trials_of_order:,} trials")
    _print_distance(found.of_order, atlas, f"{arm.order.joints} arm")


def _print_distance(distance: Distance, atlas: Atlas, what: str) -> None:
    if distance.better:
        print(f"  better in both: {distance.better} of its arms")
    if distance.more_reach is None:
        print(f"  no {what} of it reaches more for the same torque")
    else:
        print(f"  for the same torque, {_in_words(distance.more_reach, 'reach', atlas)}")
    if distance.less_torque is None:
        print(f"  no {what} of it takes less torque for the same reach")
    elif distance.more_reach is None or distance.less_torque.row != distance.more_reach.row:
        print(f"  for the same reach, {_in_words(distance.less_torque, 'torque', atlas)}")


def _signed(one: Interval, digits: int) -> str:
    if max(abs(one.value), one.half) < 0.5 * 10**-digits:
        return "0"
    return f"{one.value:+.{digits}f} ±{one.half:.{digits}f}"


def print_changes(arm: RealArm, changes: Sequence[WhatIf], by: str, *, own: bool, top: int) -> None:
    """Print the what-if table.

    Args:
        arm: that was changed.
        changes: what helps most first.
        by: what helps.
        own: whether it is at its own size, or scaled.
        top: how many changes to print.
    """
    sense = {
        "both": "% more reach less % more torque", "reach": "reach", "torque": "torque", "peak": "largest peak",
    }  # fmt: skip
    what = "with its own size and masses" if own else "scaled"
    print(f"what if, {what}; by {sense[by]}; ± of 95 %")
    sliding = [str(i) for i, joint in enumerate(arm.joints, start=1) if joint.slides]
    if sliding:
        print(f"joints that slide ({', '.join(sliding)}): N m of their force at a pinion, docs/settings.md")
    joints = "".join(f"{f'peak {i + 1}':>12}" for i in range(arm.n))
    print(f"{'change':34}{'reach':>14}{'torque N m':>16}{joints}")
    for change in changes[:top]:
        peaks = "".join(f"{_signed(peak, 2):>12}" for peak in change.peaks)
        print(f"{change.change:34}{_signed(change.reach, 2):>14}{_signed(change.torque, 1):>16}{peaks}")
    if len(changes) > top:
        print(f"{len(changes) - top} more with --top {len(changes)}, or --json")
