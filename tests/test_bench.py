"""``mobo bench``: what it refuses."""

from __future__ import annotations

import pytest

from mobo_core.commands.cli import main


@pytest.mark.parametrize(
    ("design", "words"),
    [
        ("YPPPPPPPPPPPP:" + ",".join(["0.05"] * 13), "design YPPPPPPPPPPPP: n_joints = 13; expected"),
        ("YPR:0,0,0", "design YPR: total_length = 0.0; expected"),
        ("YPR:0.1", "1 lengths for 3 joints"),
        ("YPR", "--design: 'YPR'; expected NAME:l1,l2"),
    ],
)
def test_designs_that_cannot_be_measured(design: str, words: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A bad design is told in one line, with exit code 2, before any is measured."""
    assert main(["bench", "evaluate", "--design", "YPR:0.2,0.2,0.2", "--design", design]) == 2
    out, err = capsys.readouterr()
    assert words in err and err.count("\n") == 1 and not out
