"""A study in this process: sixty arms, the front among them, and a report."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import mobo_core as mobo

if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp(prefix="mobo-"))
    settings = mobo.StudySettings(n_startup_trials=20, seed=1)
    study = mobo.run_study(settings, n_trials=60, bag=folder / "sixty", workers=2)
    for row in mobo.study_table(study).useful_front:
        print(f"{row.joints}  reach {row.reach:5.2f}  torque {row.torque:5.1f} N m  lengths {row.lengths} m")
    mobo.report(study, folder / "report")
    print(f"{study}\nreport: {folder / 'report' / 'index.html'}")
