"""A design as URDF, put together from one xacro macro a joint."""

from __future__ import annotations

from pathlib import Path
from xml.dom.minidom import parseString
from xml.sax.saxutils import quoteattr

import xacro

from mobo_core.design.design import Design
from mobo_core.design.joints import DEFAULT_LETTERS, JOINTS, built_types
from mobo_core.design.numbers import Several, middle, of_joint
from mobo_core.design.space import DesignSpace
from mobo_core.errors import StudyError
from mobo_core.resources import xacro_folder

BASE_LINK = "base_link"
MOUNT_LINK = "mount"
TIP_LINK = "tool"


def to_urdf(design: Design, space: DesignSpace) -> str:
    """Return the URDF of ``design`` as text; masses, radius and limits come from ``space``.

    The same design and space give the same text on every machine: xacro computes in Python floats with
    + - * / alone, and writes the shortest decimal that reads back as the same float.

    Raises:
        StudyError: the xacro macros are missing or broken.
    """
    offsets = (0.0, *design.lengths)
    mounted = is_mounted(design)
    calls = [mount_call(repr(design.base_height), repr(design.base_tilt))] if mounted else []
    calls += [
        joint_call(space, joint, i, repr(offset), repr(length), repr(center), mounted=mounted)
        for i, (joint, offset, length, center) in enumerate(
            zip(design.joints, offsets[:-1], design.lengths, centers_of(design, space), strict=True), start=1
        )
    ]
    try:
        calls.append(tool_call(len(design.joints), repr(offsets[-1])))
        document = parseString(arm_source(design.name, space, calls, design.joints))
        xacro.process_doc(document)
    except Exception as error:
        raise StudyError(f"xacro of {design.name}: {error}") from error
    text: str = document.toprettyxml(indent="  ")
    return text


def is_mounted(design: Design) -> bool:
    """Return whether the arm stands elsewhere than upright at the origin: then it has a mount."""
    return design.base_height != 0.0 or design.base_tilt != 0.0


def centers_of(design: Design, space: DesignSpace) -> tuple[float, ...]:
    """Return the middle of each joint's range in rad."""
    own = space.joint_center
    return design.joint_centers or (tuple(map(middle, own)) if isinstance(own, tuple) else (own,) * len(design.joints))


def mount_call(height: str, tilt: str) -> str:
    """Return the call of the macro of the mount."""
    return f'<xacro:mount height="{height}" tilt="{tilt}"/>'


def joint_call(
    space: DesignSpace, joint: str, index: int, offset: str, length: str, center: str, *, mounted: bool = False
) -> str:
    """Return the call of the macro of joint number ``index``, from 1; offset, length and center as xacro reads them.

    Before it stand the properties of this joint alone.
    """
    macro, parent = JOINTS[joint].xacro, MOUNT_LINK if mounted and index == 1 else _link(index - 1)
    own = {name: of_joint(value, index - 1) for name, value in _properties(space).items() if isinstance(value, tuple)}
    before = f'{_set(own)}<xacro:property name="center" value="{center}"/>\n'
    return f'{before}<xacro:{macro} index="{index}" parent="{parent}" offset="{offset}" length="{length}"/>'


def tool_call(index: int, offset: str) -> str:
    """Return the call of the macro of the tool at the end of link number ``index``."""
    return f'<xacro:tool parent="{_link(index)}" offset="{offset}"/>'


def _link(index: int) -> str:
    return f"link_{index}" if index else BASE_LINK


def arm_source(name: str, space: DesignSpace, calls: list[str], joints: str = "") -> str:
    """Return the xacro document that calls these macros, one after the other, on a base.

    The macros of the default types are all at hand, those of others if they are among ``joints`` or in the space.
    """
    lines = [f'<robot name="{name}" xmlns:xacro="http://www.ros.org/wiki/xacro">']
    lines += [
        f"<xacro:include filename={quoteattr(str(file))}/>" for file in _macro_files(space.letters + joints)
    ]
    lines.append(_set({name: of_joint(value, 0) for name, value in _properties(space).items()}))
    return "\n".join([*lines, "<xacro:base/>", *calls, "</robot>"])


def _properties(space: DesignSpace) -> dict[str, Several]:
    return {
        "limit": space.joint_limit,
        "motor_mass": space.motor_mass,
        "motor_radius": space.motor_radius,
        "motor_length": space.motor_length,
        "radius": space.link_radius,
        "density": space.link_density,
        "slide_stroke": space.slide_stroke,
        "slide_radius": space.slide_radius,
    }


def _set(properties: dict[str, float]) -> str:
    return "".join(f'<xacro:property name="{name}" value="{value!r}"/>\n' for name, value in properties.items())


def _macro_files(letters: str) -> list[Path]:
    folder = xacro_folder()
    names = ("common", *sorted(JOINTS[letter].xacro for letter in DEFAULT_LETTERS))
    files = [folder / f"{name}.xacro" for name in names]
    others = [joint.file or folder / f"{joint.xacro}.xacro" for joint in built_types(letters)]
    return list(dict.fromkeys([*files, *others]))
