"""The version of mobo."""

__version__ = "0.1.0"
