"""The files by which build services use the command name what there is."""

import re
import shlex
from pathlib import Path

import pytest
from click import Option

from cspcheck.cli import VERBS, front_door

ROOT = Path(__file__).resolve().parents[2]


def commands() -> list[str]:
    found = re.findall(r"entry: (cspcheck.*)", (ROOT / ".pre-commit-hooks.yaml").read_text())
    action = (ROOT / "action.yml").read_text().replace("$CSP_FILES $CSP_OPTIONS", "x.csp")
    found += re.findall(r"(cspcheck check .*?) \|\|", action)
    page = (ROOT / "docs" / "continuous-integration.md").read_text()
    found += re.findall(r"- (cspcheck specs.*)", page)
    return found


@pytest.mark.parametrize("command", commands())
def test_every_option_is_there(command: str) -> None:
    _, *words = shlex.split(command)
    verb = words[0] if words[0] in VERBS else "check"
    known = front_door.get_command(None, verb)  # type: ignore[arg-type]
    assert known is not None
    options = {name for p in known.params if isinstance(p, Option) for name in (*p.opts, *p.secondary_opts)}
    assert {word for word in words if word.startswith("-")} <= options


def test_there_are_some() -> None:
    assert len(commands()) == 6


def test_inputs_of_the_action_are_not_run() -> None:
    script = (ROOT / "action.yml").read_text().split("run: |", 1)[1]
    assert "${{" not in script


def test_no_address_is_made_up() -> None:
    """The repository has none that could be named, and one that only looks so would be somebody else's."""
    files = [*(ROOT / "docs").rglob("*.md"), *(ROOT / "editors").rglob("*.json"), *ROOT.glob("*.md")]
    made_up = re.compile(
        r"OWNER/|example\.(invalid|com|org)|your-?(name|org)|(github|gitlab)\.com/[^/\s]*/?cspcheck", re.I
    )
    found = [
        path.name for path in files if "node_modules" not in path.parts and made_up.search(path.read_text("utf-8"))
    ]

    assert len(files) > 40
    assert found == []
