"""The report as a page."""

import re
from pathlib import Path

from cspcheck.cli import run


def test_a_page_of_a_run(tmp_path: Path) -> None:
    script = tmp_path / "x.csp"
    script.write_text(
        "channel a, b\nP = a -> b -> P\nassert P :[deadlock free]\nassert a -> STOP :[deadlock free]\n"
        "assert STOP [T= P -- expect: fail\nprint <1, 2> == <1>\n"
    )
    out = tmp_path / "r.html"
    assert run(["check", str(script), "--format", "html", "-o", str(out), "--coverage"]) == 1
    page = out.read_text(encoding="utf-8")
    assert "<script" not in page
    assert not re.search(r"""(?:src|href)=["']""", page)
    assert page.count('class="mark pass"') == 2
    assert page.count('class="mark fail"') == 1
    assert page.count("the run, component by component") == 2
    assert page.count("<details open>") == 1
    assert "the machine of P" in page
    assert "all 2 prefixes happen" in page
    assert "fail</b> as expected" in page


def test_what_a_script_says_is_text(tmp_path: Path) -> None:
    script = tmp_path / "x.csp"
    script.write_text('channel a\nP = a -> P\nprint "<script>alert(1)</script>"\nassert P :[deadlock free]\n')
    out = tmp_path / "r.html"
    run(["check", str(script), "--format", "html", "-o", str(out)])
    assert "<script>" not in out.read_text(encoding="utf-8")
