"""Compare mobo's inverse kinematics with other solvers on the same poses, and check its recall (see evaluation.md).

The other solvers are not mobo's dependencies: pip install pytracik scikit-robot jax jaxlie eaik ssik urchin
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import importlib.metadata
import importlib.util
import io
import os
import platform
import statistics
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from mobo_core.bench.groups import arms_of_group
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation import EvaluationSpec, load_spec, with_ik
from mobo_core.evaluation.chain import Array, chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate, solve_poses
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.result import Engine
from mobo_core.jit.numerics import target_rotation

DESIGNS = [(arm.design.name, arm.design.lengths) for arm in arms_of_group("picked")]
COMPARED = (DESIGNS[0], DESIGNS[2], DESIGNS[9])
FREE = load_spec("mobo").model_copy(update={"self_collision": False})  # the others know nothing of collisions
ATTEMPTS = 6  # of solvers that leave restarts to the caller: as many as the paper's
TIMEOUT = 0.005  # s, TRAC-IK's default
_SLACK = 1e-9  # rad, m: a configuration reported on the edge of a limit or tolerance

# Per pose: the configurations found, none, one or all.
Found = list[Sequence[Array]]
Solver = Callable[[Array], Found]


class Arm:
    """One design in the forms that the solvers take: Pinocchio's model, a URDF file, axes and offsets."""

    def __init__(self, name: str, lengths: tuple[float, ...], folder: Path) -> None:
        self.name, self.lengths, self.folder = name, lengths, folder
        self.urdf = to_urdf(Design(name, lengths), DesignSpace(n_joints=len(name), total_length=sum(lengths)))
        self.chain = chain_from_urdf(self.urdf)
        self.model = ReferenceModel(self.chain)
        self.base, self.tip = self.chain.model.frames[1].name, self.chain.tip
        self.file = folder / f"{name}_{'_'.join(f'{length:g}' for length in lengths).replace('.', '')}.urdf"
        self.file.write_text(self.urdf, encoding="utf-8")

    def __str__(self) -> str:
        """Return joints and lengths."""
        return f"{self.name} {','.join(f'{length:g}' for length in self.lengths)}"

    def reaches(self, q: Array, pose: Array) -> bool:
        """Return whether ``q`` is within the limits and brings the tip to ``pose`` (4, 4) within 1 mm and 1 degree."""
        q = np.asarray(q, dtype=float)
        within = np.all(q >= self.chain.lower - _SLACK) and np.all(q <= self.chain.upper + _SLACK)
        tip = self.model.tip(q)
        position = np.linalg.norm(tip.translation - pose[:3, 3])
        angle = np.linalg.norm(pin.log3(tip.rotation.T @ pose[:3, :3]))
        return bool(within and position <= 1e-3 + _SLACK and angle <= np.radians(1) + _SLACK)

    def reached(self, found: Found, poses: Array) -> Array:
        """Return for each pose whether one of the configurations found reaches it."""
        return np.array([any(self.reaches(q, pose) for q in qs) for qs, pose in zip(found, poses, strict=True)])

    def axes_and_offsets(self) -> tuple[Array, Array]:
        """Return the joint axes (n, 3) at angle zero, and the way from each joint to the next one (n + 1, 3)."""
        model, n = self.chain.model, self.chain.n
        data = model.createData()
        pin.computeJointJacobians(model, data, np.zeros(n))
        pin.updateFramePlacements(model, data)
        at = [np.zeros(3), *(data.oMi[i].translation for i in range(1, n + 1))]
        at.append(data.oMf[self.chain.tip_frame].translation)
        axes = [pin.getJointJacobian(model, data, i, pin.WORLD)[3:, i - 1] for i in range(1, n + 1)]
        return np.array(axes), np.diff(np.array(at), axis=0)


def targets(per_voxel: int) -> Array:
    """Return the first targets of every voxel of the paper's workspace, shape (75 * per_voxel, 4, 4)."""
    poses = np.tile(np.eye(4), (FREE.n_voxels * per_voxel, 1, 1))
    poses[:, :3, 3] = np.repeat(FREE.voxel_centres(), per_voxel, axis=0)
    rotation = np.empty((3, 3))
    for i in range(len(poses)):
        target_rotation(FREE.seed, i // per_voxel, i % per_voxel, rotation)
        poses[i, :3, :3] = rotation
    return poses


def _one_by_one(solve: Callable[[Array], Sequence[Array]]) -> Solver:
    return lambda poses: [solve(pose) for pose in poses]


def _kernel(arm: Arm, spec: EvaluationSpec = FREE) -> Solver:
    def solve(poses: Array) -> Found:
        outcome, q, _ = solve_poses(arm.urdf, spec, poses[:, :3, 3], poses[:, :3, :3])
        return [[q[i]] if outcome[i] == 0 else [] for i in range(len(poses))]

    return solve


def _kernel_paper(arm: Arm) -> Solver:
    return _kernel(arm, with_ik(FREE, "paper"))


def _trac_ik(arm: Arm, epsilon: float) -> Solver:
    from trac_ik import TracIK

    solver = TracIK(arm.base, arm.tip, str(arm.file), timeout=TIMEOUT, epsilon=epsilon, solver_type="Speed")
    middle = (arm.chain.lower + arm.chain.upper) / 2

    def solve(pose: Array) -> Sequence[Array]:
        q = solver.ik(pose[:3, 3], pose[:3, :3], seed_jnt_values=middle)
        return [] if q is None else [q]

    return _one_by_one(solve)


def _scikit_robot(arm: Arm) -> tuple[Any, Any]:
    from skrobot.models.urdf import RobotModelFromURDF

    robot = RobotModelFromURDF(urdf_file=str(arm.file))
    return robot, getattr(robot, arm.tip)


def _scikit_robot_single(arm: Arm) -> Solver:
    from skrobot.coordinates import Coordinates

    robot, tip = _scikit_robot(arm)
    rng = np.random.default_rng(0)

    def solve(pose: Array) -> Sequence[Array]:
        target = Coordinates(pos=pose[:3, 3], rot=pose[:3, :3])
        for attempt in range(ATTEMPTS):
            start = np.zeros(arm.chain.n) if attempt == 0 else rng.uniform(arm.chain.lower, arm.chain.upper)
            robot.angle_vector(start)
            q = robot.inverse_kinematics(target, move_target=tip)
            if q is not False:
                return [np.array(q)]
        return []

    return _one_by_one(solve)


def _scikit_robot_batch(arm: Arm, backend: str) -> Solver:
    from skrobot.coordinates import Coordinates

    if backend == "jax":
        import jaxlie  # noqa: F401  # what it needs beside jax
    robot, tip = _scikit_robot(arm)

    def solve(poses: Array) -> Found:
        np.random.seed(0)
        robot.angle_vector(np.zeros(arm.chain.n))
        result = robot.batch_inverse_kinematics(
            [Coordinates(pos=pose[:3, 3], rot=pose[:3, :3]) for pose in poses], move_target=tip, backend=backend,
            attempts_per_pose=ATTEMPTS, retry_seed="random", random_initial_range=0.7, select_closest_to_initial=False,
        )  # fmt: skip
        return [[q] if ok else [] for q, ok in zip(result.solutions, result.success_flags, strict=True)]

    return solve


def _eaik(arm: Arm) -> Solver | None:
    from eaik.IK_HP import HPRobot

    if arm.chain.n != 6:
        return None
    robot = HPRobot(*arm.axes_and_offsets())
    if not robot.hasKnownDecomposition():
        return None
    return _one_by_one(lambda pose: list(robot.IK(pose).Q))


def _ssik(arm: Arm, most: int | None) -> Solver:
    from ssik.cli import main as ssik

    module_name = f"{arm.file.stem.lower()}_ik"
    file = arm.folder / f"{module_name}.py"
    if not file.exists():
        command = ["build", str(arm.file), "--base", arm.base, "--ee", arm.tip, "--out", str(file), "--no-validate",
                   "--module-name", module_name]  # fmt: skip
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            if ssik(command):
                raise RuntimeError(f"ssik does not handle {arm}")
    found = importlib.util.spec_from_file_location(module_name, file)
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules[module_name] = module
    found.loader.exec_module(module)
    return _one_by_one(lambda pose: [solution.q for solution in module.solve(pose, max_solutions=most)])


SOLVERS: tuple[tuple[str, Callable[[Arm], Solver | None]], ...] = (
    ("mobo kernel, preset `mobo`", _kernel),
    ("mobo kernel, `ik_mode: paper`", _kernel_paper),
    (f"TRAC-IK, Speed, {1e3 * TIMEOUT:g} ms, epsilon 1e-5", lambda arm: _trac_ik(arm, 1e-5)),
    (f"TRAC-IK, Speed, {1e3 * TIMEOUT:g} ms, epsilon 5e-4", lambda arm: _trac_ik(arm, 5e-4)),
    (f"scikit-robot, {ATTEMPTS} attempts one by one", _scikit_robot_single),
    (f"scikit-robot batch, {ATTEMPTS} attempts, numpy", lambda arm: _scikit_robot_batch(arm, "numpy")),
    (f"scikit-robot batch, {ATTEMPTS} attempts, jax", lambda arm: _scikit_robot_batch(arm, "jax")),
    ("EAIK (exact, all solutions)", _eaik),
    ("ssik artifact (exact, first solution)", lambda arm: _ssik(arm, 1)),
)


def _timed(solve: Solver, poses: Array) -> tuple[float, float, Found]:
    """Return microseconds a pose (median of up to 5 runs within some 3 s, after one to warm up), seconds of that
    first run, and its configurations.
    """
    began = time.perf_counter()
    found = solve(poses)
    first = time.perf_counter() - began
    runs: list[float] = []
    began = time.perf_counter()
    while not runs or (len(runs) < 5 and time.perf_counter() - began < 3):
        start = time.perf_counter()
        solve(poses)
        runs.append(1e6 * (time.perf_counter() - start) / len(poses))
    return statistics.median(runs), first, found


def _of_spec(arm: Arm, per_voxel: int) -> Iterator[tuple[str, float, Array]]:
    """Yield what evaluates a spec rather than poses: name, microseconds a pose, reached of the first targets."""
    few = with_ik(FREE, "paper").model_copy(update={"poses_per_voxel": per_voxel})
    questions: tuple[tuple[str, EvaluationSpec, Engine, int], ...] = (
        (f"mobo kernel, preset `mobo`, whole candidate ({FREE.n_voxels * FREE.poses_per_voxel:,} poses)", FREE,
         "kernel", 5),
        ("mobo reference engine, `paper` (Pinocchio in Python)", few, "reference", 1),
    )  # fmt: skip
    for name, spec, engine, runs in questions:
        results = [evaluate(arm.urdf, spec, engine=engine, configurations=True) for _ in range(runs)]
        us = statistics.median(1e6 * r.seconds / (spec.n_voxels * spec.poses_per_voxel) for r in results)
        found: Found = [[] for _ in range(spec.n_voxels * per_voxel)]
        configurations = results[0].configurations
        assert configurations is not None
        for voxel, pose, q in zip(configurations.voxel, configurations.pose, configurations.q, strict=True):
            if pose < per_voxel:
                found[voxel * per_voxel + pose] = [q]
        yield name, us, arm.reached(found, targets(per_voxel))


def compare(arms: list[Arm], per_voxel: int, missing: set[str]) -> None:
    """Print the table of speed and success on the first ``per_voxel`` targets of each voxel."""
    poses = targets(per_voxel)
    for module in ("trac_ik", "skrobot.models.urdf", "jaxlie", "eaik.IK_HP", "ssik.cli"):
        with contextlib.suppress(ModuleNotFoundError):
            importlib.import_module(module)
    print("| solver | design | set-up ms | µs a pose | µs a reachable pose | reached | recall |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |")
    for arm in arms:
        rows: list[tuple[str, str, float, Array]] = [(n, "–", us, there) for n, us, there in _of_spec(arm, per_voxel)]
        solvers: dict[str, Solver] = {}
        for name, make in SOLVERS:
            began = time.perf_counter()
            solver = _made(name, make, arm, missing)
            if solver:
                making = time.perf_counter() - began
                solvers[name] = solver
                us, first, found = _timed(solver, poses)
                set_up = 1e3 * max(0.0, making + first - 1e-6 * us * len(poses))
                rows.append((name, f"{set_up:.0f}", us, arm.reached(found, poses)))
        union = np.any([row[3] for row in rows], axis=0)
        for name, set_up_ms, us, reached in rows:
            there = f"{_timed(solvers[name], poses[union])[0]:.1f}" if name in solvers else "–"
            print(
                f"| {name} | {arm.name} | {set_up_ms} | {us:.1f} | {there} | {reached.sum()} / {len(poses)} | "
                f"{reached.sum() / max(1, union.sum()):.1%} |",
                flush=True,
            )


def recall(arms: list[Arm], fk_poses: int, per_voxel: int, missing: set[str]) -> None:
    """Print the share of reachable poses that preset mobo reaches: FK-made ones, and those solved exactly; and its
    mean torque against that of blind restarts.
    """
    print("| design | lengths (m) | FK-made | exact solver | solved exactly | recall | torque |")
    print("| --- | --- | ---: | --- | ---: | ---: | ---: |")
    for arm in arms:
        poses = _fk_made(arm, fk_poses)
        outcome, _, _ = solve_poses(arm.urdf, load_spec("mobo"), poses[:, :3, 3], poses[:, :3, :3])
        made = np.count_nonzero(outcome == 0)
        asked = targets(per_voxel if arm.chain.n == 6 else max(1, per_voxel // 6))
        solved, names = np.zeros(len(asked), bool), []
        for name, make in (("EAIK", _eaik), ("ssik", lambda arm: _ssik(arm, None))):
            solver = _made(name, make, arm, missing)
            if solver:
                solved |= arm.reached(solver(asked), asked)
                names.append(name)
        mine = arm.reached(_kernel(arm)(asked[solved]), asked[solved]) if solved.any() else np.zeros(0, bool)
        exact = f"{mine.mean():.2%}" if len(mine) else "–"
        lengths = ", ".join(f"{length:g}" for length in arm.lengths)
        print(
            f"| {arm.name} | {lengths} | {made} / {len(poses)} | {' + '.join(names) or '–'} | "
            f"{mine.sum()} / {solved.sum()} of {len(asked)} | {exact} | {_torque_ratio(arm) - 1:+.1%} |",
            flush=True,
        )


def _torque_ratio(arm: Arm) -> float:
    """Return the mean torque over the poses that preset mobo and 21 blind attempts both reach, one to the other."""
    mobo = load_spec("mobo")
    blind = with_ik(mobo, "paper").model_copy(update={"restarts": 20})
    torques = []
    for spec in (mobo, blind):
        configurations = evaluate(arm.urdf, spec, configurations=True).configurations
        assert configurations is not None
        targets_reached = zip(configurations.voxel.tolist(), configurations.pose.tolist(), strict=True)
        torques.append(dict(zip(targets_reached, configurations.torque, strict=True)))
    both = torques[0].keys() & torques[1].keys()
    return float(np.mean([torques[0][at] for at in both]) / np.mean([torques[1][at] for at in both]))


def _fk_made(arm: Arm, count: int) -> Array:
    """Return tip poses of ``count`` configurations uniform within the limits and free of self-collision."""
    rng = np.random.default_rng(0)
    poses: list[Array] = []
    while len(poses) < count:
        q = rng.uniform(arm.chain.lower, arm.chain.upper)
        if arm.model.clearance(q) > 0:
            poses.append(arm.model.tip(q).homogeneous)
    return np.array(poses)


def _made(name: str, make: Callable[[Arm], Solver | None], arm: Arm, missing: set[str]) -> Solver | None:
    """Return a solver for an arm, or None, noting why, if its package is missing or does not handle the arm."""
    try:
        solver = make(arm)
    except ModuleNotFoundError as error:
        missing.add(f"{name}: left out, no package {error.name}")
        return None
    if solver is None:
        missing.add(f"{name}: does not handle {arm}")
    return solver


def _machine() -> str:
    packages = ("pin", "numba", "pytracik", "scikit-robot", "jax", "eaik", "ssik")
    versions = []
    for package in packages:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            versions.append(f"{package} {importlib.metadata.version(package)}")
    return f"Python {platform.python_version()}, {', '.join(versions)}; {os.cpu_count()} cores"


def main() -> None:
    """Read the arguments and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__,
        epilog="examples:\n  python docs/experiments/compare_solvers.py\n"
        "  python docs/experiments/compare_solvers.py --design YPPYPY:0.05,0.25,0.2,0.05,0,0.05 --poses 2\n"
        "  python docs/experiments/compare_solvers.py --recall",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--design", action="append", metavar="NAME:l1,l2,…",
                        help="an arm; may be repeated [3 of `mobo bench`'s group picked; --recall: all]")  # fmt: skip
    parser.add_argument("--poses", type=int, metavar="N",
                        help="first poses of each voxel [4; with --recall 30, for 7 joints a sixth]")  # fmt: skip
    parser.add_argument("--recall", action="store_true", help="recall of reachable poses instead of the comparison")
    parser.add_argument("--fk-poses", type=int, default=2000, metavar="N", help="FK-made poses an arm [2000]")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    designs = list(DESIGNS if args.recall else COMPARED)
    if args.design:
        designs = [
            (name, tuple(float(word) for word in lengths.split(",")))
            for name, _, lengths in (text.partition(":") for text in args.design)
        ]
    missing: set[str] = set()
    before = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        arms = [Arm(name, lengths, Path(folder)) for name, lengths in designs]
        if args.recall:
            recall(arms, args.fk_poses, args.poses or 30, missing)
        else:
            compare(arms, args.poses or 4, missing)
    print()
    for line in sorted(missing):
        print(line)
    print(f"{_machine()}; load {before:.1f} before, {os.getloadavg()[0]:.1f} after")


if __name__ == "__main__":
    main()
