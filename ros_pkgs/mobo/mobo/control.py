"""The control node: hands one command to the optimizer of its namespace and says what became of it."""

from __future__ import annotations

import argparse
import getpass
import os
import socket
import sys
from typing import NoReturn

from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from std_srvs.srv import Trigger

from mobo.runtime import run
from mobo_core.commands.arm_arguments import parse_lengths
from mobo_core.coordination.stop import Stop
from mobo_core.design.joints import joint_letters
from mobo_core.errors import InputError, StudyError
from mobo_msgs.srv import Enqueue

HELP = f"""\
usage: ros2 run mobo control pause|resume|stop|status
       ros2 run mobo control enqueue --joints ORDER --lengths L1,L2,...

Command the optimizer of this namespace. What it accepts is in the bag before it takes effect.

  pause    finish what is sent out, ask for nothing new; lasts until resume, even if the optimizer is restarted
  resume   end a pause
  stop     end the optimizer in order, as Ctrl-C does
  status   print how the study stands, a line of JSON
  enqueue  make this arm the next trial: joint order in {joint_letters()};
           lengths in m

Exit code 0: done; 1: refused, or no optimizer answers; 2: bad input.

examples:
  ros2 run mobo control pause
  ros2 run mobo control enqueue --joints YPPYPY --lengths 0.05,0.25,0.2,0.05,0,0.05
  ros2 run mobo control status --ros-args -r __ns:=/left"""

_COMMANDS = ("pause", "resume", "stop", "status", "enqueue")
_DISCOVERY_S = 10.0
_ANSWER_S = 10.0


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise InputError(message, where="arguments", expected="what --help shows")


def request(words: list[str]) -> tuple[str, type, object]:
    """Return (service, its type, the request) that the words on the command line mean.

    Raises:
        InputError: they mean none.
    """
    parser = _Parser(add_help=False)
    parser.add_argument("command", choices=_COMMANDS)
    parser.add_argument("--joints")
    parser.add_argument("--lengths")
    args = parser.parse_args(words)
    if args.command != "enqueue":
        if args.joints is not None or args.lengths is not None:
            raise InputError("an arm given", where=args.command, expected="none; enqueue takes one")
        return args.command, Trigger, Trigger.Request()
    if not args.joints or args.lengths is None:
        raise InputError("no arm given", where="enqueue", expected="--joints and --lengths")
    source = f"{getpass.getuser()}@{socket.gethostname()}, pid {os.getpid()}"
    return "enqueue", Enqueue, Enqueue.Request(
        joints=args.joints.upper(), lengths=parse_lengths(args.lengths), source=source
    )


def _body(node: Node, executor: Executor, stop: Stop) -> int:
    service, kind, message = request(remove_ros_args(sys.argv)[1:])
    client = node.create_client(kind, service)
    where = f"namespace {node.get_namespace()}"
    if not client.wait_for_service(_DISCOVERY_S):
        raise StudyError(f"no optimizer in {where} (waited {_DISCOVERY_S:g} s)")
    future = client.call_async(message)
    executor.spin_until_future_complete(future, _ANSWER_S)
    if not future.done():
        raise StudyError(f"the optimizer in {where} has not answered within {_ANSWER_S:g} s; `control status` tells")
    reply = future.result()
    accepted = reply.success if kind is Trigger else reply.accepted
    if not accepted:
        error = InputError if kind is Enqueue and reply.bad_input else StudyError
        raise error(f"{service} refused: {reply.message}")
    print(reply.message)
    return 0


def main() -> int:
    """Run the node; return its exit code."""
    return run("control", HELP, None, _body)


if __name__ == "__main__":
    sys.exit(main())
