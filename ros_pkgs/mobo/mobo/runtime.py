"""What every node's main does: environment, signals, and errors as exit codes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

# A study stays on its own host unless its user says otherwise; read by the middleware when it starts.
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
# With a packet in twenty lost, a study takes half the time it takes with Fast DDS's defaults.
os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(Path(__file__).with_name("fastdds.xml")))

import rclpy  # noqa: E402
from rclpy.executors import Executor, SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy  # noqa: E402
from rclpy.signals import SignalHandlerOptions  # noqa: E402
from rclpy.utilities import try_shutdown  # noqa: E402

from mobo.shared_memory import clean_shared_memory  # noqa: E402
from mobo_core.coordination.arguments import check_arguments  # noqa: E402
from mobo_core.coordination.processes import die_with_parent  # noqa: E402
from mobo_core.coordination.stop import Stop  # noqa: E402
from mobo_core.errors import MoboError  # noqa: E402
from mobo_core.settings import Settings  # noqa: E402

# Set by the study supervisor for its children: "PID SIGNAL".
PARENT_VARIABLE = "MOBO_PARENT"


def qos(depth: int = 1000, *, latched: bool = False) -> QoSProfile:
    """Return a reliable profile; latched: who joins later gets the last ``depth`` messages."""
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


# Latched, so that a candidate sent while its evaluator is still being discovered is not lost.
CANDIDATES_QOS = qos(64, latched=True)
MESSAGES_QOS = qos()
STATUS_QOS = qos(1, latched=True)


def subscribe(node: Node, kind: type, topic: str, take: Callable[[bytes], None], profile: QoSProfile) -> None:
    """Have ``take`` called with the CDR bytes of each message: nothing is parsed before its size is known."""
    node.create_subscription(kind, topic, take, profile, raw=True)


def light_executor() -> Executor:
    """Return an executor that takes a message for a quarter of a SingleThreadedExecutor's time.

    It knows no guard conditions, and what a callback raises goes to the log, too; a task must not raise at all.
    """
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:  # rclpy of the first Jazzy releases
        return SingleThreadedExecutor()
    return EventsExecutor()


def run(
    name: str,
    help_text: str,
    options: type[Settings] | None,
    body: Callable[[Node, Executor, Stop], int],
    make_executor: Callable[[], Executor] = SingleThreadedExecutor,
) -> int:
    """Run a node: ``body`` gets the node, its executor and the stop flag, and returns the exit code.

    ``options`` are its parameters; None: it has none, but reads its command line itself.
    Errors that mobo raises on purpose become one line on stderr and their exit code.
    """
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(help_text)
        return 0
    executable = name.split("_")[0]
    try:
        check_arguments(executable, sys.argv[1:], None if options is None else options.model_fields)
    except MoboError as error:
        print(f"mobo {executable}: {error}", file=sys.stderr)
        return error.exit_code
    if parent := os.environ.pop(PARENT_VARIABLE, ""):
        pid, number = parent.split()
        die_with_parent(int(pid), int(number))
    stop = Stop()
    clean_shared_memory()
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rcl's own exceptions have no common base
        print(f"mobo {executable}: arguments not understood ({' '.join(str(error).split())[:300]})", file=sys.stderr)
        return 2
    node = executor = None
    try:
        node = Node(name)
        executor = make_executor()
        executor.add_node(node)
        return body(node, executor, stop)
    except MoboError as error:
        print(f"mobo {executable}: {error}", file=sys.stderr)
        return error.exit_code
    finally:
        if executor is not None:
            executor.shutdown()
        if node is not None:
            node.destroy_node()
        try_shutdown()
