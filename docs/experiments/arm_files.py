"""Holds what mobo makes of real arms' files against Pinocchio and Coal on the files themselves.

    python docs/experiments/arm_files.py --packages FOLDER

FOLDER is where PyPI's ``example-robot-data`` is unpacked. A row an arm: largest differences of tip (m) and gravity
torque (N m) from Pinocchio's model of the whole file; capsules, and how much larger than the shapes; of random
postures, how many capsules call free and how many of those Coal sees colliding by the original shapes (none may be),
how many they call in collision and Coal free; poses on which kernel and reference engine differ; CPU time of a
pose, over that of an arm of a design space with as many joints.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from mobo_core.arms.meshes import model_of, triangles_of
from mobo_core.arms.packages import Packages
from mobo_core.arms.read import ReadArm, read_arm
from mobo_core.arms.robot import read_robot
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation import EvaluationSpec, load_spec
from mobo_core.evaluation.chain import Chain, chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.urdf import check_urdf
from mobo_core.evaluation.urdf_xml import parse

ARMS = [
    ("panda_description/urdf/panda.urdf", "", {}),
    ("ur_description/urdf/ur3_gripper.urdf", "", {}),
    ("ur_description/urdf/ur5_robot.urdf", "", {}),
    ("ur_description/urdf/ur10_robot.urdf", "", {}),
    ("kinova_description/robots/kinova.urdf", "", {}),
    ("xarm_description/urdf/xarm7.urdf", "", {}),
    ("z1_description/urdf/z1.urdf", "link06", {"jointGripper": -0.3}),
    ("so_arm_description/urdf/so100.urdf", "", {}),
    ("so_arm_description/urdf/so101.urdf", "", {}),
    ("tiago_description/robots/tiago_no_hand.urdf", "arm_tool_link", {"torso_lift_joint": 0.1}),
]  # fmt: skip
# Arms of a design space, by their joints, to compare times with.
OURS = {
    5: ("YPPPY", (0.05, 0.2, 0.2, 0.1, 0.05)), 6: ("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)),
    7: ("YPYPYPR", (0.1, 0.1, 0.15, 0.1, 0.1, 0.0, 0.05)),
}  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packages", required=True, help="folder with example-robot-data")
    parser.add_argument("--postures", type=int, default=200)
    args = parser.parse_args()
    robots = next(Path(args.packages).rglob("example-robot-data/robots"))
    head = "arm", "joints", "tip", "torque", "capsules", "volume", "gap", "free, colliding", "in collision, free"
    print(f"| {' | '.join((*head, 'differ', 'cost'))} |\n{'| --- ' * 11}|")
    for file, tip, held in ARMS:
        path = robots / file
        arm = read_arm(path, tip, held=held)
        chain = chain_from_urdf(arm.urdf, arm.tip)
        position, torque = against_pinocchio(path, arm, chain)
        free, wrong, hit, false = against_coal(path, arm, chain, args.postures)
        found = arm.capsules
        print(
            f"| {path.stem} to {arm.tip} | {chain.n} | {position:.0e} | {torque:.0e} | {found.count} | "
            f"{found.volume_ratio or 0:.2f} | {1e3 * found.largest_gap:.0f} mm | {free}, {wrong} | {hit}, {false} | "
            f"{engines(arm)} | {cost(arm, chain.n):.2f} |",
            flush=True,
        )


def whole_configuration(model: Any, values: dict[str, float]) -> Any:
    """Return the configuration of a whole robot with each joint where ``values`` says."""
    q = pin.neutral(model)
    for joint, name in zip(model.joints[1:], list(model.names)[1:], strict=True):
        value = values[name]
        if joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            q[joint.idx_q] = value
    return q


def against_pinocchio(path: Path, arm: ReadArm, chain: Chain) -> tuple[float, float]:
    """Return the largest differences of tip and torque at 20 random configurations."""
    model, ours = pin.buildModelFromUrdf(str(path)), ReferenceModel(chain)
    data, rng = model.createData(), np.random.default_rng(0)
    columns = [model.joints[model.getJointId(name)].idx_v for name in chain.joint_names]
    frame = model.getFrameId(arm.tip, pin.BODY)
    position = torque = 0.0
    for _ in range(20):
        q = rng.uniform(chain.lower, chain.upper)
        whole = whole_configuration(model, {**arm.held, **dict(zip(chain.joint_names, q, strict=True))})
        pin.framesForwardKinematics(model, data, whole)
        position = max(position, np.abs(ours.tip(q).homogeneous - data.oMf[frame].homogeneous).max())
        gravity = pin.computeGeneralizedGravity(model, data, whole)[columns]
        torque = max(torque, np.abs(ours.torque(q) - gravity).max())
    return position, torque


def against_coal(path: Path, arm: ReadArm, chain: Chain, postures: int) -> tuple[int, int, int, int]:
    """Return postures that capsules call free, those of them in which Coal sees a collision; in collision, free."""
    model, rng = pin.buildModelFromUrdf(str(path)), np.random.default_rng(1)
    data, ours = model.createData(), ReferenceModel(chain)
    names = [shape.name for shape in check_urdf(arm.urdf).shapes]
    counted: dict[frozenset[str], list[int]] = {}
    for i, j in chain.pairs.tolist():
        counted.setdefault(frozenset((names[i], names[j])), []).append(1)
    # Pairs of links all of whose capsules are looked at: what touches at rest is left out.
    pairs = [pair for pair, seen in counted.items() if len(seen) == np.prod([names.count(link) for link in pair])]
    solids = shapes_of(path, {link for pair in pairs for link in pair})
    kept = [k for k, (i, j) in enumerate(chain.pairs.tolist()) if frozenset((names[i], names[j])) in pairs]
    object.__setattr__(chain, "pairs", chain.pairs[kept])
    ours = ReferenceModel(chain)
    frames = {link: model.getFrameId(link, pin.BODY) for link in solids}
    free = wrong = hit = false = 0
    for _ in range(postures):
        q = rng.uniform(chain.lower, chain.upper)
        apart = ours.clearance(q) > 0
        pin.framesForwardKinematics(
            model, data, whole_configuration(model, {**arm.held, **dict(zip(chain.joint_names, q, strict=True))})
        )
        touching = any(collide(solids, data, frames, *pair) for pair in pairs)
        free, wrong = free + apart, wrong + (apart and touching)
        hit, false = hit + (not apart), false + (not apart and not touching)
    return free, wrong, hit, false


def shapes_of(path: Path, links: set[str]) -> dict[str, list[Any]]:
    """Return the collision shapes of links as they are in the file: Coal's shape, and where."""
    packages = Packages(path)
    found: dict[str, list[Any]] = {}
    for solid in read_robot(parse(path.read_bytes())).solids:
        if solid.link not in links:
            continue
        if solid.kind in ("box", "mesh"):
            shape, placed = model_of(triangles_of(solid, packages)), pin.SE3.Identity()
        else:
            radius, length = solid.size
            shape = coal.Sphere(radius) if solid.kind == "sphere" else coal.Cylinder(radius, length)
            placed = pin.SE3(solid.placed.matrix, np.array(solid.placed.xyz))
        found.setdefault(solid.link, []).append((shape, placed))
    return found


def collide(solids: dict[str, list[Any]], data: Any, frames: dict[str, int], a: str, b: str) -> bool:
    """Return whether the original shapes of two links touch."""
    for shape_a, in_a in solids[a]:
        for shape_b, in_b in solids[b]:
            at = [data.oMf[frames[link]] * inside for link, inside in ((a, in_a), (b, in_b))]
            places = [coal.Transform3s(one.rotation, one.translation) for one in at]
            result = coal.CollisionResult()
            if coal.collide(shape_a, places[0], shape_b, places[1], coal.CollisionRequest(), result):
                return True
    return False


def engines(arm: ReadArm) -> str:
    """Return on how many poses kernel and reference engine differ."""
    spec = EvaluationSpec.of({"voxel_size": 0.5, "workspace_min": [-0.5, -0.5, 0.0], "poses_per_voxel": 12})
    one, other = (evaluate(arm.urdf, spec, tip=arm.tip, engine=engine) for engine in ("kernel", "reference"))
    fields = ("voxel_reach", "not_converged", "in_collision")
    off = [np.abs(getattr(one, name) - getattr(other, name)) for name in fields]
    off[0] = off[0] * spec.poses_per_voxel
    return f"{int(round(max(each.sum() for each in off)))} of {spec.n_voxels * spec.poses_per_voxel}"


def cost(arm: ReadArm, n: int) -> float:
    """Return the CPU time of a pose over that of arms of a design space."""
    spec = load_spec("mobo")
    ours = to_urdf(Design(*OURS[n]), DesignSpace(n_joints=n))
    times: dict[str, list[float]] = {"real": [], "ours": []}
    for _ in range(3):
        for name, urdf, tip in (("real", arm.urdf, arm.tip), ("ours", ours, "")):
            began = time.process_time()
            evaluate(urdf, spec, tip=tip)
            times[name].append(time.process_time() - began)
    return float(np.median(times["real"]) / np.median(times["ours"]))


if __name__ == "__main__":
    main()
