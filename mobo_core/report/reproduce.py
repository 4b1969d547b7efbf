"""How a study is run again: a command, and the files it names."""

from __future__ import annotations

import shlex

import yaml

from mobo_core.search.study import StudySettings
from mobo_core.settings import Settings

SPACE, SPEC = "space.yaml", "spec.yaml"
_OPTIONS = ("sampler", "seed", "in_flight", "n_startup_trials")


def command(settings: StudySettings, n_trials: int) -> str:
    """Return the command that runs a study of these settings again, in a folder with :func:`files`."""
    values = {"study_name": "again", "n_trials": max(n_trials, 1)}
    values |= {name: getattr(settings, name) for name in _OPTIONS}
    values |= {"objectives": ",".join(settings.objectives), "space": SPACE, "spec": SPEC}
    parameters = " ".join(f"-p {shlex.quote(f'{name}:={value}')}" for name, value in values.items())
    return f"ros2 run mobo study --ros-args {parameters}"


def files(settings: StudySettings) -> dict[str, str]:
    """Return the files that the command reads, by name."""
    return {SPACE: _yaml("space", settings.space), SPEC: _yaml("spec", settings.spec)}


def _yaml(kind: str, settings: Settings) -> str:
    text: str = yaml.safe_dump(settings.to_dict(), sort_keys=False, default_flow_style=None)
    return f"# The {kind} of the study, all of it.\n{text}"
