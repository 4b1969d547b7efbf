"""Arms that reach far with weak motors and little mass: a study of three objectives."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import mobo_core as mobo

if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp(prefix="mobo-"))
    settings = mobo.StudySettings(
        objectives=("reach", "peak_torque", "mass"), n_startup_trials=20, spec=mobo.EvaluationSpec(poses_per_voxel=5)
    )
    study = mobo.run_study(settings, n_trials=40, bag=folder / "three", workers=2)
    for row in mobo.study_table(study).useful_front:
        print(f"{row.joints}  reach {row.reach:5.2f}  {dict(row.extra)}")
