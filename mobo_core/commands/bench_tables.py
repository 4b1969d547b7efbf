"""The tables that ``mobo bench evaluate`` prints."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mobo_core.bench.figures import Group, Row, SpecBench


def print_rows(bench: SpecBench) -> None:
    """Print a line an arm."""
    print(f"{bench['spec']}: ms a candidate, poses found and missed, share of the union, times the reference's speed")
    titles = f"{'found':>6} {'missed':>6} {'recall':>8} {'x ref':>6} {'torque':>15}  lengths in m"
    print(f"{'group':9} {'arm':9} {'ms':>7} {titles}")
    for row in bench["designs"]:
        lengths = ",".join(f"{length:.3g}" for length in row["lengths"])
        print(
            f"{row['group']:9.9} {row['name']:9} {row['ms']:7.1f} {row['found']:6} {_shown(row['missed'], 'd'):>6} "
            f"{_shown(row['recall'], '.2%'):>8} {_shown(row['ratio_reference'], '.0f'):>6} {_torque(row):>15}  "
            f"{lengths}"
        )
    print()


def _torque(row: Row) -> str:
    if row["torque_ratio"] is None or row["torque_se"] is None:
        return "-"
    return f"{row['torque_ratio'] - 1:+.2%} ± {row['torque_se']:.2%}"


# Lines of the table: title, and text of a group's figures.
Line = tuple[str, Callable[["Group"], str]]
_LINES: tuple[Line, ...] = (
    ("arms", lambda g: str(g["arms"])),
    ("ms a candidate, mean", lambda g: f"{g['mean_ms']:.1f}"),
    ("  median", lambda g: f"{g['median_ms']:.1f}"),
    ("  worst", lambda g: f"{g['worst_ms']:.1f}"),
    ("times the first spec's speed", lambda g: f"{g['speedup']:.2f}"),
    ("us a pose, mean", lambda g: f"{g['mean_us_per_pose']:.1f}"),
    ("iterations a pose, mean", lambda g: f"{g['iterations_per_pose']:.0f}"),
    ("poses reached", lambda g: f"{g['reached']:.1%}"),
    ("recall over all arms", lambda g: _shown(g["recall"], ".2%")),
    ("  mean of the arms", lambda g: _shown(g["mean_recall"], ".2%")),
    ("  least", lambda g: _shown(g["min_recall"], ".2%")),
    ("  poses missed", lambda g: "-" if g["missed"] is None else f"{g['missed']} of {g['found'] + g['missed']}"),
    ("  arms < 99.5 %, of >= 400 poses", lambda g: _shown(g["below"], "d")),
    ("  most missed, of < 400 poses", lambda g: _shown(g["most_missed"], "d")),
    ("times the reference, mean", lambda g: _shown(g["mean_ratio"], ".0f")),
    ("  least", lambda g: _shown(g["min_ratio"], ".0f")),
    ("torque to blind restarts, mean", lambda g: _shown(g["torque_ratio"], ".4f")),
    ("  most off 1", lambda g: _shown(g["torque_off"], ".2%")),
    ("  most off 1 by over two errors", lambda g: _shown(g["torque_beyond"], ".2%")),
)


def print_groups(benches: list[SpecBench]) -> None:
    """Print the groups' figures side by side, a line a figure; what was not measured is left out."""
    columns = [(bench["spec"], name, group) for bench in benches for name, group in bench["groups"].items()]
    widths = [max(len(spec), len(name), 12) for spec, name, _ in columns]
    if len(benches) > 1:
        print(_line("spec", [spec for spec, _, _ in columns], widths))
    print(_line("CPU time, one thread", [name for _, name, _ in columns], widths))
    for title, text in _LINES:
        texts = [text(group) for _, _, group in columns]
        left_out = set(texts) == {"-"} or (len(benches) == 1 and title.startswith("times the first"))
        if not left_out:
            print(_line(title, texts, widths))


def _line(title: str, texts: list[str], widths: list[int]) -> str:
    return f"{title:32}" + "".join(f" {text:>{width}}" for text, width in zip(texts, widths, strict=True))


def _shown(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)
