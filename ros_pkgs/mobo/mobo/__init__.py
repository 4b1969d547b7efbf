"""The ROS 2 nodes of mobo: thin shells around mobo_core."""

import signal as _signal
import sys as _sys
from pathlib import Path as _Path

# A node takes seconds to load: Ctrl-C meanwhile shall end it, not print where it was. Its main takes over later.
if _sys.argv[0] == "-m" or _Path(_sys.argv[0]).parts[-3:-1] == ("lib", "mobo"):
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    # Blocked by the stand-in for `ros2` until here.
    _signal.pthread_sigmask(_signal.SIG_UNBLOCK, {_signal.SIGINT})
