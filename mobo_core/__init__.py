"""mobo: which robot arm to build. The core: works on files and arrays, knows nothing of ROS."""

from mobo_core.version import __version__

__all__ = ["__version__"]
