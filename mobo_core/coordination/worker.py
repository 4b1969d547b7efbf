"""A worker: a child process of an evaluator that answers one candidate at a time.

Run as ``python -m mobo_core.coordination.worker FD PARENT_PID MEMORY_MB`` by
:class:`mobo_core.coordination.pool.WorkerPool`; FD is its end of a socket pair, MEMORY_MB its limit, 0 for none.
A crash in here (a URDF that upsets a library, memory) costs this process alone.
"""

from __future__ import annotations

import json
import resource
import signal
import sys
from multiprocessing.connection import Connection

from mobo_core.coordination.processes import die_with_parent


def main() -> None:
    """Answer candidates until the evaluator closes the connection."""
    descriptor, parent, memory_mb = (int(word) for word in sys.argv[1:4])
    die_with_parent(parent)
    if memory_mb:
        resource.setrlimit(resource.RLIMIT_DATA, (memory_mb * 10**6, memory_mb * 10**6))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the evaluator decides
    connection = Connection(descriptor)
    from mobo_core.coordination.answer import Answering
    from mobo_core.messages import Candidate, Evaluation, decode, encode

    try:
        answering: Answering = connection.recv()
        connection.send_bytes(json.dumps(answering.load()).encode())
        while True:
            candidate = decode(Candidate, connection.recv_bytes())
            try:
                answer = encode(answering.answer(candidate))
            except MemoryError:  # on the way out of another one, or for the message itself
                answer = encode(answering.refusal(candidate, Evaluation.FAILED, "MemoryError"))
            connection.send_bytes(answer)
    except (EOFError, BrokenPipeError, ConnectionResetError):
        pass


if __name__ == "__main__":
    main()
