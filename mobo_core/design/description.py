"""A design as URDF, put together from one xacro macro a joint."""

from __future__ import annotations

from pathlib import Path
from xml.dom.minidom import parseString
from xml.sax.saxutils import quoteattr

import xacro

from mobo_core.design.design import Design
from mobo_core.design.space import DesignSpace
from mobo_core.errors import StudyError
from mobo_core.resources import xacro_folder

_MACROS = {"R": "roll", "P": "pitch", "Y": "yaw"}

BASE_LINK = "base_link"
TIP_LINK = "tool"


def to_urdf(design: Design, space: DesignSpace) -> str:
    """Return the URDF of ``design`` as text; masses, radius and limits come from ``space``.

    The same design and space give the same text on every machine: xacro computes in Python floats with
    + - * / alone, and writes the shortest decimal that reads back as the same float.

    Raises:
        StudyError: the xacro macros are missing or broken.
    """
    try:
        document = parseString(_source(design, space))
        xacro.process_doc(document)
    except Exception as error:
        raise StudyError(f"xacro of {design.name}: {error}") from error
    text: str = document.toprettyxml(indent="  ")
    return text


def _source(design: Design, space: DesignSpace) -> str:
    folder: Path = xacro_folder()
    lines = [f'<robot name="{design.name}" xmlns:xacro="http://www.ros.org/wiki/xacro">']
    lines += [
        f"<xacro:include filename={quoteattr(str(folder / f'{name}.xacro'))}/>"
        for name in ("common", *sorted(_MACROS.values()))
    ]
    properties = {
        "limit": space.joint_limit,
        "motor_mass": space.motor_mass,
        "radius": space.link_radius,
        "density": space.link_density,
    }
    lines += [f'<xacro:property name="{name}" value="{value!r}"/>' for name, value in properties.items()]
    lines.append("<xacro:base/>")
    parent, offset = BASE_LINK, 0.0
    for i, (joint, length) in enumerate(zip(design.joints, design.lengths, strict=True), start=1):
        lines.append(
            f'<xacro:{_MACROS[joint]} index="{i}" parent="{parent}" offset="{offset!r}" length="{length!r}"/>'
        )
        parent, offset = f"link_{i}", length
    lines.append(f'<xacro:tool parent="{parent}" offset="{offset!r}"/>')
    lines.append("</robot>")
    return "\n".join(lines)
