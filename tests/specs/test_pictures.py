"""The pictures of the exhibits are those that the tool draws of their scripts now, and their pages show them."""

from __future__ import annotations

import pytest

from tests.specs.pictures import PICTURES, drawn, page_of, stored
from tests.specs.table import SPECS, systems


@pytest.mark.parametrize("picture", PICTURES)
def test_a_picture_is_what_the_tool_draws(picture: str) -> None:
    assert (SPECS / picture).read_text(encoding="utf-8") == drawn(picture), (
        f"{picture} is out of date: python -m tests.specs.pictures"
    )


def test_every_picture_is_drawn_by_the_tool() -> None:
    assert stored() == set(PICTURES)


@pytest.mark.parametrize("picture", PICTURES)
def test_a_page_shows_its_picture_and_says_of_what_it_is(picture: str) -> None:
    page = page_of(picture).read_text(encoding="utf-8")
    _, process, *_ = PICTURES[picture]

    assert f"]({picture.split('/')[1]})" in page or f"`{picture.split('/')[1]}`" in page
    assert process in page


def test_every_system_has_a_picture() -> None:
    assert {picture.split("/")[0] for picture in PICTURES} == {system.name for system in systems()}
