"""mobo: which robot arm to build. The core: works on files and arrays, knows nothing of ROS."""

__version__ = "0.1.0"
