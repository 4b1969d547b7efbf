"""Where the files lie that belong to mobo but are not Python: xacro macros and message definitions."""

from __future__ import annotations

import importlib.resources
from pathlib import Path


def _folder(name: str, in_checkout: str) -> Path:
    # A wheel carries the folder inside the package; an editable install finds it in the checkout.
    packaged = Path(str(importlib.resources.files("mobo_core"))) / name
    return packaged if packaged.is_dir() else packaged.parent.parent / in_checkout


def xacro_folder() -> Path:
    """Return the folder of the joint macros."""
    return _folder("xacro", "xacro")


def message_folder() -> Path:
    """Return the folder of the ``.msg`` definitions of the package ``mobo_msgs``."""
    return _folder("msg", "ros_pkgs/mobo_msgs/msg")
