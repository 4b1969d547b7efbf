"""The paper's claims that one study can speak of: margins with their intervals; on the page with every statement."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from matplotlib.figure import Figure as Canvas

from mobo_core.bag.record import StudyRecord
from mobo_core.report.claims.check import check_claims
from mobo_core.report.claims.claim import Pair
from mobo_core.report.claims.evidence import of_study
from mobo_core.report.claims.show import claim_columns, interval_text, margin_text, numbers_text, statement
from mobo_core.report.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Checked
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import FAINT, plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.once import once
from mobo_core.report.table import StudyTable

# Colours that the colour-blind tell apart, and a marker each.
_LOOKS = {REPRODUCED: ("#0072b2", "o"), NOT_REPRODUCED: ("#d55e00", "X"), INCONCLUSIVE: ("#767676", "D")}
_FURTHEST = 1.05  # margins beyond are drawn there


@once
def claims_of(study: StudyRecord, table: StudyTable) -> list[Checked]:
    """Return the claims on studies of this number of joints, but for those that evaluate arms."""
    n = table.n_joints
    if n not in (6, 7) or not table.complete:
        return []
    evidence = of_study(study, table)
    return check_claims(Pair(evidence if n == 6 else None, evidence if n == 7 else None), evaluate=False)


def claims_figure(checked: Sequence[Checked], title: str = "") -> Canvas:
    """Return each claim's margin and interval, those that hold right of zero."""
    figure = Canvas(figsize=(9.6, 1.5 + 0.36 * len(checked)), layout="constrained")
    axes = figure.add_subplot()
    if title:
        axes.set_title(plain(title), loc="left", pad=12)
    parts = [one.outcome.deciding for one in checked]
    ends = [abs(end) for part in parts if part is not None for end in part.interval or ()]
    furthest = min(max([1.1 * end for end in ends] + [0.25]), _FURTHEST)
    axes.set(xlabel="margin of the deciding statement [share]", xlim=(-1.05 * furthest, 1.05 * furthest))
    axes.set_yticks(range(len(checked)), [f"{one.text}  {one.claim}" for one in checked], fontsize=8.5)
    axes.set_ylim(len(checked) - 0.4, -0.6)
    axes.axvline(0, color=FAINT, linewidth=1)
    axes.grid(True, axis="x")
    for verdict, (colour, marker) in _LOOKS.items():
        axes.plot([], [], marker, color=colour, label=verdict)
    for i, (one, part) in enumerate(zip(checked, parts, strict=True)):
        colour, marker = _LOOKS[one.outcome.verdict]
        if part is None or part.margin is None or part.interval is None:
            axes.text(0, i, " not known", va="center", color=FAINT, fontsize=8.5)
            continue
        low, high = (min(max(end, -furthest), furthest) for end in part.interval)
        axes.plot([low, high], [i, i], color=colour, linewidth=2.2, solid_capstyle="butt")
        axes.plot(min(max(part.margin, -furthest), furthest), i, marker, color=colour, markersize=6,
                  markeredgecolor="white", markeredgewidth=0.7)  # fmt: skip
    figure.legend(loc="outside lower right", ncols=3)
    return figure


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    checked = claims_of(study, table)
    if checked:
        yield Picture(claims_figure(checked, f"{study.name}: the paper's claims"))


def _data(study: StudyRecord, table: StudyTable) -> object:
    return [
        {
            "claim": one.claim, "text": one.text, "verdict": one.outcome.verdict,
            "parts": [
                {"text": statement(part), "verdict": part.verdict, "margin": margin_text(part),
                 "interval": interval_text(part), "numbers": numbers_text(part)}
                for part in one.outcome.parts
            ],
        }
        for one in claims_of(study, table)
    ]  # fmt: skip


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    return {"claims": claim_columns(claims_of(study, table))}


FIGURE = Figure(
    name="claims",
    heading="The paper's claims",
    caption="What the paper says of arms with so many joints, as this study shows it: margins with 95 % intervals, "
    "above 0 where a claim holds. What was hardly searched is inconclusive. mobo claims BAG6 BAG7 checks all.",
    draw=_draw,
    svg=True,
    view=View(_data, script_beside(__file__)),
    tables=_tables,
)
