"""The same arm with more and more in its hand: its reach stays, the torque grows."""

from __future__ import annotations

import mobo_core as mobo

arm = mobo.Design("PRRYPY", (0.06, 0.27, 0.16, 0.11, 0.0, 0.0))
for payload_kg in (0.0, 0.25, 0.5, 1.0):
    result = mobo.evaluate(arm, mobo.EvaluationSpec(payload_kg=payload_kg), objectives=("peak_torque",))
    print(f"{payload_kg:4.2f} kg  reach {result.reach:.2f} of {result.spec.n_voxels}, torque {result.torque:6.1f} N m, "
          f"strongest joint {result.extra['peak_torque']:5.2f} N m")  # fmt: skip
