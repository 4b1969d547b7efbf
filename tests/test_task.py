"""What a spec may ask beyond the paper's question: a tool, part of the orientation, obstacles, given poses."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from arms import LENGTHS, KernelView, WholeRobot, arm, random_arm, small_spec
from hypothesis import given
from hypothesis import strategies as st

from mobo_core.commands.cli import main
from mobo_core.design import DesignSpace
from mobo_core.evaluation import EvaluationSpec, load_spec
from mobo_core.evaluation.chain import asked_chain
from mobo_core.evaluation.evaluate import evaluate, solve_poses
from mobo_core.evaluation.kernel.obstacles import box_distance_squared, touches_anything
from mobo_core.evaluation.kernel.orientation import aim
from mobo_core.evaluation.matrices import rpy_matrix
from mobo_core.evaluation.obstacles import flat_arm, obstacles_of
from mobo_core.evaluation.pose_file import read_poses
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.spec import with_poses
from mobo_core.evaluation.spec_message import spec_from_message, spec_to_message
from mobo_core.evaluation.wording import further_asked
from mobo_core.messages import decode, encode
from mobo_core.messages.types import SpecMessage
from mobo_core.search.mirror import exact_twins

TOOL: dict[str, Any] = {
    "tool_xyz": (0.03, -0.02, 0.11), "tool_rpy": (0.4, -0.7, 1.9), "payload_kg": 1.3, "payload_com": (0.01, 0.04, -0.05)
}  # fmt: skip


def with_tool(urdf: str, flange: str, values: dict[str, Any]) -> str:
    """Return a URDF with a link ``hook`` on its flange and the payload as a body of that, as spec fields say."""
    xyz, rpy, com = (" ".join(map(repr, values[name])) for name in ("tool_xyz", "tool_rpy", "payload_com"))
    return urdf.replace("</robot>", (
        f'<link name="hook"/><joint name="hold" type="fixed"><parent link="{flange}"/>'
        f'<child link="hook"/><origin xyz="{xyz}" rpy="{rpy}"/></joint>'
        f'<link name="load"><inertial><origin xyz="{com}"/>'
        f'<mass value="{values["payload_kg"]!r}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        '</inertial></link><joint name="grip" type="fixed"><parent link="hook"/><child link="load"/></joint></robot>'
    ))  # fmt: skip


@given(st.tuples(*[st.floats(-6.0, 6.0)] * 3))
def test_rotations_by_roll_pitch_yaw_are_pinocchios(rpy: tuple[float, float, float]) -> None:
    """Roll, pitch and yaw turn as Pinocchio has them."""
    assert np.abs(np.array(rpy_matrix(rpy)) - pin.rpy.rpyToMatrix(*rpy)).max() < 1e-15


@pytest.mark.parametrize("seed", range(6))
def test_tool_and_payload_are_pinocchios(seed: int) -> None:
    """Pose of the tool and torque, by kernel and reference, are Pinocchio's of an arm with tool and load as links."""
    rng, urdf = np.random.default_rng(seed), random_arm(seed)
    values: dict[str, Any] = {name: tuple(rng.uniform(-3, 3, 3).tolist()) for name in TOOL} | {"payload_kg": 0.5 + seed}
    chain = asked_chain(urdf, "flange", EvaluationSpec.of(values))
    whole, reference = WholeRobot(with_tool(urdf, "flange", values)), ReferenceModel(chain)
    q = rng.uniform(chain.lower, chain.upper)
    expected, view = whole.tip(chain.joint_names, q, "hook"), KernelView(chain, q)
    assert np.abs(view.tip[:3] - expected.rotation).max() < 1e-12
    assert np.abs(view.tip[3] - expected.translation).max() < 1e-12
    assert np.abs(reference.tip(q).homogeneous - expected.homogeneous).max() < 1e-12
    torque = whole.torque(chain.joint_names, q)
    assert np.abs(view.torque() - torque).max() < 1e-10
    assert np.abs(reference.torque(q) - torque).max() < 1e-10


def test_an_arm_with_a_tool_is_the_arm_that_has_it_as_a_link() -> None:
    """Both evaluate alike; the audit agrees, and so does the reference engine."""
    urdf = arm("PRRYPY")
    tip = asked_chain(urdf, "", EvaluationSpec()).tip
    asked = evaluate(urdf, small_spec(**TOOL), audit_poses=20)
    built = evaluate(with_tool(urdf, tip, TOOL), small_spec(), tip="hook")
    assert (asked.audit_fault, asked.audit_poses) == ("", 20)
    assert asked.audit_max_error < 1e-9
    assert asked.reach == pytest.approx(built.reach, abs=0.11)
    assert asked.torque == pytest.approx(built.torque, rel=0.02)
    assert abs(asked.reach - evaluate(urdf, small_spec()).reach) > 0.5
    few = small_spec(**TOOL, poses_per_voxel=1, restarts=1)
    fast, reference = (evaluate(urdf, few, engine=engine) for engine in ("kernel", "reference"))
    assert (fast.reach, fast.attempts) == (reference.reach, reference.attempts)
    assert fast.torque == pytest.approx(reference.torque, abs=1e-6)


def test_what_older_versions_could_ask_is_written_as_they_wrote_it() -> None:
    """Later fields are written where they ask for something, and come back; a message holds them in any case."""
    assert "tool_xyz" not in json.loads(EvaluationSpec(seed=3).to_json())
    spec = EvaluationSpec.of(TOOL | ROOM | {"target_poses": [[0.1, 0.2, 0.3, 1.0, -0.5, 0.0]], "poses_per_voxel": 1})
    assert EvaluationSpec.of(json.loads(spec.to_json())) == spec
    assert spec_from_message(decode(SpecMessage, encode(spec_to_message(spec)))) == spec


def test_words_on_what_is_asked() -> None:
    """Tool and payload are told in words, and nothing where there is neither."""
    assert further_asked(EvaluationSpec()) == []
    assert further_asked(EvaluationSpec.of(TOOL | ROOM | {"orientation": "none"})) == [
        "position alone, in any orientation",
        "payload 1.3 kg with its centre at 0.01 0.04 -0.05 m in the tool's frame",
        "tool at 0.03 -0.02 0.11 m from the tip, turned by 22.92 -40.11 108.9°",
        "floor at 0 m",
        "2 boxes in the way",
    ]


def test_a_lateral_tool_has_no_mirror_twin() -> None:
    """Arms with a tool beside their axis are not each other's reflection; with one along it they are."""
    orders, space = ("PRRYPY", "RPPYRP", "RPPYPY", "RPRPRP", "PRPRPR"), DesignSpace()
    twins = exact_twins(orders, space, EvaluationSpec())
    assert twins
    assert exact_twins(orders, space, EvaluationSpec(tool_xyz=(0.0, 0.0, 0.1))) == twins
    assert exact_twins(orders, space, EvaluationSpec(tool_xyz=(0.1, 0.0, 0.0))) == {}
    assert exact_twins(orders, space, EvaluationSpec(tool_rpy=(0.1, 0.0, 0.0))) == {}


@pytest.mark.parametrize("orientation", ["free_roll", "none"])
def test_free_orientations_are_the_references(orientation: str) -> None:
    """Kernel and reference engine reach the same poses in as many attempts where orientation counts in part."""
    spec = small_spec(orientation=orientation, poses_per_voxel=1, restarts=1, position_tolerance=0.01)
    fast = evaluate(random_arm(2), spec, tip="flange", audit_poses=20)
    reference = evaluate(random_arm(2), spec, tip="flange", engine="reference")
    assert (fast.reach, fast.attempts) == (reference.reach, reference.attempts)
    assert fast.torque == pytest.approx(reference.torque, abs=1e-6)
    assert fast.reach > 2
    assert fast.audit_fault == ""


# Five joints place the tool's axis; the sixth turns about it.
SIX = arm("YPPYPY", (0.05, 0.25, 0.2, 0.0, 0.1, 0.0))


@pytest.mark.parametrize("ik", ["paper", "mobo"])
def test_what_is_free_changes_no_bit(ik: str) -> None:
    """Poses that differ by a roll alone, or of any orientation, have the same solutions where that does not count."""
    spec, rng = load_spec(ik), np.random.default_rng(1)
    positions = rng.uniform(-0.3, 0.3, (40, 3)) + [0, 0, 0.2]
    turned = np.array([rpy_matrix(rng.uniform(-3, 3, 3)) for _ in positions])
    rolled = turned.copy()
    rolled[:, :, 0], rolled[:, :, 1] = turned[:, :, 1], -turned[:, :, 0]
    other = np.array([rpy_matrix(rng.uniform(-3, 3, 3)) for _ in positions])
    for orientation, also in (("free_roll", rolled), ("none", other)):
        asked = spec.model_copy(update={"orientation": orientation})
        outcome, q, torque = solve_poses(SIX, asked, positions, turned)
        again = solve_poses(SIX, asked, positions, also)
        assert (outcome == 0).sum() > 10
        for one, two in zip((outcome, q, torque), again, strict=True):
            assert one.tobytes() == two.tobytes()
        for i in np.flatnonzero(outcome == 0):
            tool = ReferenceModel(asked_chain(SIX, "", asked)).tip(q[i])
            assert np.linalg.norm(tool.translation - positions[i]) <= 1e-3 + 1e-12
            if orientation == "free_roll":
                assert math.acos(min(1.0, tool.rotation[:, 2] @ turned[i, :, 2])) <= math.radians(1) + 1e-9


def test_poses_whose_roll_is_free_are_reached() -> None:
    """Of poses taken from configurations, and then rolled at will, nearly all are reached."""
    spec = load_spec("mobo").model_copy(update={"orientation": "free_roll"})
    chain = asked_chain(SIX, "", spec)
    model, rng, poses = ReferenceModel(chain), np.random.default_rng(4), []
    while len(poses) < 200:
        q = rng.uniform(chain.lower, chain.upper)
        if model.clearance(q) > 0:
            poses.append(model.tip(q).copy())
    rolled = [pose.rotation @ rpy_matrix((0, 0, rng.uniform(-3, 3))) for pose in poses]
    outcome, _, _ = solve_poses(SIX, spec, np.array([p.translation for p in poses]), np.array(rolled))
    assert (outcome == 0).sum() >= 198


@given(st.integers(0, 10**6))
def test_starts_are_compared_by_what_counts(seed: int) -> None:
    """What `aim` gives measures 4 sin^2 of half the angle of orientations, or of z axes; or nothing."""
    rng, aimed = np.random.default_rng(seed), np.empty((3, 3))
    target, sample = (np.array(rpy_matrix(rng.uniform(-3, 3, 3))) for _ in range(2))
    angle = float(np.linalg.norm(pin.log3(sample.T @ target)))
    tilt = math.acos(min(1.0, max(-1.0, sample[:, 2] @ target[:, 2])))
    for orientation, expected in enumerate((angle, tilt, 0.0)):
        level = float(aim(orientation, target, aimed))
        assert level - float((aimed * sample).sum()) == pytest.approx(4 * math.sin(expected / 2) ** 2, abs=1e-9)


@given(st.integers(0, 10**6), st.sampled_from(["anyhow", "point", "along", "through", "at"]))
def test_box_distances_are_coals(seed: int, kind: str) -> None:
    """The distance of a capsule from a box is Coal's, and that of the nearest of points along its segment."""
    rng = np.random.default_rng(seed)
    turn, centre, half = np.array(rpy_matrix(rng.uniform(-3, 3, 3))), rng.uniform(-1, 1, 3), rng.uniform(0.01, 0.6, 3)
    a, b = rng.uniform(-1.5, 1.5, (2, 3))
    if kind == "point":
        b = a
    elif kind == "along":  # an edge or a side
        b = a + turn[:, seed % 3] * rng.uniform(-1, 1)
    elif kind == "through":
        b = 2 * centre - a
    elif kind == "at":
        a = centre + turn @ half
    found = math.sqrt(box_distance_squared(a, b, np.concatenate([centre, turn.ravel(), half])))
    points = (a + np.linspace(0, 1, 401)[:, None] * (b - a) - centre) @ turn
    nearest = np.linalg.norm(np.maximum(np.abs(points) - half, 0), axis=1).min()
    assert nearest - np.linalg.norm(b - a) / 400 <= found + 1e-12 <= nearest + 2e-12
    length, axis = float(np.linalg.norm(b - a)), np.array([0.0, 0.0, 1.0])
    along = pin.Quaternion.FromTwoVectors(axis, (b - a) / length).toRotationMatrix() if length else np.eye(3)
    expected = coal.distance(
        coal.Capsule(0.05, length), coal.Transform3s(along, (a + b) / 2), coal.Box(*(2 * half)),
        coal.Transform3s(turn, centre), coal.DistanceRequest(), coal.DistanceResult(),
    )  # fmt: skip
    if found > 0:
        assert found - 0.05 == pytest.approx(expected, abs=1e-6)
    else:
        assert expected <= -0.05 + 1e-6


ROOM: dict[str, Any] = {
    "floor_z": 0.0,
    "obstacles": [
        {"centre": [0.35, 0.0, 0.2], "size": [0.1, 0.5, 0.3], "rpy": [0.0, 0.3, 0.2]},
        {"centre": [-0.2, -0.3, 0.3], "size": [0.2, 0.1, 0.2]},
    ],
}


@pytest.mark.parametrize(("urdf", "tip", "floor"), [(arm("PRRYPY"), "", 0.0), (random_arm(4), "flange", -0.4)])
def test_touching_what_stands_around_is_coals(urdf: str, tip: str, floor: float) -> None:
    """Over random configurations the kernel calls those in collision with floor and boxes that Coal does."""
    spec = EvaluationSpec.of(ROOM | {"floor_z": floor})
    chain = asked_chain(urdf, tip, spec)
    around, reference, rng = obstacles_of(flat_arm(chain), spec), ReferenceModel(chain), np.random.default_rng(3)
    ends, verdicts = np.empty((len(chain.capsule_radius), 2, 3)), []
    for _ in range(300):
        q = rng.uniform(chain.lower, chain.upper)
        view, clearance = KernelView(chain, q), reference.clearance_around(q, around)
        touches = touches_anything(
            chain.capsule_joint, chain.capsule_a, chain.capsule_b, chain.capsule_radius, around,
            view.origins, view.rotations, ends,
        )  # fmt: skip
        if abs(clearance) > 1e-6:
            assert touches == (clearance < 0), (q.tolist(), clearance)
            verdicts.append(touches)
    assert len(verdicts) > 290
    assert 20 < sum(verdicts) < 290


def test_an_arm_may_stand_on_the_floor() -> None:
    """What is fixed to the base, and the link that touches the floor at any angle, do not count; all others do."""
    chain = asked_chain(arm("PRRYPY"), "", EvaluationSpec())
    around = obstacles_of(flat_arm(chain), EvaluationSpec.of(ROOM))
    assert around.against[:, 0].tolist() == [0] + [1] * (len(chain.capsule_joint) - 1)
    assert around.against[:, 1:].all()
    urdf = random_arm(3)
    chain = asked_chain(urdf, "flange", EvaluationSpec())
    deep = obstacles_of(flat_arm(chain), EvaluationSpec(floor_z=-9.0))
    assert deep.against[:, 0].tolist() == (chain.capsule_joint >= 0).tolist()


def test_what_stands_around_is_kept_clear_of() -> None:
    """Fewer poses are reached, as the reference engine finds; the others are in collision; the audit agrees."""
    urdf = arm("PRRYPY")
    spec, free = small_spec(**ROOM), evaluate(urdf, small_spec())
    found = evaluate(urdf, spec, audit_poses=40, configurations=True)
    assert 0.5 < found.reach < free.reach - 0.5
    assert found.in_collision.sum() > free.in_collision.sum()
    assert (found.audit_fault, found.audit_poses) == ("", 40)
    blind = evaluate(urdf, spec.model_copy(update={"self_collision": False}), configurations=True)
    assert found.reach <= blind.reach < free.reach + 0.5
    chain = asked_chain(urdf, "", spec)
    model, around = ReferenceModel(chain), obstacles_of(flat_arm(chain), spec)
    assert blind.configurations is not None
    assert min(model.clearance_around(q, around) for q in blind.configurations.q) > 0
    few = spec.model_copy(update={"poses_per_voxel": 1, "restarts": 1})
    fast, reference = (evaluate(urdf, few, engine=engine) for engine in ("kernel", "reference"))
    assert (fast.reach, fast.attempts) == (reference.reach, reference.attempts)
    assert np.array_equal(fast.in_collision, reference.in_collision)
    complete = evaluate(urdf, load_spec("mobo").model_copy(update={"obstacles": spec.obstacles, "floor_z": 0.0}))
    assert 10 < complete.reach < evaluate(urdf, load_spec("mobo")).reach - 1


def written(folder: Path, name: str, text: str) -> str:
    """Write a file and return its path."""
    (folder / name).write_text(text)
    return str(folder / name)


def test_files_of_poses(tmp_path: Path) -> None:
    """CSV and YAML, lists and names, roll, pitch and yaw or a quaternion: all give the same poses."""
    rng = np.random.default_rng(0)
    poses = [tuple(rng.uniform(-1.5, 1.5, 6).tolist()) for _ in range(5)] + [(0.1, 0.2, 0.3, 0.0, math.pi / 2, 0.4)]
    turned = [[*p[:3], *pin.Quaternion(pin.rpy.rpyToMatrix(*p[3:])).coeffs().tolist()] for p in poses]
    lines, names = [",".join(map(repr, p)) for p in poses], "x,y,z,roll,pitch,yaw"
    files = {
        "plain.csv": "\n".join(["# grasps", *lines]),
        "named.csv": "\n".join([names.upper(), *lines, ""]),
        "quaternions.csv": "\n".join(["x, y, z, qx, qy, qz, qw", *(",".join(map(repr, p)) for p in turned)]),
        "plain.yaml": json.dumps([list(p) for p in poses]),
        "quaternions.yaml": json.dumps({"poses": turned}),
        "named.yaml": json.dumps([dict(zip(names.split(","), p, strict=True)) for p in poses]),
    }
    for name, text in files.items():
        found = read_poses(written(tmp_path, name, text))
        for one, other in zip(found, poses, strict=True):
            assert one[:3] == other[:3]
            assert np.abs(pin.rpy.rpyToMatrix(*one[3:]) - pin.rpy.rpyToMatrix(*other[3:])).max() < 1e-7, name
    spec = load_spec(written(tmp_path, "spec.yaml", "poses: plain.csv\nseed: 3\n"))
    assert (spec.target_poses, spec.poses_per_voxel, spec.n_voxels) == (tuple(poses), 1, 6)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "1,2,3\n", "line 1: 3 numbers; expected x y z roll pitch yaw"),
        ("a.csv", "x,y,z,roll\n1,2,3,4\n", "line 2: names x, y, z, roll; expected"),
        ("a.csv", "x,y,z,roll,pitch,yaw\n1,2\n", "line 2: 2 cells; expected 6"),
        ("a.csv", "1,2,3,4,5,six\n", "line 1: 'six'; expected a finite number"),
        ("a.csv", "0,0,0,0,0,0,2\n", "line 1: a quaternion of length 2; expected length 1"),
        ("a.csv", "", "0 poses; expected 1 to 1000"),
        ("a.csv", "0,0,0,0,0,0\n" * 1001, "1001 poses; expected 1 to 1000"),
        ("a.yaml", "[[0, 0, 0, 0, 0, .nan]]", "pose 1: nan; expected a finite number"),
        ("a.yaml", "{a: 1}", "got dict; expected a list of poses"),
        ("a.yaml", "[1, 2]", "pose 1: 1; expected"),
        ("a.yaml", "[[", "not YAML"),
    ],
)
def test_bad_files_of_poses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, text: str, words: str
) -> None:
    """They are refused in one line that names file and place, with exit code 2."""
    path = written(tmp_path, name, text)
    assert main(["evaluate", "--joints", "PRRYPY", "--lengths", "0.1,0.1,0.1,0.1,0.1,0.1", "--poses", path]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert path in error
    assert words in error


def test_given_poses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Reach is how many of the given poses are reached; each has its outcome; both engines and the audit agree."""
    urdf = arm("PRRYPY")
    chain = asked_chain(urdf, "", EvaluationSpec())
    model, rng, rows = ReferenceModel(chain), np.random.default_rng(5), []
    while len(rows) < 12:
        q = rng.uniform(0.8 * chain.lower, 0.8 * chain.upper)
        if model.clearance(q) > 1e-3:
            pose = model.tip(q)
            rows.append([*pose.translation, *pin.Quaternion(pose.rotation).coeffs()])
    rows.append([0.0, 0.0, 5.0, 0, 0, 0, 1])
    path = written(tmp_path, "poses.csv", "\n".join(",".join(repr(float(v)) for v in row) for row in rows))
    spec = with_poses(load_spec("mobo"), read_poses(path))
    result = evaluate(urdf, spec, audit_poses=20)
    assert result.reach == 12.0
    assert result.outcomes() == ["reached"] * 12 + ["out_of_range"]
    assert result.torque == math.fsum(result.voxel_torque)
    assert (result.audit_fault, result.audit_poses) == ("", 12)
    plain = with_poses(EvaluationSpec(restarts=1), spec.target_poses)
    fast, reference = (evaluate(urdf, plain, engine=engine) for engine in ("kernel", "reference"))
    assert (fast.outcomes(), fast.attempts) == (reference.outcomes(), reference.attempts)
    assert 2 < fast.reach <= 12
    arguments = ["evaluate", "--joints", "PRRYPY", "--lengths", ",".join(map(str, LENGTHS["PRRYPY"])), "--poses", path]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert "reach   12 of 13 poses" in text
    assert "not reached: 13 (out of range)" in text
    assert main([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outcomes"] == result.outcomes()
