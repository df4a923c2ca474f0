"""The book, built by mdBook: pages load nothing from outside, no link is dead, nothing is cut off."""

import os
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import pytest

from conftest import CUT

ROOT = Path(__file__).parents[3]
# Targets of all links and pictures.
LINKS = """() => [...document.querySelectorAll("main a[href], main img")].map((one) => one.href || one.src)"""

STRANGE = "[...document.querySelectorAll('main *')].filter((one) => one instanceof HTMLUnknownElement).length"


@pytest.fixture(scope="module")
def book():
    folder = Path(os.environ["RESULTS"]) / "book"
    program = Path(sys.executable).with_name("mdbook")
    done = subprocess.run([program, "build", ROOT / "docs", "-d", folder], check=True, capture_output=True, text=True)
    said = done.stdout + done.stderr
    assert "WARN" not in said and "ERROR" not in said, said
    return folder


def pages(folder):
    """All pages but the one that holds all others for print, and the one for what is not found."""
    return [page for page in sorted(folder.rglob("*.html")) if page.name not in ("print.html", "404.html", "toc.html")]


def test_every_page_is_whole(browser, book):
    said, wanted, anchors = [], [], {}
    for width, scheme in ((1300, "light"), (390, "dark")):
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        page = context.new_page()
        page.on("console", lambda message: said.append(f"{page.url}: {message.text}"))
        page.on("request", lambda request: request.url.startswith(("file:", "data:")) or said.append(request.url))
        for path in pages(book):
            page.goto(path.as_uri())
            assert page.title() and page.locator("main h1").count() >= 1, path
            assert not page.evaluate(CUT.replace("document.body", "document.querySelector('main')")), path
            # What is no element of HTML is text in which an angle bracket was taken for one.
            assert not page.evaluate(STRANGE), path
            anchors[path.as_uri()] = set(page.evaluate("[...document.querySelectorAll('[id]')].map((one) => one.id)"))
            wanted += [(path.name, link) for link in page.evaluate(LINKS)]
        context.close()
    assert len(anchors) > 20 and len(wanted) > 100
    assert not said, said
    for page_name, link in set(wanted):
        if not link.startswith("file:"):
            continue
        address, _, part = link.partition("#")
        assert Path(address.removeprefix("file://")).exists() and book.as_uri() in address, (page_name, link)
        assert not part or unquote(part) in anchors[address], (page_name, link)
