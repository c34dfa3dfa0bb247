from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import pytest
from tolman.scripts.cli.program import execute
from tolman.scripts.report.page import MODULES, make_page, script
from tolman.scripts.report.subject import read_subject

from .browser import CHROMIUM, Browser
from .conftest import Runs

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""

needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (apt-get install chromium)")


def test_a_module_stands_after_those_that_it_imports() -> None:
    assets = files("tolman.scripts.report").joinpath("assets")
    for place, name in enumerate(MODULES):
        text = assets.joinpath(f"{name}.js").read_text(encoding="utf-8")
        assert set(re.findall(r'from "\./(\w+)\.js"', text)) <= set(MODULES[:place])


def test_nothing_is_imported_and_nothing_comes_from_elsewhere() -> None:
    assert not re.search(r"^(import|export) ", script(), re.MULTILINE)
    assert "//cdn" not in script()
    assert "https:" not in script()


def test_a_title_cannot_break_out_of_the_page(runs: Runs) -> None:
    content = read_subject(runs.map).content
    content["about"]["title"] = "</title><script>alert(1)</script>"
    assert "<script>alert" not in make_page(content)


def test_report_writes_one_file_and_refuses_to_replace_it(
    runs: Runs, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    assert execute(["report", str(runs.mapping), "-o", str(page)]) == 0
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert execute(["report", str(runs.mapping), "-o", str(page)]) == 2
    assert "--force" in capsys.readouterr().err


def test_report_names_a_file_that_is_neither_map_nor_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.txt"
    other.write_text("hello")
    assert execute(["report", str(other), "-o", str(tmp_path / "page.html")]) == 2
    assert str(other) in capsys.readouterr().err


@needs_browser
@pytest.mark.slow
def test_the_page_of_a_run_can_be_used(runs: Runs, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text(make_page(read_subject(runs.mapping).content), encoding="utf-8")
    with Browser(tmp_path / "profile") as browser:
        browser.open(f"{page.as_uri()}#t=10.0")
        assert browser.run("tolman.time") == pytest.approx(10.0)
        assert "10.00 s" in browser.run("document.getElementById('now').textContent")
        browser.press("ArrowRight", shift=True)
        assert browser.run("tolman.time") == pytest.approx(11.0)
        browser.press("n")
        browser.press("c", shift=True)
        browser.run("tolman.seek(tolman.run.end)")
        browser.settle()
        place = browser.run(
            "(() => { const box = document.getElementById('plan').getBoundingClientRect();"
            "const [x, y] = tolman.world.camera.toScreen(...tolman.run.nodes.get(1).pose);"
            "return [box.x + x, box.y + y]; })()"
        )
        browser.click(*place)
        assert browser.run("tolman.node") == 1
        assert browser.run("document.querySelectorAll('#details figure').length") == 3
        browser.run("document.querySelector('.row button').click()")
        browser.settle()
        assert not browser.run("document.getElementById('settings').hidden")
        box = browser.run("document.getElementById('slider').getBoundingClientRect().toJSON()")
        browser.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        middle = browser.run("(tolman.run.begin + tolman.run.end) / 2")
        assert browser.run("tolman.time") == pytest.approx(middle, rel=0.02)
        browser.press(" ")
        browser.wait(f"tolman.time > {middle} + 1")
        assert browser.problems == []


@needs_browser
@pytest.mark.slow
def test_the_pages_of_a_trip_and_of_a_map_have_no_errors(runs: Runs, tmp_path: Path) -> None:
    with Browser(tmp_path / "profile", 800, 900) as browser:
        for name, path in (("trip", runs.trip), ("map", runs.map)):
            page = tmp_path / f"{name}.html"
            page.write_text(make_page(read_subject(path).content), encoding="utf-8")
            for theme in ("light", "dark"):
                browser.open(f"{page.as_uri()}#theme={theme}&node=0")
                assert browser.run("document.documentElement.scrollWidth <= innerWidth")
        assert browser.problems == []
