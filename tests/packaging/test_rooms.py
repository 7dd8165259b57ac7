"""The page about the architecture shows the house as the import contracts hold it."""

from __future__ import annotations

from tests.packaging.rooms import ROOT, contracts, picture


def test_the_picture_is_that_of_the_contracts() -> None:
    assert (ROOT / "docs" / "architecture.svg").read_text(encoding="utf-8") == picture(), (
        "docs/architecture.svg is out of date: python -m tests.packaging.rooms > docs/architecture.svg"
    )


def test_the_page_names_every_room() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")

    for package, layers in contracts():
        floor = package.removeprefix("cspcheck").strip(".")
        for name in [name for layer in layers for name in layer]:
            folder = ROOT / floor / name
            if floor and folder.is_dir():
                assert f"`{floor}/{name}/`" in page, f"{floor}/{name}"


def test_the_page_names_no_room_that_is_not_there() -> None:
    import re

    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    for name in re.findall(r"`((?:cspm|checker|codegen|cspcheck|tests)/[\w/]*/)`", page):
        assert (ROOT / name).is_dir(), name
