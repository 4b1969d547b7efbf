"""Design spaces by name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mobo_core.design.space import DesignSpace
from mobo_core.errors import InputError

# desk: an arm for a desk of DYNAMIXEL XM540-W270 servos, 165 g, 33.5 x 58.5 x 44 mm, 10.6 N m at 12 V
# (https://emanual.robotis.com/docs/en/dxl/x/xm540-w270). The rest is chosen: motor bodies 40 mm
# wide and 50 mm long with their half-balls; links of 50 mm or more, so that servos
# have room side by side; plastic or aluminium tubes of 25 mm with their brackets, 0.25 kg/m.
SPACES: dict[str, dict[str, object]] = {
    "paper": {},
    "desk": {
        "total_length": 0.6,
        "min_length": 0.05,
        "max_length": 0.3,
        "last_link": "bounded",
        "zero_lengths": "never",
        "joint_limit": "135deg",
        "motor_mass": 0.165,
        "motor_radius": 0.02,
        "motor_length": 0.01,
        "link_radius": 0.0125,
        "link_density": 500.0,
    },
}


def load_space(name_or_path: str, over: Mapping[str, object] | None = None) -> DesignSpace:
    """Return a preset by its name, or read a YAML file; the settings in ``over`` win over what it says.

    Raises:
        InputError: neither a preset nor a readable file, a field that does not fit, or a total that only a last link
            longer than all others could make.
    """
    if name_or_path in SPACES:
        fields = SPACES[name_or_path]
    elif Path(name_or_path).exists():
        read = DesignSpace.from_yaml(name_or_path)
        fields = {name: getattr(read, name) for name in read.model_fields_set}
    else:
        expected = f"{', '.join(SPACES)} or a YAML file"
        raise InputError(f"no preset or file {name_or_path!r}", where="space", expected=expected)
    space = DesignSpace.of({**fields, **(over or {})}, where=f"space {name_or_path}")
    if space.longest_total < space.total_ends[1] - 1e-9:
        n = space.n_joints
        expected = f"at most {space.longest_total:.9g} m, which {n} links of max_length {space.max_length:g} m make"
        raise InputError(f"total_length {space.total_text} m", where=f"space {name_or_path}", expected=expected)
    return space
