"""URDFs from anywhere: what is refused, and what the chain of a sound one is."""

from __future__ import annotations

import math
import re

import numpy as np
import pinocchio as pin
import pytest
from arms import HANDED_ARM, KernelView, WholeRobot, arm, random_arm
from hypothesis import given, settings
from hypothesis import strategies as st

from mobo_core.errors import InputError
from mobo_core.evaluation.chain import Chain, chain_from_urdf
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.urdf import MAX_BYTES, check_urdf

GOOD = arm("PRRYPY")
INERTIA = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'


def refusal(urdf: str | bytes, tip: str = "") -> str:
    """Return the error on a URDF, after checking that it is one line that says where and what was expected."""
    with pytest.raises(InputError) as error:
        chain_from_urdf(urdf, tip)
    text = str(error.value)
    assert error.value.exit_code == 2
    assert text == " ".join(text.split())
    assert re.match(r"(urdf|tip)( (link|joint) .*)?: .+; expected .+", text), text
    assert len(text) < 400
    return text


def changed(old: str, new: str, count: int = 1) -> str:
    """Return the good URDF with ``old`` replaced, which must be in it."""
    assert old in GOOD
    return GOOD.replace(old, new, count)


def robot(*parts: str) -> str:
    return '<robot name="r">' + "".join(parts) + "</robot>"


def links(n: int) -> str:
    return "".join(f'<link name="l{i}"/>' for i in range(n))


def joint(name: str, parent: str, child: str, kind: str = "continuous") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/></joint>'


def chain_of(n: int) -> str:
    return robot(links(n + 1), *(joint(f"j{i}", f"l{i}", f"l{i + 1}") for i in range(n)))


def with_axis(axis: str) -> str:
    turning = joint("turn", "l0", "l1").replace("</joint>", f'<axis xyz="{axis}"/></joint>')
    return robot(links(2), turning)


def with_limit(limit: str, kind: str = "revolute") -> str:
    return robot(links(2), joint("turn", "l0", "l1", kind).replace("</joint>", f"{limit}</joint>"))


def with_mass(mass: str) -> str:
    return robot('<link name="l0"/>', f'<link name="l1"><inertial>{mass}</inertial></link>', joint("j", "l0", "l1"))


def with_shape(shape: str) -> str:
    body = f'<link name="l1"><collision><geometry>{shape}</geometry></collision></link>'
    return robot('<link name="l0"/>', body, joint("j", "l0", "l1"))


BOMB = (
    '<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY a0 "ha">'
    + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 10))
    + ']><robot name="&a9;"><link name="a"/></robot>'
)


@pytest.mark.parametrize(
    ("urdf", "words"),
    [
        pytest.param("", "not well-formed XML", id="empty"),
        pytest.param("PRRYPY", "not well-formed XML", id="no XML"),
        pytest.param(GOOD[: len(GOOD) // 2], "not well-formed XML", id="truncated"),
        pytest.param(GOOD[:-9], "not well-formed XML", id="last tag missing"),
        pytest.param(GOOD + "<robot/>", "not well-formed XML", id="two roots"),
        pytest.param(changed("</link>", "</lnik>"), "line ", id="wrong closing tag"),
        pytest.param(GOOD.encode("utf-16")[:-7], "not well-formed XML", id="cut UTF-16"),
        pytest.param(changed("?>", ' encoding="klingon"?>'), "klingon", id="unknown encoding"),
        pytest.param(changed("?>", ' encoding="utf-7"?>'), "multi-byte encodings", id="odd encoding"),
        pytest.param(changed('"link_3"', '"\0"', 9), "not well-formed XML", id="zero byte"),
        pytest.param(changed('"link_3"', '"\ud800"', 9), "not well-formed XML", id="lone surrogate"),
        pytest.param("<html/>", "root element <html>; expected <robot>", id="another document"),
        pytest.param("<sdf><robot/></sdf>", "root element <sdf>", id="robot inside"),
        pytest.param(BOMB, "forbidden XML (DTDForbidden)", id="XML bomb"),
        pytest.param('<!DOCTYPE r SYSTEM "file:///etc/passwd"><robot/>', "DTDForbidden", id="DTD"),
        pytest.param("<robot>" + "<a>" * 10_000, "nested deeper than 32", id="deep"),
        pytest.param("<a>" * 300_000, "nested deeper than 32", id="deep and long"),
        pytest.param("<robot>" + " " * 50_000_000 + "</robot>", "at most 1000000 bytes", id="50 MB"),
        pytest.param(b"<robot>" + b"<link/>" * 7_000_000, "49000007 bytes", id="50 MB of links"),
        pytest.param(robot(), "0 links; expected 2 to 256", id="no links"),
        pytest.param(robot(links(1)), "1 links; expected 2 to 256", id="one link"),
        pytest.param(robot(links(2)), "0 joints; expected 1 to 64", id="no joints"),
        pytest.param(chain_of(65), "65 joints; expected 1 to 64", id="65 joints"),
        pytest.param(chain_of(5000), "5001 links; expected 2 to 256", id="5,000 joints"),
        pytest.param(robot(links(257), joint("j", "l0", "l1")), "257 links", id="257 links"),
        pytest.param(
            robot(links(2), *(joint(f"j{i}", "l0", "l1") for i in range(5000))), "5000 joints", id="5,000 joints only"
        ),
        pytest.param(robot(links(2), links(1), joint("j", "l0", "l1")), "two links named 'l0'", id="same link"),
        pytest.param(
            robot(links(3), joint("j", "l0", "l1"), joint("j", "l1", "l2")), "two joints named 'j'", id="same joint"
        ),
        pytest.param(changed('name="link_3"', 'name=""'), "link named ''", id="no name"),
        pytest.param(changed('name="link_3"', 'nom="link_3"'), "link named ''", id="no name attribute"),
        pytest.param(changed('name="link_3"', f'name="{"x" * 201}"'), "printable name", id="long name"),
        pytest.param(changed('name="link_3"', 'name="a&#10;b"'), "printable name", id="line break in a name"),
        pytest.param(
            changed('parent link="link_3"', 'parent link="lost"'), "'joint_4': parent link 'lost'", id="no parent"
        ),
        pytest.param(
            changed('child link="link_3"', 'child link="lost"'), "'joint_3': child link 'lost'", id="no child"
        ),
        pytest.param(changed('<parent link="link_3"/>', ""), "'joint_4': parent link ''", id="no parent element"),
        pytest.param(
            changed('child link="tool"', 'child link="link_2"'), "link 'link_2' closes a loop", id="loop: two parents"
        ),
        pytest.param(
            changed('child link="tool"', 'child link="base_link"'), "closes a loop", id="loop through the base"
        ),
        pytest.param(
            robot(links(3), joint("a", "l1", "l2"), joint("b", "l2", "l1")),
            "closes a loop; expected one tree",
            id="loop apart",
        ),
        pytest.param(
            robot(links(2), joint("a", "l0", "l1"), joint("b", "l1", "l0")), "the joints close a loop", id="no root"
        ),
        pytest.param(robot(links(2), joint("a", "l1", "l1")), "link 'l1' closes a loop", id="loop of one"),
        pytest.param(
            robot(links(4), joint("a", "l0", "l1"), joint("b", "l2", "l3")), "2 root links (l0, l2)", id="two trees"
        ),
        pytest.param(changed('type="revolute"', 'type="floating"'), "'joint_1': type 'floating'", id="floating"),
        pytest.param(changed('type="revolute"', 'type="planar"'), "type 'planar'", id="planar"),
        pytest.param(changed('type="revolute"', ""), "type ''", id="no type"),
        pytest.param(
            changed("<axis", '<mimic joint="joint_2"/><axis'), "'joint_1': follows another joint", id="mimic on the way"
        ),
        pytest.param(
            changed('type="revolute"', 'type="prismatic"').replace("<axis", '<slide radius="0"/><axis', 1),
            "'joint_1' slide: radius 0; expected above 0",
            id="slide of no radius",
        ),
        pytest.param(robot(links(2), joint("a", "l0", "l1", "fixed")), "no joint between 'l0' and 'l1'", id="fixed"),
        pytest.param(with_mass('<mass value="0"/>'), "link 'l1': mass 0 kg; expected more than 0", id="zero mass"),
        pytest.param(with_mass('<mass value="-1"/>'), "mass -1 kg", id="negative mass"),
        pytest.param(with_mass('<mass value="nan"/>'), "'nan'", id="NaN mass"),
        pytest.param(with_mass('<mass value="inf"/>'), "'inf'", id="infinite mass"),
        pytest.param(with_mass('<mass value="1e7"/>'), "'1e7'", id="huge mass"),
        pytest.param(with_mass('<mass value="heavy"/>'), "'heavy'; expected 1 finite number", id="mass in words"),
        pytest.param(with_mass('<mass value="1 2"/>'), "'1 2'", id="two masses"),
        pytest.param(with_mass("<mass/>"), "value=''", id="mass without value"),
        pytest.param(with_mass(INERTIA), "value=''", id="no mass"),
        pytest.param(
            with_mass('<mass value="1"/>' + INERTIA.replace('ixx="1"', 'ixx="nan"')), "ixx='nan'", id="NaN inertia"
        ),
        pytest.param(
            with_mass('<mass value="1"/><origin xyz="0 0 inf"/>'), "xyz='0 0 inf'", id="infinite centre of mass"
        ),
        pytest.param(with_axis("0 0 0"), "joint 'turn': axis 0.0 0.0 0.0", id="zero axis"),
        pytest.param(with_axis("0 0 2"), "a vector of length 1", id="long axis"),
        pytest.param(with_axis("0 0 nan"), "xyz='0 0 nan'", id="NaN axis"),
        pytest.param(with_axis("0 1"), "xyz='0 1'; expected 3 finite numbers", id="flat axis"),
        pytest.param(with_axis("x y z"), "xyz='x y z'", id="axis in letters"),
        pytest.param(with_limit(""), "no <limit>", id="no limit"),
        pytest.param(with_limit('<limit lower="1" upper="-1"/>'), "lower 1, upper -1", id="lower > upper"),
        pytest.param(with_limit('<limit lower="1" upper="1"/>'), "expected lower < upper", id="lower = upper"),
        pytest.param(with_limit("<limit/>"), "lower 0, upper 0", id="empty limit"),
        pytest.param(with_limit('<limit lower="-1" upper="inf"/>'), "upper='inf'", id="infinite limit"),
        pytest.param(with_limit('<limit lower="nan" upper="1"/>'), "lower='nan'", id="NaN limit"),
        pytest.param(with_limit('<limit lower="-1e5" upper="1"/>'), "within 1000", id="far limit"),
        pytest.param(changed('xyz="0 0 0.06"', 'xyz="0 0 nan"'), "'joint_2': xyz='0 0 nan'", id="NaN origin"),
        pytest.param(changed('xyz="0 0 0.06"', 'xyz="0 0 1e400"'), "xyz='0 0 1e400'", id="infinite origin"),
        pytest.param(changed('xyz="0 0 0.06"', 'xyz="0 0 1e9"'), "xyz='0 0 1e9'", id="far origin"),
        pytest.param(changed('xyz="0 0 0.06"', 'xyz="0.06"'), "expected 3 finite numbers", id="short origin"),
        pytest.param(changed('rpy="0 0 0" xyz="0 0 0.06"', 'rpy="0 nan 0"'), "'joint_2': rpy='0 nan 0'", id="NaN turn"),
        pytest.param(with_shape('<cylinder radius="0" length="1"/>'), "radius 0, length 1", id="no radius"),
        pytest.param(with_shape('<cylinder radius="1" length="-1"/>'), "radius 1, length -1", id="short cylinder"),
        pytest.param(with_shape('<cylinder radius="1"/>'), "length=''", id="no length"),
        pytest.param(with_shape('<sphere radius="-1"/>'), "radius -1", id="negative sphere"),
        pytest.param(with_shape('<mesh filename="/etc/passwd"/>'), "link 'l1' collision: a mesh; expected", id="mesh"),
        pytest.param(with_shape('<sphere radius="nan"/>'), "radius='nan'", id="NaN sphere"),
        pytest.param(
            with_shape('<sphere radius="1"/>').replace("<geometry>", '<origin rpy="inf 0 0"/><geometry>'),
            "rpy='inf 0 0'",
            id="infinite shape",
        ),
        pytest.param(HANDED_ARM, "3 leaf links (left_finger, right_finger, tcp)", id="branch without a tip"),
    ],
)
def test_bad_urdfs(urdf: str | bytes, words: str) -> None:
    """What is no sound arm is refused in one line that says what, where and what was expected."""
    assert words in refusal(urdf)


@pytest.mark.parametrize(
    ("urdf", "tip", "words"),
    [
        (GOOD, "hand", "tip: no link 'hand'; expected a link of the URDF, such as tool"),
        (GOOD, "base_link", "no joint between 'base_link' and 'base_link'"),
        (HANDED_ARM, "joint7", "no link 'joint7'"),
        (HANDED_ARM, "tcp ", "no link 'tcp '"),
    ],
)
def test_bad_tips(urdf: str, tip: str, words: str) -> None:
    """A tip that is no link, or that no joints lead to, is refused by name."""
    assert words in refusal(urdf, tip)


def test_size_limit_is_in_bytes() -> None:
    """The size limit counts bytes, and just below it a URDF passes."""
    pad = MAX_BYTES - len(GOOD)
    assert chain_from_urdf(GOOD + " " * pad).n == 6
    assert "1000001 bytes" in refusal(GOOD + " " * (pad + 1))
    assert "bytes" in refusal(GOOD + "<!--" + "é" * (MAX_BYTES // 2) + "-->")


def test_bytes_and_text_are_alike() -> None:
    """UTF-8 and UTF-16 bytes, with a mark or without, give the same chain as the text."""
    expected = chain_from_urdf(GOOD)
    utf_16 = GOOD.replace('"1.0" ?>', '"1.0" encoding="utf-16"?>').encode("utf-16")
    for urdf in (GOOD.encode(), b"\xef\xbb\xbf" + GOOD.encode(), utf_16):
        chain = chain_from_urdf(urdf)
        assert np.array_equal(chain.placement_p, expected.placement_p)
        assert chain.joint_names == expected.joint_names


def test_names_that_libraries_use_themselves() -> None:
    """Links and joints may bear each other's names and Pinocchio's own, and characters that XML escapes."""
    expected = chain_from_urdf(GOOD)
    others = {
        "link_3": "joint_2",
        "base_link": "joint_2",
        "joint_1": "link_1",
        "joint_4": "tool",
        "tool_joint": "link_1",
    }
    for old, other in others.items():
        for new in (other, "universe", "root_joint", "a b", "&lt;&amp;&quot;", "関節"):
            chain = chain_from_urdf(GOOD.replace(f'"{old}"', f'"{new}"'))
            assert np.array_equal(chain.placement_p, expected.placement_p), (old, new)
            assert np.array_equal(chain.pairs, expected.pairs), (old, new)


@settings(max_examples=200)
@given(
    st.sampled_from([(GOOD, ""), (HANDED_ARM, "tcp"), (random_arm(0), "flange")]),
    st.lists(st.tuples(st.floats(0, 1), st.integers(0, 255) | st.just(-1)), max_size=6),
    st.tuples(st.floats(0, 1), st.floats(0, 1)) | st.none(),
)
def test_damaged_urdfs_are_read_or_refused(
    case: tuple[str, str], changes: list[tuple[float, int]], cut: tuple[float, float] | None
) -> None:
    """With bytes changed, dropped or cut out, a URDF gives a chain of finite numbers or an InputError, nothing else."""
    data, tip = bytearray(case[0].encode()), case[1]
    for where, value in changes:
        at = min(int(where * len(data)), len(data) - 1)
        data[at : at + 1] = b"" if value < 0 else bytes([value])
    if cut:
        first, last = sorted(int(share * len(data)) for share in cut)
        del data[first:last]
    read_or_refused(bytes(data), tip)


NUMBER = re.compile(r"-?\d+\.\d+(e-?\d+)?")


@settings(max_examples=200)
@given(
    st.sampled_from([(GOOD, ""), (HANDED_ARM, "tcp"), (random_arm(1), "flange")]),
    st.lists(
        st.tuples(
            st.floats(0, 1),
            st.one_of(
                st.floats().map(repr),
                st.sampled_from(["0", "-0.0", "1e-320", "1e308", "", "1 2", "1_0", "0x1p3", "١", "--1", "1e", "+1."]),
            ),
        ),
        min_size=1,
        max_size=4,
    ),
)
def test_odd_numbers_are_read_or_refused(case: tuple[str, str], changes: list[tuple[float, str]]) -> None:
    """With other numbers in it, a URDF gives a chain of finite numbers or an InputError, nothing else."""
    urdf, tip = case
    for where, number in changes:
        found = list(NUMBER.finditer(urdf))
        match = found[min(int(where * len(found)), len(found) - 1)]
        urdf = urdf[: match.start()] + number + urdf[match.end() :]
    read_or_refused(urdf, tip)


def read_or_refused(urdf: str | bytes, tip: str) -> None:
    try:
        chain = chain_from_urdf(urdf, tip)
    except InputError as error:
        text = str(error)
        assert text == " ".join(text.split())
        assert len(text) < 1000
        return
    check_chain(chain)


def check_chain(chain: Chain) -> None:
    """Check what must hold for any chain."""
    n = chain.n
    assert 1 <= n <= 64
    assert chain.placement_r.shape == (n, 3, 3)
    arrays = [chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, chain.com, chain.capsule_a]
    arrays += [chain.mass, chain.lower, chain.upper, chain.capsule_b, chain.capsule_radius]
    assert all(np.all(np.isfinite(array)) for array in arrays)
    assert math.isfinite(chain.reach_radius)
    assert np.all(chain.mass >= 0)
    assert np.all(chain.lower < chain.upper)
    for turn in [*chain.placement_r, chain.tip_r]:
        assert np.abs(turn @ turn.T - np.eye(3)).max() < 1e-12
        assert np.linalg.det(turn) > 0
    joints = chain.capsule_joint
    assert all(-1 <= joint < n for joint in joints)
    assert all(joints[i] != joints[j] for i, j in chain.pairs)


@pytest.mark.parametrize("seed", range(6))
def test_oblique_arms(seed: int) -> None:
    """For any axes, turned frames, fixed joints on the way and a branch, tip and torque are Pinocchio's."""
    urdf = random_arm(seed, n=3 + seed)
    compare_with_pinocchio(urdf, "flange", 3 + seed)


def test_arm_with_a_hand() -> None:
    """An arm with a branched hand has its seven joints, and its fingers are held, their weight counting."""
    chain = compare_with_pinocchio(HANDED_ARM, "tcp", 7)
    assert chain.joint_names == tuple(f"joint{i}" for i in range(1, 8))
    assert chain.mass.sum() == pytest.approx(4.9 + 0.6 + 3.2 + 3.6 + 1.2 + 1.7 + 0.7 + 0.7 + 2 * 0.015)
    without = re.sub(r'<link name="(left|right)_finger".*?</link>', r'<link name="\1_finger"/>', HANDED_ARM)
    q = np.clip(np.full(7, 0.4), chain.lower, chain.upper)
    lighter = KernelView(chain_from_urdf(without, "tcp"), q).torque()
    assert np.abs(KernelView(chain, q).torque() - lighter).max() > 0.01


def compare_with_pinocchio(urdf: str, tip: str, n: int) -> Chain:
    """Compare the chain with Pinocchio's model of the whole URDF, all its joints in it."""
    chain, whole = chain_from_urdf(urdf, tip), WholeRobot(urdf)
    check_chain(chain)
    assert (chain.n, chain.tip) == (n, tip)
    rng = np.random.default_rng(n)
    for _ in range(5):
        q = rng.uniform(chain.lower, chain.upper)
        view, pose = KernelView(chain, q), whole.tip(chain.joint_names, q, tip)
        assert np.abs(view.tip[3] - pose.translation).max() < 1e-12
        assert np.abs(view.tip[:3] - pose.rotation).max() < 1e-12
        assert np.abs(view.torque() - whole.torque(chain.joint_names, q)).max() < 1e-12
    return chain


def test_any_link_may_be_the_tip() -> None:
    """A link on the way may be named as tip; what lies beyond it is carried along, held."""
    chain, whole = chain_from_urdf(HANDED_ARM, "link4"), WholeRobot(HANDED_ARM)
    assert chain.joint_names == ("joint1", "joint2", "joint3", "joint4")
    q = np.array([0.3, -0.5, 1.0, -1.5])
    assert np.abs(KernelView(chain, q).torque() - whole.torque(chain.joint_names, q)).max() < 1e-12
    assert chain.mass.sum() == pytest.approx(pin.computeTotalMass(whole.model))  # the base is not in either


@pytest.mark.parametrize("seed", range(3))
def test_reach_radius(seed: int) -> None:
    """Nothing takes the tip farther from the first joint than the reach radius, which a pedestal leaves alone."""
    chain = chain_from_urdf(random_arm(seed), "flange")
    rng = np.random.default_rng(seed)
    tips = [KernelView(chain, rng.uniform(chain.lower, chain.upper)).tip[3] for _ in range(2000)]
    farthest = np.linalg.norm(np.array(tips) - chain.placement_p[0], axis=1).max()
    assert 0.5 * chain.reach_radius < farthest <= chain.reach_radius
    raised = chain_from_urdf(changed('xyz="0 0 0.0"', 'xyz="1 2 3"'))
    assert raised.placement_p[0].tolist() == [1, 2, 3]
    assert raised.reach_radius == chain_from_urdf(GOOD).reach_radius == pytest.approx(0.6, abs=1e-15)


def test_continuous_joints_turn_once() -> None:
    """A continuous joint turns from -pi to pi, whatever limits it is given."""
    for limit in ("", '<limit lower="5" upper="6"/>'):
        chain = chain_from_urdf(with_limit(limit, kind="continuous"))
        assert (chain.lower[0], chain.upper[0]) == (-math.pi, math.pi)


def test_side_joints_rest_nearest_zero() -> None:
    """A joint beside the path is held at the angle nearest zero within its limits."""
    side = with_limit('<limit lower="0.5" upper="2"/>').replace("</robot>", "")
    body = f'<link name="l2"><inertial><mass value="1"/><origin xyz="1 0 0"/>{INERTIA}</inertial></link>'
    swing = joint("swing", "l1", "l2", "revolute").replace(
        "</joint>", '<axis xyz="0 0 1"/><limit lower="0.25" upper="1"/></joint>'
    )
    chain = chain_from_urdf(side + body + swing + "</robot>", "l1")
    held = chain.placement_r[0] @ chain.com[0]
    assert held == pytest.approx([math.cos(0.25), math.sin(0.25), 0], abs=1e-15)


def test_axes_a_little_off_length_one() -> None:
    """An axis within 1e-3 of length 1 is taken for its direction alone."""
    exact, near = (chain_from_urdf(with_axis(axis)) for axis in ("0 0.6 0.8", "0 0.6005 0.8005"))
    q = np.array([0.7])
    assert np.abs(KernelView(exact, q).tip - KernelView(near, q).tip).max() < 1e-3
    assert np.abs(near.placement_r[0].T @ near.placement_r[0] - np.eye(3)).max() < 1e-15


def test_shapes() -> None:
    """Cylinders become capsules, spheres balls; boxes are left out and counted."""
    checked = check_urdf(
        robot(
            '<link name="l0"><collision><geometry><box size="1 1 1"/></geometry></collision></link>',
            '<link name="l1"><collision><origin xyz="1 2 3"/><geometry><sphere radius="0.5"/></geometry></collision>'
            "<collision/></link>",
            joint("j", "l0", "l1"),
        )
    )
    assert checked.ignored_shapes == 2
    assert [(s.link, s.xyz, s.length, s.radius) for s in checked.shapes] == [("l1", (1, 2, 3), 0, 0.5)]
    chain = chain_from_urdf(GOOD)
    assert chain.capsule_joint.tolist() == [0, 1, 2, 3]
    assert chain.capsule_radius.tolist() == [0.015] * 4
    assert np.linalg.norm(chain.capsule_b - chain.capsule_a, axis=1) == pytest.approx([0.06, 0.27, 0.16, 0.11])


def test_pairs_that_may_collide() -> None:
    """Links whose capsules touch or overlap with the arm straight are no pair; all others are."""
    # 0.06 m apart, radius 0.015 m: the first link is far enough from the third, as all are but neighbours.
    assert chain_from_urdf(GOOD).pairs.tolist() == [[0, 2], [0, 3], [1, 3]]
    # A link of 0.03 m lets the capsules of its neighbours touch exactly, one of 0.02 m overlap.
    for middle, pairs in ((0.02, []), (0.03, []), (0.030000002, [[0, 2]])):
        chain = chain_from_urdf(arm("PPP", (0.2, middle, 0.4 - middle)))
        assert chain.pairs.tolist() == pairs, middle


def test_payload_hangs_at_the_tip() -> None:
    """A payload adds its weight at the tip, and nothing else."""
    chain, loaded = chain_from_urdf(GOOD), chain_from_urdf(GOOD, payload_kg=2.0)
    q = np.array([0.2, -0.4, 0.6, 1.0, -1.1, 0.3])
    bare, full = KernelView(chain, q), KernelView(loaded, q)
    assert np.array_equal(bare.tip, full.tip)
    jacobian = ReferenceModel(chain).jacobian(q)
    added = jacobian[:3].T @ np.array([0, 0, 2.0 * 9.81])
    assert np.abs(full.torque() - bare.torque() - added).max() < 1e-12


def test_thousands_of_shapes_are_refused_at_once() -> None:
    """Each pair of them would be looked at: 48 s and 1.3 GB for 5,000."""
    ball = '<collision><geometry><sphere radius="0.001"/></geometry></collision>'
    urdf = (
        f'<robot name="r"><link name="a">{ball * 5000}</link><link name="b"/><joint name="j" type="revolute">'
        '<parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
        "</joint></robot>"
    )
    with pytest.raises(InputError, match="expected at most 300"):
        check_urdf(urdf)
