"""URDFs from macros that xacro has expanded before."""

from __future__ import annotations

import random
import shutil
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobo_core.design import Design, DesignSpace, description, to_urdf
from mobo_core.design.prepared import PreparedXacro
from mobo_core.errors import StudyError
from mobo_core.resources import xacro_folder

lengths = st.sampled_from([0.0, -0.0, 5e-324, 1e-9, 1e-5, 0.1, 1e16, 1e300]) | st.floats(0, 0.3)
spaces = st.builds(
    DesignSpace,
    joint_limit=st.floats(1e-3, 6), motor_mass=st.floats(1e-3, 1e4), link_radius=st.sampled_from([1e-4, 0.015, 1.0]),
    link_density=st.sampled_from([1e-3, 1000.0, 345.12345]),
)  # fmt: skip


@st.composite
def designs(draw: st.DrawFn, n: int) -> Design:
    joints = draw(st.text("RPY", min_size=n, max_size=n))
    return Design(joints, tuple(draw(st.lists(lengths, min_size=n, max_size=n))))


@pytest.mark.slow
@given(st.integers(1, 12), spaces, st.data())
@settings(max_examples=12, deadline=None)
def test_equals_plain_xacro(n: int, space: DesignSpace, data: st.DataObject) -> None:
    """For any design and space the text is that of plain xacro, to the byte, also when its macros are known."""
    prepared = PreparedXacro(space)
    for design in data.draw(st.lists(designs(n), min_size=1, max_size=4)):
        assert prepared.to_urdf(design) == to_urdf(design, space)
    assert not prepared.plain


def test_soon_without_xacro(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a hundred designs, others of the space are described without xacro, and alike."""
    draw, space = random.Random(0), DesignSpace(n_joints=4)

    def design() -> Design:
        return Design("".join(draw.choices("RPY", k=4)), tuple(draw.random() for _ in range(4)))

    prepared = PreparedXacro(space)
    for _ in range(150):
        prepared.to_urdf(design())
    others = [design() for _ in range(10)]
    expected = [to_urdf(other, space) for other in others]
    monkeypatch.setattr("xacro.process_doc", None)
    assert [prepared.to_urdf(other) for other in others] == expected


def edited(folder: Path, monkeypatch: pytest.MonkeyPatch, old: str, new: str) -> None:
    """Use macros in which ``old`` is ``new``, in common.xacro."""
    shutil.copytree(xacro_folder(), folder)
    common = folder / "common.xacro"
    text = common.read_text()
    assert old in text
    common.write_text(text.replace(old, new))
    monkeypatch.setattr(description, "xacro_folder", lambda: folder)


MASS = '<mass value="${mass}"/>'


@pytest.mark.parametrize(
    ("old", "new", "plain"),
    [
        (MASS, '<mass value="${2 * mass}"/>', False),
        (MASS, '<mass value="${mass if length > 0.2 else -mass ** 2 % 7 + python.abs(length // 0.01)}"/>', False),
        (MASS, '<mass value="${max(mass, offset)} ${[length, offset][length == offset]} ${not length}"/>', False),
        (MASS, '<mass value="${sin(length)}"/>', True),
        (MASS, '<mass value="${round(length, 2)}"/>', True),
        (MASS, "<mass value=\"${'%.3f' % length}\"/>", True),
        (MASS, '<mass value="${str(length)[:4]}"/>', True),
        (MASS, '<mass value="${len(str(length))}"/>', True),
        (MASS, '<mass value="${dict([(0.1, 1)]).get(length, 2)}"/>', True),
        # Properties that one joint hands on to the next.
        (MASS, '<mass value="${before}"/><xacro:property name="before" value="${length}" scope="global"/>', True),
        ('<link name="base_link"/>', '<xacro:property name="mass" value="1" scope="global"/>', False),
        ("</link>\n  </xacro:macro>", "</link><!-- the end --></xacro:macro>", None),
    ],
)
def test_edited_macros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, old: str, new: str, plain: bool | None) -> None:
    """Macros that a user edits give what plain xacro makes of them; xacro does what cannot be prepared."""
    edited(tmp_path / "xacro", monkeypatch, old, new)
    if "before" in new:
        common = tmp_path / "xacro" / "common.xacro"
        start = '<xacro:property name="before" value="0"/>\n  <xacro:macro name="base">'
        common.write_text(common.read_text().replace('<xacro:macro name="base">', start))
    space, draw = DesignSpace(), random.Random(1)
    prepared = PreparedXacro(space)
    for _ in range(8):
        design = Design(
            "".join(draw.choices("RPY", k=4)), tuple(draw.choice([0.0, 0.1, draw.random()]) for _ in "1234")
        )
        assert prepared.to_urdf(design) == to_urdf(design, space)
    assert plain is None or prepared.plain == plain


def test_many_conditions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A macro that takes many ways through its conditions is left to xacro."""
    steps = "".join(f'<step over="${{1 if length > {i} else 2}}"/>' for i in range(12))
    edited(tmp_path / "xacro", monkeypatch, MASS, MASS + steps)
    prepared = PreparedXacro(DesignSpace())
    for i in range(12):
        assert prepared.plain == (i > 8)
        assert prepared.to_urdf(Design("R", (i,))) == to_urdf(Design("R", (i,)), DesignSpace())


def test_broken_macros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Macros that xacro cannot expand are the error they are without preparation."""
    edited(tmp_path / "xacro", monkeypatch, MASS, '<mass value="${1 / (length - 0.25)}"/>')
    prepared = PreparedXacro(DesignSpace())
    good = Design("RP", (0.1, 0.2))
    assert prepared.to_urdf(good) == to_urdf(good, DesignSpace())
    with pytest.raises(StudyError, match="xacro of PP: float division by zero"):
        prepared.to_urdf(Design("PP", (0.1, 0.25)))
