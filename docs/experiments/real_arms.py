"""Extracts the catalogue of real arms from packages of PyPI, which are needed to run this alone.

    pip download --no-deps ssik==8.2.0 example-robot-data==6.0.0     # 173 MB
    python docs/experiments/real_arms.py --packages FOLDER -o mobo_core/arms/data/arms.json

FOLDER is where they are unpacked (site-packages). From ``ssik`` come joint axes, offsets and limits, read from the text
of its modules, which are not run; from ``example-robot-data`` these and masses, by mobo's own reader of URDFs.
"""

from __future__ import annotations

import argparse
import ast
import json
import tomllib
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobo_core.arms.arm_joint import ArmJoint
from mobo_core.arms.order import order_of
from mobo_core.arms.read import read_arm
from mobo_core.arms.real import RealArm
from mobo_core.arms.rigid import Placement, rotation_rpy
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.outputs import write_whole

Array = NDArray[np.float64]
LOWERED = {"torso_lift_joint": 0.0}
# URDF files of example-robot-data that hold an arm: name, maker, file, tip, joints on the way that are held.
FILES = [
    ("Panda", "Franka Emika", "panda_description/urdf/panda.urdf", "panda_hand_tcp", {}),
    ("UR3", "Universal Robots", "ur_description/urdf/ur3_robot.urdf", "tool0", {}),
    ("UR5", "Universal Robots", "ur_description/urdf/ur5_robot.urdf", "tool0", {}),
    ("UR10", "Universal Robots", "ur_description/urdf/ur10_robot.urdf", "tool0", {}),
    ("Jaco j2s6s200", "Kinova", "kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", {}),
    ("xArm 7", "UFactory", "xarm_description/urdf/xarm7.urdf", "link_eef", {}),
    ("Z1", "Unitree", "z1_description/urdf/z1.urdf", "link06", {}),
    ("SO-100", "The Robot Studio", "so_arm_description/urdf/so100.urdf", "gripper", {}),
    ("SO-101", "The Robot Studio", "so_arm_description/urdf/so101.urdf", "gripper_frame_link", {}),
    ("TIAGo's arm", "PAL Robotics", "tiago_description/robots/tiago_no_hand.urdf", "arm_tool_link", LOWERED),
    ("TIAGo Pro's arm", "PAL Robotics", "tiago_pro_description/robots/tiago_pro.urdf", "arm_right_tool_link", LOWERED),
    ("Baxter's left arm", "Rethink Robotics", "baxter_description/urdf/baxter.urdf", "left_gripper", {}),
    ("PR2's right arm", "Willow Garage", "pr2_description/urdf/pr2.urdf", "r_gripper_tool_frame", LOWERED),
]  # fmt: skip
# Arms of ssik that the files above hold with masses too.
TWICE = {"franka_panda_ik", "ur5_ik", "xarm7_ik", "z1_ik"}
# Where a maker's name is not the first word of the arm's.
MAKERS = {
    "universal_robots": "Universal Robots", "standard_bots": "Standard Bots", "unimation": "Unimation",
    "franka": "Franka Emika",
}  # fmt: skip
# As the paper calls them.
IN_PAPER = {"viperx300s_ik": "ALOHA", "xarm6_ik": "xArm 6", "gen3_ik": "Kinova Gen3", "Panda": "Panda"}


def main() -> None:
    """Write the catalogue."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packages", required=True, help="folder with ssik and example-robot-data")
    parser.add_argument("-o", "--output", required=True)
    args = parser.parse_args()
    folder = Path(args.packages)
    versions = {found.metadata["Name"]: found.version for found in distributions(path=[str(folder)])}
    arms = from_files(folder, versions["example-robot-data"]) + from_ssik(folder, versions["ssik"])
    for arm in arms:
        arm["order"] = order(arm)
    arms.sort(key=lambda arm: (str(arm["maker"]).lower(), str(arm["name"]).lower()))
    lines = ",\n".join(json.dumps(arm, separators=(",", ":"), ensure_ascii=False) for arm in arms)
    write_whole(Path(args.output), f"[\n{lines}\n]\n")
    print(f"{len(arms)} arms, {sum('bodies' in arm for arm in arms)} with masses")


def order(arm: dict[str, Any]) -> dict[str, Any]:
    """Return the joint order of a row of the catalogue."""
    rows = arm["joints"]
    joints = tuple(ArmJoint(Placement(tuple(j[:3]), tuple(j[3:6])), tuple(j[6:9]), j[9], j[10]) for j in rows)
    tip = Placement(tuple(arm["tip"][:3]), tuple(arm["tip"][3:]))
    found = order_of(RealArm(arm["name"], arm["maker"], joints, tip, None, {}, ""))
    values = {"q": found.q, "lengths": found.lengths}
    lists = {name: [round(value, 6) + 0.0 for value in each] for name, each in values.items()}
    return {"joints": found.joints, "skew": round(found.skew, 6), "offset": round(found.offset, 6)} | lists


def from_files(folder: Path, version: str) -> list[dict[str, Any]]:
    """Return the arms of example-robot-data."""
    robots = next(folder.rglob("example-robot-data/robots"))
    found = []
    for name, maker, file, tip, held in FILES:
        read = read_arm(robots / file, tip, held=held, shapes=False)
        chain = chain_from_urdf(read.urdf, tip)
        # The chain's joint frames turn about z.
        joints = [
            joint(chain.placement_r[i], chain.placement_p[i], (0.0, 0.0, 1.0), chain.lower[i], chain.upper[i])
            for i in range(chain.n)
        ]
        bodies = [[rounded(m), *map(rounded, com)] for m, com in zip(chain.mass, chain.com, strict=True)]
        source = {"package": "example-robot-data", "version": version, "path": f"robots/{file}", "tip": tip}
        at = placed(chain.tip_r, chain.tip_p)
        arm = {"name": name, "maker": maker, "joints": joints, "tip": at, "bodies": bodies}
        found.append(arm | {"source": source, "licence": "BSD-3-Clause (package)"} | named(name))
    return found


def from_ssik(folder: Path, version: str) -> list[dict[str, Any]]:
    """Return the arms of ssik."""
    prebuilt = folder / "ssik" / "prebuilt"
    manifest = tomllib.loads((prebuilt / "MANIFEST.toml").read_text(encoding="utf-8"))["arms"]
    found = []
    for key, entry in manifest.items():
        if key in TWICE:
            continue
        path = next(path for path in (prebuilt / entry["vendor"]).glob("*_ik.py") if key.endswith(path.name[:-3]))
        tables = constants(path)
        left, right, axes, limits = (tables[f"_JOINT_{name}"] for name in ("T_LEFTS", "T_RIGHTS", "AXES", "LIMITS"))
        before, joints = np.eye(4), []
        for i in range(len(axes)):
            at = before @ left[i]
            lower, upper = limits[i] or (-np.pi, np.pi)  # none: it turns for ever
            joints.append(joint(at[:3, :3], at[:3, 3], axes[i], lower, upper))
            before = right[i]
        maker = MAKERS.get(entry["vendor"], entry["display_name"].partition(" ")[0])
        short = entry["short_name"].removeprefix(maker + " ")
        source = {"package": "ssik", "version": version, "path": f"ssik/prebuilt/{path.relative_to(prebuilt)}"}
        source |= {"from": entry["fixture_source"], "tip": entry["ee_link"]}
        arm = {"name": short, "maker": maker, "joints": joints, "tip": placed(before[:3, :3], before[:3, 3])}
        found.append(arm | {"source": source, "licence": licence(entry["fixture_source"])} | named(key))
    return found


def constants(path: Path) -> dict[str, Any]:
    """Return the tables of a module whose names begin with ``_JOINT_``."""

    class Numbers:
        array = staticmethod(lambda values, dtype: np.array(values, dtype=float))
        float64 = float

    found = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            if name.startswith("_JOINT_"):
                code = compile(ast.Expression(node.value), str(path), "eval")
                found[name] = eval(code, {"__builtins__": {}, "np": Numbers})
    return found


def joint(turned: Array, at: Array, axis: Any, lower: float, upper: float) -> list[float]:
    """Return a joint as a row: xyz, rpy, axis, limits."""
    unit = np.array(axis, dtype=float) / np.linalg.norm(axis)
    limits = (max(float(lower), -2 * np.pi), min(float(upper), 2 * np.pi))
    return [*placed(turned, at), *map(rounded, unit), *(round(limit, 6) for limit in limits)]


def placed(turned: Array, at: Array) -> list[float]:
    """Return xyz in m and rpy in rad."""
    return [*map(rounded, at), *map(rounded, rotation_rpy(np.asarray(turned)))]


def rounded(value: float) -> float:
    """Return a number to 1e-9."""
    return round(float(value), 9) + 0.0


def licence(source: str) -> str:
    """Return the licence that ssik names of the description, or that of ssik."""
    inside = source.rpartition("(")[2].rstrip(")").rpartition(", ")[2]
    known = ("Apache-2.0", "BSD-3-Clause", "MIT")
    return inside if inside in known else "BSD-3-Clause (ssik)"


def named(key: str) -> dict[str, str]:
    """Return the name that the paper has for an arm."""
    return {"paper": IN_PAPER[key]} if key in IN_PAPER else {}


if __name__ == "__main__":
    main()
