"""A worker: a child process of an evaluator that answers one candidate at a time.

Run as ``python -m mobo_core.evaluation.worker FD PARENT_PID`` by :class:`mobo_core.evaluation.pool.WorkerPool`;
FD is its end of a socket pair. A crash in here (a URDF that upsets a library, memory) costs this process alone.
"""

from __future__ import annotations

import signal
import sys
from multiprocessing.connection import Connection

from mobo_core.processes import die_with_parent


def main() -> None:
    """Answer candidates until the evaluator closes the connection."""
    descriptor, parent = (int(word) for word in sys.argv[1:3])
    die_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the evaluator decides
    connection = Connection(descriptor)
    from mobo_core.evaluation.answer import Answering
    from mobo_core.messages import decode, encode

    try:
        answering: Answering = connection.recv()
        answering.load()
        connection.send_bytes(b"ready")
        while True:
            candidate = decode("Candidate", connection.recv_bytes())
            connection.send_bytes(encode(answering.answer(candidate)))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        pass


if __name__ == "__main__":
    main()
