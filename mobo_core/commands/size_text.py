"""What an arm's joints have to hold, in words."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

from mobo_core.commands.arm_values import kg_or_word
from mobo_core.errors import visible

if TYPE_CHECKING:
    from mobo_core.arms.size import Sizing

_MOST_SHOWN = 400  # voxels of the map that are printed


def print_sizing(found: Sizing, where: str, *, replaced: bool) -> None:
    """Print what each joint has to hold, and with which motor.

    Args:
        found: what was found.
        where: the arm was named.
        replaced: whether motors came in place of the arm's own.
    """
    spec = found.result.spec
    low, high = (", ".join(f"{v:.2f}" for v in end) for end in (spec.workspace_min, spec.workspace_max))
    poses = spec.n_voxels * spec.poses_per_voxel
    reached = round(found.result.reach * spec.poses_per_voxel)
    print(visible(f"{where}, payload {found.payload_kg:g} kg, {reached:,} of {poses:,} poses reached"))
    print(f"workspace {low} to {high} m, voxels of {spec.voxel_size:.3g} m")
    centres = spec.voxel_centres()
    sized = found.joints[0].motor is not None
    head = f"{'N m':20}{'median':>8}{'95 %':>8}{'peak':>8}  {'peak at x, y, z m':22}"
    print(head + (f"{'motor':22}{'holds':>8}{'payload kg':>12}" if sized else ""))
    for one in found.joints:
        at = ", ".join(f"{v:.2f}" for v in centres[one.voxel])
        line = f"{visible(one.joint):20.20}{one.median:8.2f}{one.p95:8.2f}{one.peak:8.2f}  {at:22}"
        if one.motor is not None:
            short = "" if one.peak <= one.holds * (1 + 1e-9) else "  too weak"
            line += f"{visible(one.motor.name):22.22}{one.holds:8.2f}{_text(one.payload):>12}{short}"
        print(line.rstrip())
    if not sized:
        return
    motors = [one.motor for one in found.joints if one.motor is not None]
    placed = "in place of the arm's own" if replaced else "the arm's own masses stay"
    print(f"motors {sum(motor.mass for motor in motors):.3g} kg in all, {placed}")
    doubtful = sorted({motor.name for motor in motors if motor.unverified})
    if doubtful:
        print(visible(f"note: not verified by a source: {', '.join(doubtful)}"), file=sys.stderr)
    unit = " kg" if math.isfinite(found.payload) else ""
    print(f"payload over 99 % of the reached poses: {_text(found.payload)}{unit}")


def _text(payload: float) -> str:
    kg = kg_or_word(payload)
    return kg if isinstance(kg, str) else f"{kg:.2f}"


def print_map(found: Sizing) -> None:
    """Print the payload of each voxel, layer by layer; of many voxels how to see them."""
    values, spec = found.voxel_payload.tolist(), found.result.spec
    if spec.n_voxels > _MOST_SHOWN:
        print(f"map of {spec.n_voxels:,} voxels: -o FILE.png, or --json")
        return
    nx, ny, nz = spec.shape
    centres = spec.voxel_centres()
    print("kg that all joints hold at all reached poses of a voxel; . none reached, - not even the arm itself")
    for k in range(nz):
        xs = "".join(f"{centres[(i * ny) * nz + k, 0]:7.2f}" for i in range(nx))
        print(f"z {centres[k, 2]:.2f} m, x {xs}")
        for j in reversed(range(ny)):
            cells = []
            for i in range(nx):
                kg = values[(i * ny + j) * nz + k]
                cells.append("." if math.isnan(kg) else "-" if kg < 0 else "any" if math.isinf(kg) else f"{kg:.2f}")
            print(f"   y {centres[j * nz + k, 1]:6.2f}    " + "".join(f"{cell:>7}" for cell in cells))
