"""What users install is the wheel: built from the sdist, unpacked away from the source tree, and run from there."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that holds what the wheel installs."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT)],
        check=True,
        capture_output=True,
    )
    (wheel,) = folder.glob("cspcheck-*.whl")
    target = folder / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(target)
    return target


def run(installed: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1", "PYTHONIOENCODING": "utf-8"}
    return subprocess.run(
        [sys.executable, "-m", "cspcheck", *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )


def test_the_wheel_holds_our_packages_their_data_and_the_examples(installed: Path) -> None:
    tops = {path.name for path in installed.iterdir() if path.suffix != ".dist-info"}

    assert tops == {"cspcheck"}
    for package in (".", "cspm", "checker", "codegen"):
        assert (installed / "cspcheck" / package / "py.typed").is_file()
    assert (installed / "cspcheck" / "cspm" / "parsing" / "grammar" / "cspm.lark").is_file()
    assert (installed / "cspcheck" / "specs" / "rov" / "rov.csp").is_file()


def test_an_installed_cspcheck_copies_and_checks_its_examples(installed: Path, tmp_path: Path) -> None:
    copied = run(installed, tmp_path, "examples", "producer_consumer", "--copy", str(tmp_path / "here"))
    assert copied.returncode == 0, copied.stderr

    (script,) = (tmp_path / "here").rglob("producer_consumer.csp")
    checked = run(installed, tmp_path, str(script))

    assert checked.returncode == 0, checked.stderr
    assert "6 pass, 1 fail, all as expected" in checked.stdout


def test_the_wheel_declares_the_command_and_the_pytest_plugin(installed: Path) -> None:
    (entries,) = installed.glob("cspcheck-*.dist-info/entry_points.txt")

    assert "cspcheck = cspcheck.__main__:main" in entries.read_text()
    assert "cspcheck = cspcheck.pytest_plugin" in entries.read_text()


def test_the_wheel_has_the_parse_table_of_its_grammar(installed: Path, tmp_path: Path) -> None:
    """So no user's first run imports Lark."""
    (tmp_path / "x.csp").write_text("P = STOP\nassert P :[deadlock free]\n")
    code = (
        "import sys; from cspcheck.cspm.script import load; load('x.csp'); "
        "from cspcheck.cspm.parsing import table; "
        "print('lark' in sys.modules, table.table() == table.from_json(table.compute(table.GRAMMAR.read_text())))"
    )
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1", "XDG_CACHE_HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, encoding="utf-8", check=True
    )

    assert done.stdout == "False True\n"
