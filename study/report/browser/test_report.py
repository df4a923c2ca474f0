"""What a person sees of a report: charts are drawn, controls move something, nothing is cut off, print is readable."""

import csv
import io
import os
import xml.etree.ElementTree as xml
import zipfile
from pathlib import Path

import pytest
from PIL import Image
from pypdf import PdfReader

from conftest import CUT, KINDS, soon, until

# All that a figure shows: pixels of its charts, which buttons are pressed, and its text.
STATE = """(figure) => [...figure.querySelectorAll("canvas")].map((canvas) => canvas.toDataURL()).join()
  + [...figure.querySelectorAll("button")].map((button) => button.disabled).join()"""
# Different colours inside each chart.
COLOURS = """(figure) => [...figure.querySelectorAll("canvas")].map((canvas) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return new Set(new Uint32Array(data.buffer)).size;
})"""


def figures(page):
    return page.locator("figure.interactive").all()


def energies(page):
    """The figure of energies, wherever the question of the case puts it."""
    return page.locator("figure.interactive", has=page.locator("figcaption b", has_text="Energy.")).first


def charts(page):
    """Figures that are not maps."""
    return [figure for figure in figures(page) if figure.locator("canvas").count()]


def test_every_figure_is_drawn(open_page, kind):
    page = open_page(kind)
    all_figures = figures(page)
    assert all_figures, "a report without figures"
    for figure in charts(page):
        # Paper, ink, grid and a curve, at least.
        assert min(figure.evaluate(COLOURS)) >= 4
        for still in figure.locator("svg.plot").all():
            assert not still.is_visible()


def test_every_button_moves_something(open_page, kind):
    page = open_page(kind)
    for figure in charts(page)[:6]:
        buttons = figure.locator(".bar button, .legend button").all()
        assert len(buttons) >= 6
        for button in buttons:
            name = button.inner_text()
            if name in ("SVG", "PNG", "CSV") or button.is_disabled():
                continue
            if name == "reset":
                figure.locator(".bar button", has_text="+").first.click()
            before = figure.evaluate(STATE)
            pressed = button.get_attribute("aria-pressed")
            button.click()
            assert figure.evaluate(STATE) != before, name
            if pressed is not None:
                assert button.get_attribute("aria-pressed") != pressed, name
                button.click()
                assert button.get_attribute("aria-pressed") == pressed, name


def saved(page, figure, name):
    with page.expect_download() as download:
        figure.locator(".bar button", has_text=name).click()
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


def test_what_is_saved_can_be_read(open_page, kind):
    page = open_page(kind)
    for figure in figures(page)[:3]:
        name, bytes_ = saved(page, figure, "CSV")
        rows = list(csv.reader(io.StringIO(bytes_.decode())))
        assert name.endswith(".csv") and len(rows) > 1
        assert all(len(row) == len(rows[0]) for row in rows)
        name, bytes_ = saved(page, figure, "SVG")
        tree = xml.fromstring(bytes_)
        assert name.endswith(".svg") and tree.tag.endswith("svg") and b"var(" not in bytes_
        name, bytes_ = saved(page, figure, "PNG")
        picture = Image.open(io.BytesIO(bytes_)).convert("RGB")
        assert name.endswith(".png") and len(picture.getcolors(1 << 24)) >= 4


@pytest.mark.parametrize("of", ["comparison", "sweep"])
def test_the_folder_is_in_its_page(open_page, of):
    page, folder = open_page(of), Path(os.environ["RESULTS"]) / of
    with page.expect_download() as download:
        page.get_by_role("button", name="Download the folder").click()
    assert download.value.suggested_filename.endswith(".zip")
    with zipfile.ZipFile(download.value.path()) as archive:
        assert archive.testzip() is None
        held = {name.split("/", 1)[1]: archive.read(name) for name in archive.namelist()}
    assert all(contents == (folder / name).read_bytes() for name, contents in held.items())
    wanted = [path for pattern in ("*.csv", "manifest.json", "sweep.json", "*.svg", "*.xyz") for path in folder.rglob(pattern)]
    assert {str(path.relative_to(folder)) for path in wanted} == set(held) and len(held) > 10


def test_numbers_are_those_of_the_table(open_page):
    """The CSV of the figure of energies has those of the results folder, to nine digits."""
    page = open_page("comparison")
    _, bytes_ = saved(page, energies(page), "CSV")
    found = [row for row in csv.DictReader(io.StringIO(bytes_.decode())) if row["curve"].startswith("ED")]
    table = Path(os.environ["RESULTS"]) / "comparison/energy.csv"
    known = [row for row in csv.DictReader(table.open()) if row["engine"] == "ed"]
    assert len(found) == len(known) > 5
    for one, other in zip(found, known):
        assert float(one["K/K(0)"]) == pytest.approx(float(other["energy_ratio"]), rel=1e-8)
        assert float(one["standard error"]) == pytest.approx(float(other["energy_ratio_se"]), rel=1e-8)


# Writes down each text that is drawn on a canvas, with its place.
RECORD = """
  const write = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
    const { e, f } = this.getTransform();
    (this.canvas.texts ||= []).push([text, Math.round(x + e), Math.round(y + f)]);
    return write.apply(this, arguments);
  };
"""


def test_labels_of_linear_axes_stand_where_they_belong(open_page, kind):
    """A label that is rounded too far is a wrong number at its tick."""
    page = open_page(kind, before=RECORD)
    checked = 0
    for figure in charts(page):
        for button in figure.locator(".bar button", has_text="log").all():
            if button.get_attribute("aria-pressed") == "true":
                button.click()
        page.wait_for_timeout(50)
        for texts in figure.evaluate("(one) => [...one.querySelectorAll('canvas')].map((canvas) => canvas.texts || [])"):
            for row, along in ((2, 1), (1, 2)):
                for place in {text[row] for text in texts}:
                    line = sorted({(t[along], t[0].replace("−", "-")) for t in texts if t[row] == place})
                    try:
                        line = [(at, float(text)) for at, text in line]
                    except ValueError:
                        continue  # powers of ten and names
                    if len(line) < 3 or len({at for at, _ in line}) < len(line):
                        continue
                    (first, low), (last, high) = line[0], line[-1]
                    for at, value in line:
                        # Places are those of whole pixels, so that two of them may be off by one each.
                        assert abs((value - low) / (high - low) * (last - first) - (at - first)) <= 2, line
                    checked += 1
    assert checked >= 2


def test_the_pointer_shows_value_and_error(open_page):
    page = open_page("comparison")
    panel = energies(page).locator(".panel").first
    over = panel.locator(".u-over")
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    tip = panel.locator(".tip")
    assert not tip.is_visible()
    texts = set()
    for share in (0.1, 0.3, 0.5, 0.7, 0.9):
        for height in (0.1, 0.3, 0.5, 0.7, 0.9):
            page.mouse.move(box["x"] + share * box["width"], box["y"] + height * box["height"])
            if tip.is_visible():
                texts.add(tip.inner_text())
    assert len(texts) > 3 and any("±" in text for text in texts) and any("theory" in text for text in texts)
    page.mouse.move(0, 0)
    assert not tip.is_visible()


def test_a_box_magnifies_and_a_double_click_returns(open_page):
    page = open_page("comparison")
    figure = figures(page)[0]
    over = figure.locator(".u-over").first
    over.scroll_into_view_if_needed()
    before = figure.evaluate(STATE)
    box = over.bounding_box()
    page.mouse.move(box["x"] + 60, box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 200, box["y"] + 120, steps=4)
    page.mouse.up()
    assert figure.evaluate(STATE) != before
    page.mouse.dblclick(box["x"] + 100, box["y"] + 100)
    page.mouse.move(0, 0)
    assert figure.evaluate(STATE) == before


PICTURES = "() => [...document.querySelectorAll('#viewer canvas')].map((canvas) => canvas.toDataURL()).join()"


@pytest.mark.parametrize("kind", ["comparison", "flow"])
def test_every_control_of_the_player_moves_something(open_page, kind):
    page = open_page(kind)
    page.wait_for_selector("#viewer[data-ready]")

    def changes(action):
        before = page.evaluate(PICTURES)
        action()
        return soon(page, lambda: page.evaluate(PICTURES) != before)

    assert len(set(page.evaluate(PICTURES).split(","))) >= 2, "engines look alike"
    for colour in ("speed", "density", "field", "partner", "impact", "direction"):
        assert changes(lambda: page.select_option("#viewer-colour", colour)), colour
    for name in ("closer", "home", "closer", "farther"):
        assert changes(page.locator(f"#viewer-{name}").click), name
    page.locator("#viewer-home").click()
    first = page.locator("#viewer canvas").first
    first.scroll_into_view_if_needed()
    box = first.bounding_box()
    page.mouse.click(box["x"] + 50, box["y"] + 50)
    assert changes(lambda: page.mouse.wheel(0, -500))
    page.mouse.move(box["x"] + 100, box["y"] + 60)
    page.mouse.down()
    assert changes(lambda: page.mouse.move(box["x"] + 40, box["y"] + 40, steps=3))
    page.mouse.up()
    assert changes(lambda: page.mouse.dblclick(box["x"] + 50, box["y"] + 50))
    slider = page.locator("#viewer-time")
    assert changes(lambda: slider.fill("0"))
    assert page.locator("#viewer-label").inner_text() == "t = 0"
    # Twenty frames in a second leave the first one within two seconds; a pause stays where it is.
    page.select_option("#viewer-speed", "20")
    page.locator("#viewer-play").click()
    until(page, "Number(document.getElementById('viewer-time').value) > 2")
    page.locator("#viewer-play").click()
    page.wait_for_timeout(150)
    paused = page.evaluate(PICTURES)
    page.wait_for_timeout(200)
    assert page.evaluate(PICTURES) == paused


# Colours at shares of the width and height of the first picture, from its lower left corner.
PIXELS = """(places) => {
  const seen = document.querySelector("#viewer canvas");
  const canvas = Object.assign(document.createElement("canvas"), { width: seen.width, height: seen.height });
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  pen.drawImage(seen, 0, 0);
  const at = ([x, y]) => [...pen.getImageData(Math.round(x * canvas.width), Math.round((1 - y) * canvas.height), 1, 1).data];
  return places.map((place) => at(place).join());
}"""


def test_obstacles_cover_what_they_cover(open_page):
    """The disk of the case has its centre at (14, 10) and radius 2 in a box of 40 by 20, above particles and fields."""
    page = open_page("obstacle")
    page.wait_for_selector("#viewer[data-ready]")
    inside = [(14 / 40, 0.5), (12.5 / 40, 0.5), (15.5 / 40, 0.5), (14 / 40, 8.5 / 20), (14 / 40, 11.5 / 20)]
    for colour in ("direction", "speed", "density", "field"):
        page.select_option("#viewer-colour", colour)
        assert soon(page, lambda: set(page.evaluate(PIXELS, inside)) == {"85,85,85,255"}), colour
    # Outside of it there is the field.
    outside = [(11 / 40, 0.5), (17 / 40, 0.5), (14 / 40, 7 / 20), (14 / 40, 13 / 20)]
    assert "85,85,85,255" not in page.evaluate(PIXELS, outside)
    # Maps of fields, whose frame is the box, have it at the same place.
    maps = page.locator("figure.interactive:has(g.obstacles) svg.plot").all()
    assert len(maps) >= 4
    for drawn in maps:
        frame = drawn.locator("g.cells").first.bounding_box()
        disk = drawn.locator("g.obstacles ellipse").bounding_box()
        assert (disk["x"] - frame["x"]) / frame["width"] == pytest.approx(12 / 40, abs=0.02)
        assert (disk["y"] - frame["y"]) / frame["height"] == pytest.approx(8 / 20, abs=0.04)
        assert disk["width"] / frame["width"] == pytest.approx(4 / 40, abs=0.02)


def test_the_player_draws_a_fair_sample(open_page):
    """Two simulators stand for each disk: as many are drawn as there are disks."""
    page = open_page("comparison")
    page.wait_for_selector("#viewer[data-ready]")
    notes = [note.inner_text() for note in page.locator(".screen p").all()]
    assert notes[0] == notes[1] == "2500 particles"
    sampled = int(notes[2].rsplit(" ", 1)[1])
    # Of 5000 simulators each is drawn with probability 1/2: five standard deviations.
    assert abs(sampled - 2500) < 5 * (5000 * 0.25) ** 0.5


def test_both_themes_differ_and_are_legible(open_page, kind):
    page = open_page(kind)
    first = figures(page)[0]
    seen = {}
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        page.wait_for_timeout(100)
        paper, ink = page.evaluate(
            "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]"
        )
        seen[scheme] = (paper, first.evaluate(STATE) if first.locator("canvas").count() else paper)
        assert contrast(paper, ink) > 7
    assert seen["light"][0] != seen["dark"][0] and seen["light"][1] != seen["dark"][1]


def contrast(one, other):
    """Ratio of luminances as WCAG 2 defines it."""

    def luminance(colour):
        parts = [int(part) / 255 for part in colour[colour.index("(") + 1 : -1].split(",")[:3]]
        parts = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]

    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("width", [390, 1300])
def test_nothing_is_cut_off(open_page, kind, width):
    page = open_page(kind, width=width)
    for details in page.locator("details").all():
        details.evaluate("(one) => (one.open = true)")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(CUT) == []


def test_print_has_the_static_figures_and_no_empty_page(open_page, kind):
    page = open_page(kind)
    panels = page.locator(".panel").count()
    page.emulate_media(media="print")
    stills = page.locator("svg.plot").all()
    assert len(stills) == panels and all(still.is_visible() for still in stills)
    assert not any(canvas.is_visible() for canvas in page.locator(".uplot canvas").all())
    assert not any(bar.is_visible() for bar in page.locator(".bar").all())
    assert not any(button.is_visible() for button in page.locator("button:not(.legend button)").all())
    # Words of a sentence are not set one below the other.
    narrow = "(cells) => cells.map((cell) => cell.getBoundingClientRect().width).filter((width) => width > 0 && width < 90)"
    assert page.locator("td.long").evaluate_all(narrow) == []
    for paper in ("A4", "Letter"):
        pages = PdfReader(io.BytesIO(page.pdf(format=paper))).pages
        for place, sheet in enumerate(pages, 1):
            words = len(sheet.extract_text().split())
            assert words >= 5 or len(sheet.images) > 0, f"{paper}, page {place} of {len(pages)} has {words} words"


def test_without_script_all_is_there_but_the_controls(open_page, kind):
    page = open_page(kind, java_script_enabled=False)
    stills = page.locator("svg.plot").all()
    assert stills and all(still.is_visible() for still in stills)
    assert not any(button.is_visible() for button in page.locator("button, input, select").all())


@pytest.mark.skipif("SCREENSHOTS" not in os.environ, reason="only when pictures of the docs are renewed")
def test_screenshots(open_page):
    folder = Path(__file__).resolve().parents[3] / "docs/screenshots"
    folder.mkdir(exist_ok=True)
    for kind in KINDS:
        for name, width, scheme in ((kind, 1300, "light"), (f"{kind}-dark", 1300, "dark"), (f"{kind}-phone", 390, "light")):
            page = open_page(kind, width=width, scheme=scheme)
            picture = Image.open(io.BytesIO(page.screenshot(clip={"x": 0, "y": 0, "width": width, "height": 1100}, full_page=True)))
            if width > 1000:
                picture = picture.resize((910, 770), Image.Resampling.LANCZOS)
            path = folder / f"{name}.png"
            picture.convert("RGB").quantize(160, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(path, optimize=True)
            assert path.stat().st_size < 150_000, path
    page = open_page("comparison")
    page.select_option("#viewer-colour", "speed")
    page.wait_for_timeout(300)
    picture = Image.open(io.BytesIO(page.locator("#snapshots").screenshot()))
    picture.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(folder / "player.png", optimize=True)
    assert (folder / "player.png").stat().st_size < 150_000
