"""Arms from files as they are found: what is assumed, what is folded, what capsules cover."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from arms import HANDED_ARM, KernelView, WholeRobot, arm
from studies import mobo

from mobo_core.arms import meshes
from mobo_core.arms.capsules import fit, fit_one
from mobo_core.arms.read import ReadArm, read_arm
from mobo_core.arms.rigid import rotation_rpy, rpy_rotation
from mobo_core.errors import InputError
from mobo_core.evaluation.chain import Chain, chain_from_urdf
from mobo_core.evaluation.urdf import check_urdf


def body(name: str, mass: float, more: str = "") -> str:
    """Return a link with mass, off its origin."""
    inertia = '<inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="-0.002" izz="0.01"/>'
    return (
        f'<link name="{name}"><inertial><origin xyz="0.02 -0.01 0.1" rpy="0.3 0 0.2"/><mass value="{mass}"/>'
        f"{inertia}</inertial>{more}</link>"
    )


def joint(name: str, kind: str, parent: str, child: str, rest: str = "", at: str = "0 0 0.2") -> str:
    """Return a joint whose origin is turned by a right angle of pitch, where angles are hardest to take apart."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}" rpy="0.4 1.5707963267948966 0.3"/>{rest}</joint>'
    )


LIMITS = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'
FOLLOWING = '<mimic joint="grip" multiplier="-1"/>'
MESH = '<collision><origin xyz="0 0 0.1" rpy="0.2 0 0"/><geometry><mesh filename="{}"/></geometry></collision>'
# A world, a massless frame, an axis of length 2, a joint without limits, a camera, and a gripper whose second finger
# follows the first.
FOUND = "\n".join(
    [
        '<robot name="found"><link name="world"/><link name="base"/>',
        body("upper", 2.0, MESH.format("package://arm_description/meshes/bar.obj")),
        '<link name="frame"><inertial><mass value="0"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>',
        body("lower", 1.0, '<collision><geometry><box size="0.05 0.04 0.3"/></geometry></collision>'),
        body("camera", 0.3),
        body("wrist", 0.5),
        body("left", 0.1, '<collision><geometry><capsule radius="0.01" length="0.05"/></geometry></collision>'),
        body("right", 0.1),
        '<link name="tool0"/>',
        joint("stand", "fixed", "world", "base"),
        joint("j1", "revolute", "base", "upper", f'<axis xyz="0 0 2"/>{LIMITS}'),
        joint("plate", "fixed", "upper", "frame"),
        joint("j2", "continuous", "frame", "lower", '<axis xyz="0 1 0"/>'),
        joint("bolt", "fixed", "lower", "camera", at="0.1 0 0"),
        joint("j3", "revolute", "lower", "wrist", '<axis xyz="0.6 0 0.8"/><limit effort="1" velocity="1"/>'),
        joint("grip", "revolute", "wrist", "left", f'<axis xyz="1 0 0"/>{LIMITS}'),
        joint("follow", "revolute", "wrist", "right", f'<axis xyz="1 0 0"/>{LIMITS}{FOLLOWING}'),
        joint("flange", "fixed", "wrist", "tool0"),
        "</robot>",
    ]
)
# An L of two bars.
CORNERS = [(x, y, z) for x, y, z in np.ndindex(2, 2, 2)]


def bar(folder: Path) -> Path:
    """Write an L-shaped mesh of two boxes."""
    lines = []
    for sizes, shift in (((0.06, 0.06, 0.4), (0, 0, 0)), ((0.3, 0.06, 0.06), (0.03, 0, 0.4))):
        lines += ["v " + " ".join(str(c * s + o) for c, s, o in zip(p, sizes, shift, strict=True)) for p in CORNERS]
    for first in (1, 9):
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            lines += [f"f {first + a} {first + b} {first + c}", f"f {first + a} {first + c} {first + d}"]
    path = folder / "arm_description" / "meshes" / "bar.obj"
    path.parent.mkdir(parents=True)
    path.write_text("\n".join(lines))
    return path


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot's file deep in its package, the mesh beside it."""
    folder = tmp_path_factory.mktemp("found")
    bar(folder)
    path = folder / "arm_description" / "robots" / "urdf" / "found.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(FOUND)
    return path


@pytest.fixture(scope="module")
def read(found: Path) -> ReadArm:
    """The arm, its gripper held half open."""
    return read_arm(found, held={"grip": 0.5})


def test_tip_limits_and_frames(read: ReadArm) -> None:
    """The tool is guessed, a missing limit is said, frames without mass are folded, mimic fingers follow."""
    chain = chain_from_urdf(read.urdf, read.tip)
    assert (chain.joint_names, chain.tip) == (("j1", "j2", "j3"), "tool0")
    assert [note.partition(":")[0] for note in read.notes] == ["joint 'j3' has no limits", "tip 'tool0'"]
    assert (chain.lower[2], chain.upper[2]) == (-math.pi, math.pi)
    assert read.held == {"grip": 0.5, "follow": -0.5}
    assert check_urdf(read.urdf).leaves() == ["tool0"]


def test_kinematics_and_torque_are_pinocchios(read: ReadArm) -> None:
    """The chain has tip and gravity torque of the file as it was, the gripper's mass in its held place."""
    chain, whole = chain_from_urdf(read.urdf, read.tip), Held(FOUND, dict(read.held))
    rng = np.random.default_rng(0)
    for _ in range(10):
        q = rng.uniform(chain.lower, chain.upper)
        view, pose = KernelView(chain, q), whole.tip(chain.joint_names, q, read.tip)
        assert np.abs(view.tip[3] - pose.translation).max() < 1e-12
        assert np.abs(view.tip[:3] - pose.rotation).max() < 1e-12
        assert np.abs(view.torque() - whole.torque(chain.joint_names, q)).max() < 1e-12


class Held(WholeRobot):
    """The whole robot with some joints held elsewhere than at zero."""

    def __init__(self, urdf: str, held: dict[str, float]) -> None:
        super().__init__(re.sub("<collision>.*?</collision>", "", urdf))  # urdfdom knows no capsules
        self._held = held

    def configuration(self, joints: tuple[str, ...], q: np.ndarray) -> np.ndarray:
        names = (*joints, *self._held)
        return super().configuration(names, np.array([*q, *self._held.values()]))


def test_a_joint_on_the_way_can_be_held(found: Path) -> None:
    """One that is set is fixed there; beyond its limits it is refused."""
    chain = chain_from_urdf(read_arm(found, held={"j2": 0.7}, shapes=False).urdf)
    assert chain.joint_names == ("j1", "j3")
    whole = Held(FOUND, {"j2": 0.7})
    pose = whole.tip(chain.joint_names, np.array([0.1, 0.2]), "tool0")
    assert np.abs(KernelView(chain, np.array([0.1, 0.2])).tip[3] - pose.translation).max() < 1e-12
    for held, words in (({"j1": 3.0}, "expected -2 to 2"), ({"j9": 0.0}, "no joint 'j9'"), ({"bolt": 0.0}, "no joint")):
        with pytest.raises(InputError, match=words):
            read_arm(found, held=held)


def test_what_a_study_sends_stays_as_it_is(tmp_path: Path) -> None:
    """The chain of a mobo arm's file has the bits of the chain of its text."""
    (tmp_path / "arm.urdf").write_text(arm("PRRYPY", motor_radius=0.02, motor_length=0.03))
    read = read_arm(tmp_path / "arm.urdf")
    ours, theirs = chain_from_urdf(read.urdf), chain_from_urdf((tmp_path / "arm.urdf").read_bytes())
    for name, value in vars(ours).items():
        if isinstance(value, np.ndarray):
            assert np.array_equal(value, getattr(theirs, name)), name
    assert (read.notes, read.capsules.fitted) == ((), 0)


def test_capsules_cover_meshes_and_boxes(read: ReadArm, found: Path) -> None:
    """Where the capsules of two links are apart, so are the mesh and the box in them; the L has more than one."""
    assert {link: each.fitted for link, each in read.fitted.items()}["upper"] > 1
    assert 1.0 < (read.capsules.volume_ratio or 0.0) < 4.0
    assert read.capsules.to_dict()["at"] == read.capsules.at == "upper"
    mesh = coal.MeshLoader().load(str(found.parents[2] / "meshes" / "bar.obj"), np.ones(3))
    box = coal.Box(0.05, 0.04, 0.3)
    chain = chain_from_urdf(read.urdf, "lower")
    whole = Held(FOUND, {"j3": 0.0, "grip": 0.0, "follow": 0.0})
    upper, lower = (np.flatnonzero(chain.capsule_joint == k) for k in (0, 1))
    rng, free, hit = np.random.default_rng(0), 0, 0
    for _ in range(300):
        q = rng.uniform(chain.lower, chain.upper)
        ends = placed(chain, q)
        apart = min(
            segments(ends[i], ends[j]) - chain.capsule_radius[i] - chain.capsule_radius[j] for i in upper for j in lower
        )
        at = [whole.tip(chain.joint_names, q, link) for link in ("upper", "lower")]
        at[0] = at[0] * pin.SE3(pin.rpy.rpyToMatrix(0.2, 0, 0), np.array([0, 0, 0.1]))
        result = coal.CollisionResult()
        places = [coal.Transform3s(one.rotation, one.translation) for one in at]
        touching = coal.collide(mesh, places[0], box, places[1], coal.CollisionRequest(), result) > 0
        free, hit = free + (apart > 0), hit + touching
        assert not (touching and apart > 0)
    assert free and hit


def placed(chain: Chain, q: np.ndarray) -> np.ndarray:
    """Return the ends of all capsules in the base frame."""
    view = KernelView(chain, q)
    return np.array(
        [
            [view.origins[j] + view.rotations[j] @ end if j >= 0 else end for end in (a, b)]
            for j, a, b in zip(chain.capsule_joint, chain.capsule_a, chain.capsule_b, strict=True)
        ]
    )


def segments(a: np.ndarray, b: np.ndarray) -> float:
    """Return the distance of two segments, by Coal."""
    shapes = [coal.Capsule(1e-9, float(np.linalg.norm(one[1] - one[0]))) for one in (a, b)]
    places = []
    for one in (a, b):
        along = (one[1] - one[0]) / max(float(np.linalg.norm(one[1] - one[0])), 1e-300)
        turned = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), along).toRotationMatrix()
        places.append(coal.Transform3s(turned, one.mean(axis=0)))
    return coal.distance(shapes[0], places[0], shapes[1], places[1], coal.DistanceRequest(), coal.DistanceResult())


@pytest.mark.parametrize("seed", range(4))
def test_a_capsule_holds_all_points(seed: int) -> None:
    """Points of any cloud lie inside the capsule fitted to it, which is hardly larger than it has to be."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(200, 3)) * rng.uniform(0.01, 0.3, 3)
    assert fit_one(points).depth(points).min() > 0
    flat = points * (1.0, 1.0, 0.0)
    assert fit_one(flat).depth(flat).min() > 0
    axis = rng.normal(size=3)
    on_capsule = rng.normal(size=(400, 3))
    on_capsule *= 0.1 / np.linalg.norm(on_capsule, axis=1, keepdims=True)
    on_capsule += np.sign(on_capsule @ axis)[:, None] * 0.3 * axis / np.linalg.norm(axis)
    best = math.pi * 0.1**2 * (0.6 + 0.4 / 3)
    assert best * 0.9 < fit_one(on_capsule).volume < best * 1.15


@pytest.mark.parametrize("seed", range(3))
def test_cut_triangles_stay_covered(seed: int) -> None:
    """Points anywhere on triangles lie inside one of the capsules that they are cut for."""
    rng = np.random.default_rng(seed)
    triangles = rng.normal(size=(30, 1, 3)) * (0.5, 0.1, 0.1) + rng.normal(size=(30, 3, 3)) * 0.05
    triangles[15:, :, :2] += np.array([0.5, 0.0]) + triangles[15:, :, 1:2] * 5
    weights = rng.dirichlet((1, 1, 1), 2000)
    points = np.einsum("pk,pkx->px", weights, triangles[rng.integers(30, size=2000)])
    capsules = fit(triangles)
    assert np.max([capsule.depth(points) for capsule in capsules], axis=0).min() > -1e-12


def test_angles_of_any_rotation() -> None:
    """Roll, pitch and yaw give the rotation back, at right angles of pitch too."""
    for pitch in (0.0, 0.3, math.pi / 2, -math.pi / 2, math.pi / 2 - 1e-9, 2.5):
        turned = rpy_rotation((0.4, pitch, -1.1))
        assert np.abs(rpy_rotation(rotation_rpy(turned)) - turned).max() < 1e-15
        assert np.abs(turned - pin.rpy.rpyToMatrix(0.4, pitch, -1.1)).max() < 1e-15


def test_pairs_by_srdf_and_neighbours(tmp_path: Path) -> None:
    """An SRDF says which links may touch, and all others may not; so do neighbours."""
    found = tmp_path / "tubes.urdf"
    tube = '<sphere radius="0.05"/>'
    found.write_text(re.sub('<mesh filename=".*?"/>|<box size=".*?"/>', tube, FOUND))
    srdf = tmp_path / "found.srdf"
    srdf.write_text('<robot name="found"><disable_collisions link1="lower" link2="left" reason="Never"/></robot>')

    def pairs(**how: str) -> set[frozenset[str]]:
        read = read_arm(found, **how)
        names = [shape.name for shape in check_urdf(read.urdf).shapes]
        return {frozenset((names[i], names[j])) for i, j in chain_from_urdf(read.urdf, read.tip).pairs.tolist()}

    assert pairs(srdf=str(srdf)) == {frozenset(("upper", "lower")), frozenset(("upper", "left"))}
    assert pairs(pairs="adjacent") == {frozenset(("upper", "left"))}
    srdf.write_text('<robot name="other"><disable_collisions link1="a" link2="b"/></robot>')
    with pytest.raises(InputError, match="1 pairs of links, none of them of this robot"):
        read_arm(found, srdf=str(srdf))


def test_xacro_is_expanded(tmp_path: Path) -> None:
    """A xacro file takes arguments, and finds packages as meshes are found."""
    bar(tmp_path)
    macro = FOUND.replace('<robot name="found">', '<robot name="found" xmlns:xacro="http://www.ros.org/wiki/xacro">')
    macro = macro.replace('xyz="0 0 2"', 'xyz="0 0 $(arg long)"')
    (tmp_path / "arm_description" / "all.xacro").write_text(macro)
    top = tmp_path / "top.urdf.xacro"
    include = '<xacro:include filename="$(find arm_description)/all.xacro"/>'
    top.write_text(f'<robot name="top" xmlns:xacro="http://www.ros.org/wiki/xacro">{include}</robot>')
    assert read_arm(top, xacro={"long": "3"}, shapes=False).tip == "tool0"
    with pytest.raises(InputError, match="xacro: .*long"):
        read_arm(top, shapes=False)
    top.write_text(top.read_text().replace("$(find arm_description)/all.xacro", str(top)))
    with pytest.raises(InputError, match="xacro"):
        read_arm(top)


# A node of itself: assimp takes its process with it.
ENDLESS = """<COLLADA version="1.4.1"><library_visual_scenes><visual_scene id="v"><node id="n"><instance_node url="#n"/>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#v"/></scene></COLLADA>"""


def replaced(old: str, new: str) -> str:
    assert old in FOUND
    return FOUND.replace(old, new)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (replaced("bar.obj", "lost.obj"), "lost.obj': .*No such file"),
        (replaced("arm_description", "nowhere"), "package 'nowhere' is not found"),
        (replaced("package://arm_description/meshes/bar.obj", ""), "no name of a file"),
        (replaced("package://arm_description/meshes/bar.obj", "http://x/bar.obj"), "scheme http://"),
        (replaced("package://arm_description/meshes/bar.obj", "/dev/zero"), "is no file"),
        (replaced("bar.obj", "huge.stl"), "200000000 bytes; expected a mesh of up to 100 MB"),
        (replaced("bar.obj", "none.obj"), "0 bytes"),
        (replaced("bar.obj", "noise.stl"), "cannot be read|triangles"),
        (replaced("bar.obj", "cut.dae"), "cut.dae': not well-formed XML"),
        (replaced("bar.obj", "endless.dae"), "endless.dae': cannot be read .its reader ended with -"),
        (replaced("bar.obj", "circle.obj"), "circle.obj.*[Ll]evels of symbolic links"),
        (replaced('<mass value="2.0"/>', '<mass value="-2"/>'), "mass -2 kg"),
        (replaced('<mass value="2.0"/>', '<mass value="nan"/>'), "value='nan'"),
        (replaced('xyz="0 0 2"', 'xyz="0 0 0"'), "axis 0.0 0.0 0.0; expected a direction"),
        (replaced('lower="-2"', 'lower="3"'), "lower 3, upper 2"),
        (replaced('type="continuous"', 'type="hinge"'), "type 'hinge'"),
        (replaced('type="continuous"', 'type="prismatic"'), "'j2': slides, and has no limits; expected .*--set j2=0"),
        (replaced('link name="camera"', 'link name="wrist"'), "two links named 'wrist'"),
        (replaced('child link="camera"', 'child link="wrist"'), "closes a loop"),
        (replaced('box size="0.05', 'box size="-1'), "box of -1.0"),
        ("<!DOCTYPE r [<!ENTITY a 'b'>]><robot/>", "forbidden XML"),
        ("<robot>" + "<a>" * 50, "nested deeper"),
        ("<mujoco/>", "MJCF, MuJoCo's format, which is not read; expected URDF or xacro, such as"),
        ("<mujocoinclude/>", "MJCF, MuJoCo's format"),
        ("<sdf/>", "root element <sdf>"),
        ("\0\1", "not well-formed"),
        (HANDED_ARM.replace("tcp", "thing"), "a guess|tip"),
    ],
)
def test_bad_files(text: str, words: str, found: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is no good ends the command with one line that says what, where and what was expected, and exit code 2."""
    meshes = found.parents[2] / "meshes"
    if not (meshes / "huge.stl").exists():
        with (meshes / "huge.stl").open("wb") as file:
            file.truncate(200_000_000)
        (meshes / "none.obj").touch()
        (meshes / "cut.dae").write_text('<?xml version="1.0"?><COLLADA><library_geometries><geometry id="a">')
        (meshes / "endless.dae").write_text(ENDLESS)
        (meshes / "noise.stl").write_bytes(bytes(np.random.default_rng(0).integers(0, 256, 3000, dtype=np.uint8)))
        os.symlink("circle.obj", meshes / "circle.obj")
    path = found.with_name("bad.urdf")
    path.write_text(text)
    if "thing" in text:  # plain still: fingers slide
        assert read_arm(path).tip == "thing"
        return
    with pytest.raises(InputError, match=words):
        read_arm(path)


def test_a_mesh_that_takes_too_long_is_given_up(found: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some files hang their reader."""
    monkeypatch.setattr(meshes, "READING_S", 0.01)
    with pytest.raises(InputError, match=r"bar.obj': cannot be read \(not within 0.01 s\); expected a mesh such as"):
        read_arm(found)


def test_the_command_says_what_it_assumed(found: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """`mobo evaluate FILE` reads it so; errors are one line; --set is for files alone."""
    spec = tmp_path / "spec.yaml"
    spec.write_text("{poses_per_voxel: 1, iterations: 5}")
    code = mobo("evaluate", found, "--set", "grip=30deg", "--spec", spec, "--engine", "reference")
    out, err = capfd.readouterr()
    assert code == 0 and "shapes  " in out and "held    grip 0.5236, follow -0.5236" in out
    assert "note: tip 'tool0': a guess" in err
    for arguments in (("--set", "grip"), ("--set", "grip=x"), ("--tip", "hook"), ("--package-dir", "/nowhere")):
        assert mobo("evaluate", found, *arguments) == 2
        err = capfd.readouterr().err
        assert len(err.splitlines()) == 1, err
    lengths = ("--joints", "YPPYPY", "--lengths", "0.05,0.25,0.2,0.05,0,0.05")
    assert mobo("evaluate", *lengths, "--srdf", "x.srdf") == 2
