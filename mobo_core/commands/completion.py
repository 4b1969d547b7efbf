"""``mobo completion``: what makes Tab complete ``mobo`` in a shell."""

from __future__ import annotations

import argparse

from mobo_core.commands.parsing import Verbs


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "completion",
        help="Tab completion for bash or zsh",
        description="Print what a shell has to evaluate so that Tab completes mobo's verbs, options and files.\n"
        "`source install/setup.bash` (or setup.zsh, after compinit) does so already.",
        epilog='examples:\n  eval "$(mobo completion bash)"     # in ~/.bashrc, for instance\n'
        '  eval "$(mobo completion zsh)"      # in ~/.zshrc, after compinit',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("shell", choices=["bash", "zsh"], help="the shell")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the shell's code."""
    from argcomplete.shell_integration import shellcode

    print(shellcode(["mobo"], shell=args.shell))
    return 0
