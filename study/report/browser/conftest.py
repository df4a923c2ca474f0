"""Small results of each kind, and a browser that writes down what pages ask for and complain about."""

import os
import subprocess
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

# A page for each kind of report: the case and what is set to make it small.
KINDS = {
    "comparison": ["quick", "--replicas", "4", "--until", "20"],
    "homogeneous": ["mixture-cooling", "--set", "power_law.monomers=5000", "--until", "100", "--replicas", "3"],
    "flow": ["channel-disks", "--until", "20", "--replicas", "2"],
    "obstacle": ["flow-past-disk", "--until", "3", "--replicas", "2", "--set", "gas.number=4000"],
    "sweep": ["haff-3d", "--until", "10", "--replicas", "2"],
    "frontier": ["quick", "--budget", "10s", "--set", "gas.number=400", "--until", "5", "--tests", "1"],
}

# Elements that stick out of the page and cannot be scrolled to.
CUT = """() => {
  const width = document.documentElement.clientWidth;
  const rolls = (one) => one && (["auto", "scroll"].includes(getComputedStyle(one).overflowX) || rolls(one.parentElement));
  return [...document.body.querySelectorAll("*")].filter((one) => {
    const box = one.getBoundingClientRect();
    return box.width > 0 && (box.right > width + 1 || box.left < -1) && !rolls(one) && !one.closest("svg");
  }).map((one) => one.outerHTML.slice(0, 120));
}"""


def make(kind):
    """Runs a case unless its page is newer than the program, and returns the path of the page."""
    program = Path(os.environ["STOSSZAHL"])
    folder = Path(os.environ["RESULTS"]) / kind
    page = folder / ("frontier.html" if kind == "frontier" else "report.html")
    if not page.exists() or page.stat().st_mtime < program.stat().st_mtime:
        case, *settings = KINDS[kind]
        command = "frontier" if kind == "frontier" else "run"
        line = [program, command, case, *settings, "--out", folder, "--force"]
        subprocess.run(line, check=True, capture_output=True)
    return page


def pytest_configure(config):
    """Makes all pages before tests begin, which several processes share."""
    if not hasattr(config, "workerinput"):
        for kind in KINDS:
            make(kind)


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=os.environ["BROWSER_PATH"], args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture(params=list(KINDS))
def kind(request):
    return request.param


@pytest.fixture
def open_page(browser):
    """Opens the report of a kind; at the end nothing may have been requested or complained about."""
    said, contexts = [], []

    def opened(kind, width=1300, scheme="light", before="", **options):
        context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, accept_downloads=True, **options
        )
        contexts.append(context)
        page = context.new_page()
        address = make(kind).as_uri()
        page.on("console", lambda message: said.append(f"console: {message.text}"))
        page.on("pageerror", lambda error: said.append(f"error: {error}"))
        inside = ("data:", "blob:", address)
        page.on("request", lambda request: request.url.startswith(inside) or said.append(f"request: {request.url}"))
        page.add_init_script(before)
        page.goto(address)
        if options.get("java_script_enabled", True):
            show_all(page)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not said, said


def soon(page, holds):
    """Whether something holds within ten seconds."""
    for _ in range(200):
        if holds():
            return True
        page.wait_for_timeout(50)
    return False


def until(page, condition):
    """Waits until a condition holds; Playwright's own way is stopped by the policy of the page, which allows no `eval`."""
    assert soon(page, lambda: page.evaluate(condition)), f"never: {condition}"


# Whether all figures have their charts or maps.
DRAWN = (
    "[...document.querySelectorAll('figure.interactive')].every((figure) => figure.querySelector('.u-over')"
    " || [...figure.querySelectorAll('.panel')].every((panel) => panel.querySelector('g.cells')))"
)


def show_all(page):
    """Scrolls through the page, as charts are made when they come into view, until all are there."""

    def seen():
        height = page.evaluate("document.documentElement.scrollHeight")
        for place in range(0, height, 600):
            page.evaluate(f"scrollTo(0, {place})")
            page.wait_for_timeout(30)
        return page.evaluate(DRAWN)

    assert soon(page, seen), "some figures are never drawn"
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(100)
