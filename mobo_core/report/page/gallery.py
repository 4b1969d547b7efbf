"""A page with real arms: each drawn as it stands straightened, with its order, lengths and three evaluations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from mobo_core.arms.real import RealArm
from mobo_core.arms.worth import Worth
from mobo_core.design.joints import JOINTS
from mobo_core.report.page import markup

_HEAD = (
    "arm", "maker", "joints", "length [m]", "masses", "own reach", "own torque [N m]", "scaled reach",
    "scaled torque [N m]", "twin reach", "twin torque [N m]", "source", "licence",
)  # fmt: skip
_SIDE = 150  # of a drawing, px


def gallery_page(arms: Sequence[tuple[RealArm, Worth]], n_voxels: int, missing: Sequence[str]) -> str:
    """Return the page; ``missing`` are arms looked for and not found in any source."""
    order = sorted(arms, key=lambda each: -each[1].scaled.reach)
    rows = [
        [
            arm.name, arm.maker, arm.order.joints if arm.order else "", f"{arm.length:.2f}",
            "estimated" if "masses" in arm.estimated else "source",
            *(text for result in vars(found).values() for text in (f"{result.reach:.1f}", f"{result.torque:.0f}")),
            " ".join(arm.source[key] for key in ("package", "version") if key in arm.source) or arm.source["path"],
            arm.licence,
        ]
        for arm, found in order
    ]  # fmt: skip
    body = [
        f"<header><h1>{len(arms)} real arms</h1>",
        f'<p class="sub">Reach is of {n_voxels} voxels. Own: the arm as it is, in a workspace as much larger than the '
        "paper's as it is longer than 0.6 m. Scaled: 0.6 m long, with the masses of the design space, its own offsets "
        "and limits. Twin: its joint order and the ratio of its lengths alone, in the design space. Hollow joints: no "
        "source says the arm's masses. Collision shapes are tubes between the joints, estimated for all.</p>",
        f'<p class="note">Named by the paper, in no source: {escape(", ".join(missing))}.</p></header><main>',
        markup.section("table", "By reach, scaled", [markup.table(_HEAD, rows, right=(3, *range(5, 11)))]),
        markup.section("drawn", "Straightened", ['<div class="gallery">', *(_card(*each) for each in order), "</div>"]),
        "</main>",
    ]
    style = (
        "<style>.gallery{display:grid;grid-template-columns:repeat(auto-fill,minmax(210px,1fr));gap:.8rem}"
        ".gallery figure{margin:0;border:1px solid var(--line);border-radius:8px;padding:.5rem}</style>"
    )
    return markup.html("Real arms", [style, *body])


def _card(arm: RealArm, found: Worth) -> str:
    order = arm.order
    assert order is not None
    lengths = " / ".join(f"{1e3 * length:.0f}" for length in order.lengths)
    off = f"{1e3 * order.offset:.0f} mm off the vertical"
    skew = f", axes up to {math.degrees(order.skew):.0f}° off right angles" if order.skew > 0.01 else ""
    words = (
        f"<b>{escape(f'{arm.maker} {arm.name}'.strip())}</b> {order.joints}<br>{lengths} mm up, {off}{skew}.<br>"
        f"Reach {found.own.reach:.1f} own, {found.scaled.reach:.1f} scaled, {found.twin.reach:.1f} twin."
    )
    return f"<figure>{_drawing(arm)}<figcaption>{words}</figcaption></figure>"


def _drawing(arm: RealArm) -> str:
    """Return the arm from the side on which it is widest, as a picture."""
    assert arm.order is not None
    _, origins, _ = arm.frames(np.array(arm.order.q))
    side = int(np.argmax(np.ptp(origins[:, :2], axis=0)))
    points = origins[:, [side, 2]] - origins[:, [side, 2]].mean(axis=0)
    scale = 0.42 * _SIDE / max(float(np.abs(points).max()), 1e-9)
    places = [(0.5 * _SIDE + scale * x, 0.5 * _SIDE - scale * z) for x, z in points.tolist()]
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    hollow = "masses" in arm.estimated
    dots = []
    for (x, y), letter in zip(places, arm.order.joints, strict=False):
        colour = JOINTS[letter].colour
        fill = "none" if hollow else colour
        dots.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{fill}" stroke="{colour}" stroke-width="2"/>')
    return (
        f'<svg viewBox="0 0 {_SIDE} {_SIDE}" role="img" aria-label="{escape(arm.name)}">'
        f'<polyline points="{line}" fill="none" stroke="currentColor" stroke-width="3"/>{"".join(dots)}</svg>'
    )
