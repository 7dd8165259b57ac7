"""What users install is the wheel: built from the sdist, unpacked away from the source tree, and run from there."""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from email import message_from_string
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def release(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist and the wheel that is built from it, once for all workers."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "release"
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not list(folder.glob("*.whl")):
            build(folder, tmp_path_factory)
    return folder


def build(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    # From a copy: building writes into the source tree, where another worker may be building at the same time.
    source = tmp_path_factory.mktemp("source") / ROOT.name
    own = shutil.ignore_patterns(".git", ".venv", ".*cache*", ".hypothesis", "__pycache__", "build", "*.egg-info")
    shutil.copytree(ROOT, source, symlinks=True, ignore=own)
    subprocess.run(
        [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(source)],
        check=True,
        capture_output=True,
    )


@pytest.fixture(scope="module")
def installed(release: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that holds what the wheel installs."""
    (wheel,) = release.glob("cspcheck-*.whl")
    target = tmp_path_factory.mktemp("site")
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
    for room in ("checker", "codegen", "cspm"):
        for path in (ROOT / room).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts and path.suffix not in (".pyc", ".pickle"):
                assert (installed / "cspcheck" / path.relative_to(ROOT)).is_file(), path
    assert (installed / "cspcheck" / "cspm" / "parsing" / "grammar" / "cspm.lark").is_file()
    assert (installed / "cspcheck" / "cspm" / "oz" / "reading" / "grammar" / "oz.lark").is_file()
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


def test_the_wheel_has_the_parse_tables_of_its_grammars(installed: Path, tmp_path: Path) -> None:
    """So no user's first run imports Lark."""
    (tmp_path / "x.csp").write_text("class C\n  chan a\nend\nassert C :[deadlock free]\n")
    code = (
        "import sys, cspcheck.cspm.oz; from cspcheck.cspm.script import load; load('x.csp'); "
        "from cspcheck.cspm.oz.reading.reader import OZ; from cspcheck.cspm.parsing import table as t; "
        "print('lark' in sys.modules, *(t.table(g) == t.from_json(t.compute(g.path.read_text(), g.starts, g.greedy))"
        " for g in (t.CSPM, OZ)))"
    )
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1", "XDG_CACHE_HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, encoding="utf-8", check=True
    )

    assert done.stdout == "False True True\n"


def test_the_description_of_a_release_leads_nowhere_wrong(installed: Path) -> None:
    """There, a link to another file of the repository would be dead."""
    (file,) = installed.glob("cspcheck-*.dist-info/METADATA")
    metadata = message_from_string(file.read_text(encoding="utf-8"))
    text = str(metadata.get_payload())

    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata["License-Expression"] == "BSD-3-Clause"
    assert {url.partition(", ")[0] for url in metadata.get_all("Project-URL", [])} == {"Homepage", "Changelog"}
    assert text.startswith("# cspcheck\n")
    assert "docs/command-line.md for every option" in text
    assert [link for link in re.findall(r"\]\(([^)]*)\)", text) if not link.startswith("https://")] == []


def test_the_sdist_has_what_its_tests_and_pages_need(release: Path) -> None:
    (archive,) = release.glob("cspcheck-*.tar.gz")
    with tarfile.open(archive) as names:
        inside = {name.partition("/")[2] for name in names.getnames()}

    assert {"README.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "docs/tutorial.md", "tests/README.md"} <= inside
    assert "editors/vscode/package.json" in inside


def test_twine_finds_nothing_wrong(release: Path) -> None:
    pytest.importorskip("twine", reason="twine is not installed: the release is not checked with it")
    files = [str(path) for path in release.glob("cspcheck-*") if path.is_file()]
    done = subprocess.run(
        [sys.executable, "-m", "twine", "check", "--strict", *files], capture_output=True, encoding="utf-8", check=False
    )

    assert len(files) == 2
    assert done.returncode == 0, done.stdout + done.stderr
