"""A recorded study: what is in its bag, whether that is true, and its trials as a table."""

from __future__ import annotations

import sys
from pathlib import Path

import mobo_core as mobo

if __name__ == "__main__":
    sample = Path(__file__).parents[1] / "bags" / "sample" / "paper_6"
    study = mobo.read_study(sys.argv[1] if len(sys.argv) > 1 else sample)
    found = mobo.verify(study, sample=10)
    print(f"{study}: {'true' if not found.faults else found.faults[0]}")
    table = mobo.study_table(study)
    print(table)
    print(table.to_pandas().sort_values("reach", ascending=False).head(5).to_string(index=False))
