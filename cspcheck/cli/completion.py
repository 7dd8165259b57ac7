"""``cspcheck completion SHELL``: what a shell needs to complete our command lines."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

SHELLS = ("bash", "zsh", "fish")


@click.command(short_help="Print the completion script for a shell.")
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> None:
    """Print the completion script for a shell.

    For bash, put `eval "$(cspcheck completion bash)"` into ~/.bashrc; for zsh, `eval "$(cspcheck completion zsh)"` into
    ~/.zshrc; for fish, `cspcheck completion fish > ~/.config/fish/completions/cspcheck.fish`.
    """
    from cspcheck.cli import front_door
    from cspcheck.cli.streams import StandardOutput

    completion = get_completion_class(shell)
    assert completion is not None
    StandardOutput().write(completion(front_door, {}, "cspcheck", "_CSPCHECK_COMPLETE").source() + "\n")
