"""Report pages in a headless Chromium: drawn to the end, a clean console, nothing asked of the network, no sideways scroll,
letters that can be read on a phone, bodies that follow keys, wheel and fingers."""


import pytest

from chromium import BINARY, Chromium
from conftest import ROOT, write_row

pytestmark = pytest.mark.skipif(BINARY is None, reason="no Chromium here; install the package chromium")

PHONE, DESK = 390, 1280
SMALLEST_LETTERS = 8.0

# How much of each canvas is painted, in how many colours.
PAINT = """
Array.from(document.querySelectorAll("canvas"), canvas => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d");
  pen.drawImage(canvas, 0, 0);
  const pixels = new Uint32Array(pen.getImageData(0, 0, copy.width, copy.height).data.buffer);
  const shown = pixels.filter(pixel => pixel >>> 24);
  return { share: shown.length / pixels.length, colours: new Set(shown).size, sum: pixels.reduce((a, b) => (31 * a + b) >>> 0, 7) };
})
"""

# The sizes on the screen, in pixels, of the letters in figures.
LETTERS = """
Array.from(document.querySelectorAll(".figure svg text"))
  .filter(text => text.getClientRects().length > 0)
  .map(text => { const to = text.getScreenCTM(); return parseFloat(getComputedStyle(text).fontSize) * Math.hypot(to.a, to.b); })
"""

# Width of the content, of the room for it, and of the screen.
SIDEWAYS = "[document.documentElement.scrollWidth, document.documentElement.clientWidth, innerWidth]"


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    browser = Chromium(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


def visit(chromium, file, width=DESK):
    return chromium.open(file, width, height=844 if width == PHONE else 900, phone=width == PHONE)


def is_clean(page, width):
    """Invariants of every page."""
    assert page.complaints() == []
    assert page.requests() == []
    assert page.evaluate("performance.getEntriesByType('resource').length") == 0
    assert page.evaluate("document.documentElement.dataset.ready") == "yes"
    content, room, screen = page.evaluate(SIDEWAYS)
    assert screen == width and content <= room, f"at a width of {width} the page has {content} pixels, room for {room}"
    letters = page.evaluate(LETTERS)
    if width == PHONE and letters:
        assert min(letters) >= SMALLEST_LETTERS, f"letters of {min(letters):.1f} pixels"
    figures = "Array.from(document.querySelectorAll('.figure')).every(f => f.scrollWidth <= f.clientWidth)"
    assert page.evaluate(figures), "a figure is wider than its place"


def looked_at(chromium, file, width):
    """Opens a page that must be without fault, and closes it again."""
    page = visit(chromium, file, width)
    is_clean(page, width)
    painted = page.evaluate(PAINT)
    page.close()
    return painted


@pytest.fixture(scope="module")
def sweep(tmp_path_factory, protomer):
    folder = tmp_path_factory.mktemp("report")
    write_row(folder / "row.json", protomer, 3, charge=6, box=200)
    protomer("sweep", folder / "row.json", "--salt", "50mM,200mM", "--replicas", 2, "--sweeps", 40, "--equilibration", 10,
             "--trajectory-every", 20, "-o", folder / "sweep", "-q", parse=False)
    protomer("report", folder / "sweep", "-q", parse=False)
    return folder / "sweep" / "report.html"


@pytest.mark.parametrize("width", [DESK, PHONE])
def test_a_sweep_shows_its_bodies(chromium, sweep, width):
    page = visit(chromium, sweep, width)
    is_clean(page, width)
    (bodies,) = page.evaluate(PAINT)
    # A ball fills much of the canvas, in the shades of its potential.
    assert 0.15 < bodies["share"] < 0.9 and bodies["colours"] > 100
    page.evaluate("document.querySelector('.mesh-view canvas').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft' }))")
    page.pause()
    (turned,) = page.evaluate(PAINT)
    assert turned["sum"] != bodies["sum"], "the arrow key turns"
    page.evaluate("document.querySelector('.mesh-view canvas').dispatchEvent(new WheelEvent('wheel', { deltaY: 400 }))")
    page.pause()
    (zoomed,) = page.evaluate(PAINT)
    assert zoomed["share"] < 0.6 * bodies["share"], "the wheel zooms"
    page.close()


def test_a_trajectory_of_bodies_plays(chromium, sweep):
    page = visit(chromium, sweep)
    assert page.evaluate("document.querySelector('.film').hidden")
    scenes = page.evaluate("Array.from(document.querySelector('.scene').options, option => option.textContent)")
    assert [name for name in scenes if name.startswith("film")] == ["film at 50 mM", "film at 200 mM"]
    page.evaluate(f"(menu => {{ menu.value = {scenes.index('film at 50 mM')}; menu.onchange(); }})(document.querySelector('.scene'))")
    page.pause()
    frame = "document.querySelector('.mesh-view canvas').dataset.frame"
    label = "document.querySelector('.film output').textContent"
    assert (page.evaluate(frame), page.evaluate(label)) == ("0", "sweep 20")
    (first,) = page.evaluate(PAINT)
    assert first["share"] > 0.001, "bodies and the box are drawn"
    page.evaluate("(slider => { slider.value = 1; slider.oninput(); })(document.querySelector('.film input'))")
    page.pause()
    (second,) = page.evaluate(PAINT)
    assert page.evaluate(label) == "sweep 40" and second["sum"] != first["sum"]
    page.evaluate("document.querySelector('.film button').click()")
    seen = set()
    for _ in range(20):
        page.pause()
        seen.add(page.evaluate(frame))
    assert seen == {"0", "1"}, "it plays, and begins again"
    is_clean(page, DESK)
    page.close()


def test_fingers_turn_and_zoom_the_bodies_and_leave_the_page_where_it_is(chromium, sweep):
    page = visit(chromium, sweep, PHONE)
    page.evaluate("document.querySelector('.mesh-view canvas').scrollIntoView({ block: 'center', behavior: 'instant' })")
    page.pause()
    at = page.evaluate("(r => [r.x + r.width / 2, r.y + r.height / 2])(document.querySelector('.mesh-view canvas').getBoundingClientRect())")
    place = page.evaluate("scrollY")
    line = lambda start, end: [(at[0] + start + (end - start) * k / 8, at[1] + 0.3 * (start + (end - start) * k / 8)) for k in range(9)]
    (before,) = page.evaluate(PAINT)
    page.touch(line(-60, 60))
    (turned,) = page.evaluate(PAINT)
    assert turned["sum"] != before["sum"], "one finger turns"
    assert abs(turned["share"] - before["share"]) < 0.1 * before["share"], "one finger does not zoom: a ball stays as large"
    page.touch(line(-100, -30), line(100, 30))
    (smaller,) = page.evaluate(PAINT)
    assert smaller["share"] < 0.6 * turned["share"], "two fingers that close in make it smaller"
    page.touch(line(-30, -100), line(30, 100))
    (larger,) = page.evaluate(PAINT)
    assert larger["share"] > 1.5 * smaller["share"], "two fingers that part make it larger"
    assert page.evaluate("scrollY") == place, "the page stays where it is"
    assert page.evaluate("visualViewport.scale") == 1
    # Next to the picture a finger scrolls the page, as everywhere.
    page.evaluate("document.querySelector('#results h2').scrollIntoView({ block: 'start', behavior: 'instant' })")
    page.pause()
    place = page.evaluate("scrollY")
    page.touch([(195, 600 - 40 * k) for k in range(9)])
    page.wait(f"scrollY > {place} + 50")
    page.close()


@pytest.mark.parametrize("width", [DESK, PHONE])
def test_lattices_move_and_their_figures_can_be_read(chromium, tmp_path, protomer, width):
    protomer("lattice", "run", "--ns", 4, "--steps", 100, "--trajectory-every", 10, "-o", tmp_path / "run", "-q", parse=False)
    protomer("report", tmp_path / "run", "-q", parse=False)
    wheel, squares = looked_at(chromium, tmp_path / "run" / "report.html", width)
    assert wheel["share"] == 1 and wheel["colours"] > 50
    assert squares["share"] > 0.1 and squares["colours"] >= 3
    settings = "rows = 4\ncolumns = 4\nsteps = 60\ntrajectory_every = 10\n[sweep]\nr0 = [0.1, 0.2]\nkappa = [0.0, 0.5]\nseeds = [1, 2]\n"
    (tmp_path / "sweep.toml").write_text(settings)
    protomer("lattice", "sweep", tmp_path / "sweep.toml", "-o", tmp_path / "sweep", "-q", parse=False)
    protomer("report", tmp_path / "sweep", "-q", parse=False)
    assert len(looked_at(chromium, tmp_path / "sweep" / "report.html", width)) == 2


@pytest.fixture(scope="module")
def other_pages(tmp_path_factory, protomer):
    """Static pages."""
    folder = tmp_path_factory.mktemp("others")
    structure = ROOT / "data" / "structures" / "5pti.cif.gz"
    rows = [f"{structure},{['even', 'odd'][k % 2]},c{k},s{k}" for k in range(16)] + [f"{folder}/missing.pdb,odd,c16,gone"]
    (folder / "set.csv").write_text("\n".join(["file,label,cluster,name", *rows]) + "\n")
    honeycomb = ["honeycomb", "--theta", 60, "--kh", 50, "--ks", 10000, "--load", "y", "--stress", "20GPa,40GPa"]
    for arguments in [
        ["framework", *honeycomb, "-o", folder / "net"],
        ["framework", "tables", "-o", folder / "tables"],
        ["train", "--control", "orientation", "--short", "--epochs", 2, "-o", folder / "training"],
        ["voxelize", "--manifest", folder / "set.csv", "-o", folder / "set.zarr", "--size", 24, "--spacing", 2,
         "--potential", "debye-hueckel"],
        ["tune", folder / "set.zarr", "--least-samples", 5, "--trials", 3, "--epochs", 3, "-o", folder / "search"],
    ]:
        protomer(*arguments, "-q", parse=False)
    for name in ["net", "tables", "training", "set.zarr", "search"]:
        protomer("report", folder / name, "-q", parse=False)
    return folder


@pytest.mark.parametrize("width", [DESK, PHONE])
@pytest.mark.parametrize("name", ["net/report", "tables/report", "training/report", "set.zarr.report", "search/report"])
def test_other_pages_are_readable(chromium, other_pages, name, width):
    assert looked_at(chromium, other_pages / f"{name}.html", width) == []


@pytest.mark.parametrize(
    ("fault", "complaint"),
    [
        ('<img src="https://example.org/a.png">', "Content Security Policy"),
        ("<script>throw new Error('broken')</script>", "broken"),
        ('<p style="width: 2000px">wide</p>', "pixels, room for"),
        ('<div class="figure"><svg viewBox="0 0 900 90"><text y="50" font-size="12">small</text></svg></div>', "letters of"),
    ],
)
def test_a_faulty_page_is_noticed(chromium, sweep, tmp_path, fault, complaint):
    """The elements that the checks above look for exist."""
    faulty = tmp_path / "faulty.html"
    faulty.write_text(sweep.read_text().replace("</main>", fault + "</main>"))
    page = visit(chromium, faulty, PHONE)
    with pytest.raises(AssertionError, match=complaint):
        is_clean(page, PHONE)
    page.close()


def test_a_view_that_does_not_follow_fingers_is_noticed(chromium, sweep, tmp_path):
    deaf = tmp_path / "deaf.html"
    deaf.write_text(sweep.read_text().replace("canvas.onpointermove", "canvas.nobody"))
    with pytest.raises(AssertionError, match="one finger turns"):
        test_fingers_turn_and_zoom_the_bodies_and_leave_the_page_where_it_is(chromium, deaf)
