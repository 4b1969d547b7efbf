"""What one arm is worth: how much of the workspace it reaches, and the torque it takes."""

from __future__ import annotations

import mobo_core as mobo

arm = mobo.Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05))  # lengths in m; link i follows joint i
result = mobo.evaluate(arm, mobo.EvaluationSpec(ik_mode="complete", restarts=31, iterations=10))
print(result)
best = max(range(len(result.voxel_reach)), key=lambda voxel: result.voxel_reach[voxel])
centre = result.spec.voxel_centres()[best]
print(f"best voxel: centre {centre.round(3).tolist()} m, {result.voxel_reach[best]:.0%} of its poses reached, "
      f"{result.voxel_torque[best]:.2f} N m on average")  # fmt: skip
