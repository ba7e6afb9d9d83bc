"""Report pages in a headless Chromium: drawn to the end, a clean console, nothing asked of the network."""

import json
import re
import shutil
import subprocess

import pytest

from conftest import sphere_mesh_off

BROWSER = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium here; install the package chromium")

# Without a window the browser makes frames when it likes, in virtual time often none.
FRAMES = "<script>window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 16);</script>"

# Runs after the page's own script: how much of each canvas is painted, in how many colours, and what was loaded; then it
# turns and zooms the bodies.
PROBE = """
<script>
window.addEventListener("load", async () => {
  const later = () => new Promise(done => setTimeout(done, 500));
  const paint = () => Array.from(document.querySelectorAll("canvas"), canvas => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const pen = copy.getContext("2d");
    pen.drawImage(canvas, 0, 0);
    const pixels = new Uint32Array(pen.getImageData(0, 0, copy.width, copy.height).data.buffer);
    const shown = pixels.filter(pixel => pixel >>> 24);
    return { share: shown.length / pixels.length, colours: new Set(shown).size, sum: pixels.reduce((a, b) => (31 * a + b) >>> 0, 7) };
  });
  const found = { wide: document.documentElement.scrollWidth - document.documentElement.clientWidth };
  await later();
  found.painted = paint();
  const view = document.querySelector(".mesh-view canvas");
  if (view) {
    view.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
    await later();
    found.turned = paint();
    view.dispatchEvent(new WheelEvent("wheel", { deltaY: 400, cancelable: true }));
    await later();
    found.zoomed = paint();
  }
  found.loaded = performance.getEntriesByType("resource").map(entry => entry.name);
  document.body.dataset.probe = JSON.stringify(found);
});
</script>
"""


def look(page, width=1280):
    """The probe's findings, whether the page's script came to its end, and the lines of the console."""
    flags = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    flags += ["--host-resolver-rules=MAP * ~NOTFOUND", "--no-first-run", "--disable-background-networking"]
    flags += ["--enable-logging=stderr", "--virtual-time-budget=8000", f"--window-size={width},900", "--dump-dom"]
    with_probe = page.with_name("probe.html")
    html = page.read_text().replace("<head>", "<head>" + FRAMES).replace("</body>", PROBE + "</body>")
    with_probe.write_text(html)
    process = subprocess.run([BROWSER, *flags, with_probe.as_uri()], capture_output=True, text=True, timeout=180)
    found = re.search(r'data-probe="([^"]*)"', process.stdout)
    assert found, process.stderr[-2000:]
    console = [line for line in process.stderr.splitlines() if "CONSOLE" in line]
    ready = re.search(r'<html[^>]*data-ready="yes"', process.stdout) is not None
    return json.loads(found[1].replace("&quot;", '"')), ready, console


def clean(page, width=1280):
    """Looks at a page that must be without fault, and returns the probe's findings."""
    probe, ready, console = look(page, width)
    assert ready, console
    assert console == []
    assert probe["loaded"] == []
    assert probe["wide"] <= 0, f"at a width of {width} the page is {probe['wide']} pixels too wide"
    return probe


@pytest.fixture(scope="module")
def sweep(tmp_path_factory, protomer):
    folder = tmp_path_factory.mktemp("report")
    (folder / "ball.off").write_text(sphere_mesh_off(8.0))
    for name, charge in [("plus", 6), ("minus", -6)]:
        (folder / f"{name}.xyzq").write_text(f"3 0 0 {charge}\n-3 0 0 1\n")
        protomer("body", "--mesh", folder / "ball.off", "--charges", folder / f"{name}.xyzq", "-o", folder / f"{name}.body", parse=False)
    placements = [
        {"body": ["plus", "minus"][k % 2], "position_angstrom": [18.0 * k, 0, 0], "orientation_wxyz": [1, 0, 0, 0]} for k in range(3)
    ]
    bodies = [{"name": name, "file": f"{name}.body"} for name in ["plus", "minus"]]
    assembly = {"box_angstrom": [200, 200, 200], "bodies": bodies, "placements": placements}
    (folder / "row.json").write_text(json.dumps(assembly))
    protomer("sweep", folder / "row.json", "--salt", "50mM,200mM", "--replicas", 2, "--sweeps", 40, "--equilibration", 10,
             "--trajectory-every", 20, "-o", folder / "sweep", "-q", parse=False)
    protomer("report", folder / "sweep", "-q", parse=False)
    return folder / "sweep" / "report.html"


@pytest.mark.parametrize("width", [1280, 390])
def test_a_sweep_shows_its_bodies(sweep, width):
    probe = clean(sweep, width)
    (bodies,), (turned,), (zoomed,) = probe["painted"], probe["turned"], probe["zoomed"]
    # A ball fills much of the canvas, in the shades of its potential.
    assert 0.15 < bodies["share"] < 0.9 and bodies["colours"] > 100
    assert turned["sum"] != bodies["sum"], "the arrow key turns"
    assert zoomed["share"] < 0.6 * bodies["share"], "the wheel zooms"


def test_a_lattice_moves(tmp_path, protomer):
    protomer("lattice", "run", "--ns", 4, "--steps", 100, "--trajectory-every", 10, "-o", tmp_path / "run", "-q", parse=False)
    protomer("report", tmp_path / "run", "-q", parse=False)
    wheel, squares = clean(tmp_path / "run" / "report.html")["painted"]
    assert wheel["share"] == 1 and wheel["colours"] > 50
    assert squares["share"] > 0.1 and squares["colours"] >= 3


def test_a_network_and_a_training_are_readable(tmp_path, protomer):
    protomer("framework", "honeycomb", "--theta", 60, "--kh", 50, "--ks", 10000, "-o", tmp_path / "net", "-q", parse=False)
    protomer("train", "--control", "orientation", "--short", "--epochs", 2, "-o", tmp_path / "training", "-q", parse=False)
    for name in ["net", "training"]:
        protomer("report", tmp_path / name, "-q", parse=False)
        assert clean(tmp_path / name / "report.html", width=390)["painted"] == []


@pytest.mark.parametrize(
    ("fault", "complaint"),
    [('<img src="https://example.org/a.png">', "Content Security Policy"), ("<script>throw new Error('broken')</script>", "broken")],
)
def test_a_faulty_page_is_noticed(sweep, tmp_path, fault, complaint):
    """What the checks above look for is there to be found."""
    faulty = tmp_path / "faulty.html"
    faulty.write_text(sweep.read_text().replace("</main>", fault + "</main>"))
    _, _, console = look(faulty)
    assert any(complaint in line for line in console), console
