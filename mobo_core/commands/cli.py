"""The ``mobo`` command: works on files and bags, needs no ROS."""

# PYTHON_ARGCOMPLETE_OK
from __future__ import annotations

import argparse
import contextlib
import importlib
import os
import sys
from collections.abc import Sequence

from mobo_core.commands.parsing import Parser
from mobo_core.errors import MoboError, visible
from mobo_core.version import __version__

# One module of mobo_core.commands each, in the order --help lists them.
VERBS = (
    "evaluate", "report", "claims", "compare", "verify", "atlas", "arms", "size", "export", "bag", "example",
    "bench", "simulate", "doctor", "completion",
)  # fmt: skip

FIRST = """\
Which robot arm to build. To begin with:

  ros2 run mobo study --ros-args -p study_name:=first -p n_trials:=300
  mobo report bags/first -o report      # its front, pictures, a page
  mobo evaluate bags/first --trial 10   # one arm of it, joint by joint
  mobo export urdf bags/first --top 3 -o arms
  mobo verify bags/first                # all of it again, to the bit

All commands: mobo --help; one of them: mobo report --help"""


def parser(verb: str = "") -> argparse.ArgumentParser:
    """Return the parser of all verbs, or of the one named: the others need not be imported then.

    A module of :mod:`mobo_core.commands` offers ``add(verbs)``: it adds a parser whose default ``run`` is a
    function from the parsed arguments to the exit code.
    """
    top = Parser(
        prog="mobo",
        description="Which robot arm to build: evaluate arms, and read, check and report recorded studies.",
        epilog="Studies are run by ROS 2 nodes: ros2 run mobo study --help",
    )
    top.add_argument("--version", action="version", version=f"mobo {__version__}")
    verbs = top.add_subparsers(dest="verb", metavar="VERB", required=True, parser_class=Parser)
    for name in [verb] if verb in VERBS else VERBS:
        importlib.import_module(f"mobo_core.commands.{name}").add(verbs)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb and return its exit code: 0 good, 1 the answer is no, 2 bad input."""
    words = sys.argv[1:] if arguments is None else arguments
    if "_ARGCOMPLETE" in os.environ:  # a shell asks what may come next
        with contextlib.suppress(ImportError):
            import argcomplete

            argcomplete.autocomplete(parser())
    if not words:
        print(FIRST)
        return 0
    top = parser(words[0])
    args = top.parse_args(arguments)
    try:
        code: int = args.run(args)
        sys.stdout.flush()
        return code
    except MoboError as error:
        print(f"mobo {args.verb}: {error}", file=sys.stderr)
        return error.exit_code
    except (MemoryError, RecursionError) as error:
        what = "not enough memory" if isinstance(error, MemoryError) else "nested too deeply"
        print(f"mobo {args.verb}: {what}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output has enough
        _no_more_output()
        return 0
    except OSError as error:  # such as a full disk behind our output, or no more files to open
        _no_more_output()
        where = f"{error.filename}: " if error.filename is not None else ""
        print(visible(f"mobo {args.verb}: {where}{error.strerror or error}"), file=sys.stderr)
        return 1


def _no_more_output() -> None:
    """Let what waits to be printed go nowhere, without a word at the interpreter's end."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
