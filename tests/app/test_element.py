"""`<latolato-player>` in pages of others, whose policy allows nothing that it does not need."""

from __future__ import annotations

import re
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

from latolato.app.forms import registry
from latolato.app.run_request import RunRequest, options_of
from latolato.core.errors import InputError
from latolato.scenario.options import law_options

POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; "
    "connect-src 'self'; img-src 'self'"
)
# Options of the drive that pages do not have.
MEASURED = ["pivot_heights", "height_sigma", "pivot_across", "across_sigma"]
# Set the attributes of an element, a new one if it has none, and say what comes of them.
SET = """([which, attributes]) => new Promise((done) => {
  let player = document.querySelectorAll("latolato-player")[which];
  const isNew = !player;
  player ??= document.createElement("latolato-player");
  player.addEventListener("computed", () => {
    const error = player.shadowRoot.querySelector("[role=alert]");
    done(error.hidden ? { options: player.player.motion.about.options } : { error: error.innerText });
  }, { once: true });
  for (const { name } of [...player.attributes])
    if (!(name in attributes)) player.removeAttribute(name);
  for (const [name, value] of Object.entries(attributes)) player.setAttribute(name, value);
  if (isNew) document.body.append(player);
})"""  # noqa: E501


class Strict(SimpleHTTPRequestHandler):
    """A file server whose pages may do no more than the element needs."""

    def end_headers(self):
        self.send_header("Content-Security-Policy", POLICY)
        super().end_headers()

    def log_message(self, *args):
        pass


@pytest.fixture(scope="module")
def address(site):
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Strict, directory=site))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


@pytest.fixture
def visit(browser, address):
    """A page that knows the element; what goes wrong on it fails the test."""
    page = browser.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
    page.goto(f"{address}manifest.json")
    page.add_script_tag(url=f"{address}latolato-player.js", type="module")
    page.wait_for_function("() => customElements.get('latolato-player')")
    yield page
    page.close()
    assert not faults


def base_of(name):
    """Return the least that a run needs whose laws know an option."""
    known = registry()
    laws = {"system": "latolato", "drive": "harmonic", "contact": "exact"}
    own = known["ratios"].get(name, name)
    for part, group in (("system", "systems"), ("drive", "drives"), ("contact", "contact_laws")):
        owners = [law for law, each in known[group].items() if own in each["options"]]
        laws[part] = owners[0] if owners else laws[part]
    if laws["system"] in ("pendulum", "mathieu", "ballpair"):
        del laws["contact"]
    angle = "0.4 rad, -0.3 rad" if laws["system"] == "ballpair" else "0.4 rad"
    needed = [
        *known["systems"][laws["system"]]["options"],
        *known["drives"][laws["drive"]]["options"],
    ]
    given = {each: text_of(each) for each in needed if known["options"][each]["default"] is None}
    if own != name:
        del given[own]
    return {**laws, **given, "initial_angle": angle, "duration": "0.5 s"}


def text_of(name):
    """Return a text for an option."""
    option = law_options()[name]
    if option.choices:
        return option.choices[-1]
    if option.kind is bool:
        return "true"
    value = next(v for v in (option.quantity.usual, option.default, 1) if v is not None)
    values = value if isinstance(value, (list, tuple)) else [value]
    unit = option.unit if option.unit not in ("", "1") else ""
    return ", ".join(f"{each} {unit}".strip() for each in values)


def in_python(scenario, options):
    """Return what an element should have: its options, or the sentence that refuses them."""
    try:
        wanted = RunRequest(scenario, options).to_scenario()
        wanted.record()
    except InputError as error:
        return {"error": str(error)}
    return {"options": options_of(wanted)}


def with_attributes(refused, *names):
    """Return a refusal that calls options by their attributes."""
    names = "|".join(sorted([*law_options(), *names], key=len, reverse=True))
    dashes = re.sub(rf"\b({names})\b", lambda name: name[0].replace("_", "-"), refused["error"])
    return {"error": dashes}


def test_every_parameter_is_an_attribute(visit):
    names = [name for name in law_options() if name not in MEASURED]
    for name in names:
        options = base_of(name)
        options[name] = options.get(name) or text_of(name)
        found = visit.evaluate(SET, [0, dashed(options)])
        wanted = in_python(None, options)
        if "error" in wanted:
            assert found == with_attributes(wanted, name), name
        else:
            assert wanted["options"].items() <= found["options"].items(), name


def test_a_scenario_is_an_attribute_and_others_change_it(visit):
    found = visit.evaluate(SET, [0, {"scenario": "fig12", "length": "30 cm", "id": "mine"}])
    wanted = in_python("fig12", {"length": "30 cm"})["options"]
    assert wanted.items() <= found["options"].items()
    assert found["options"]["length"] == 0.3


@pytest.mark.parametrize(
    "name, value",
    [
        ("lenght", "1 m"),
        ("drive_amplitud", "1 m"),
        ("drive_amplitude", "-1 m"),
        ("right_length", "1 m"),
        ("initial_distance", "1 m"),
        ("initial_angle", "1 m"),
        ("radius", "2 m"),
        ("duration", "-1 s"),
        ("contact", "soft"),
        ("drive", "harmonik"),
    ],
)
def test_a_bad_attribute_is_refused_in_the_sentence_of_python(visit, name, value):
    visit.evaluate(SET, [0, {"scenario": "toy", "duration": "1 s"}])
    wrong = visit.evaluate(SET, [0, dashed({"scenario": "toy", name: value})])
    assert wrong == with_attributes(in_python("toy", {name: value}), name)
    assert "_" not in wrong["error"]
    assert "options" in visit.evaluate(SET, [0, {"scenario": "toy", "duration": "1 s"}])


@pytest.mark.parametrize("name", MEASURED)
def test_a_drive_that_pages_do_not_have_is_left_to_the_program(visit, name):
    options = {**base_of(name), name: text_of(name)}
    assert options["drive"] == "measured_pivot"
    found = visit.evaluate(SET, [0, dashed(options)])
    text = "the drive measured_pivot is computed by the installed program, not in a page"
    assert found == {"error": text}


def test_a_dragged_ball_changes_the_attributes_of_the_start(visit):
    visit.evaluate(SET, [0, {"scenario": "fig02", "initial-angle": "20 deg"}])
    player = "document.querySelector('latolato-player')"
    visit.evaluate(f"""() => {player}.addEventListener("computed",
        () => {{ window.isDragged = true; }}, {{ once: true }})""")
    box = visit.locator("latolato-player canvas.scene").bounding_box()
    x, y = visit.evaluate(f"""() => {{
      const {{ scene }} = {player}.player;
      return [scene.drawn[0].x / devicePixelRatio, scene.drawn[0].y / devicePixelRatio];
    }}""")
    visit.mouse.move(box["x"] + x, box["y"] + y)
    visit.mouse.down()
    visit.mouse.move(box["x"] + x + 30, box["y"] + y - 30)
    visit.mouse.up()
    visit.wait_for_function("() => window.isDragged")
    text = visit.locator("latolato-player").get_attribute("initial-angle")
    assert text.endswith(" deg")
    assert float(text.removesuffix(" deg")) > 25
    wanted = in_python("fig02", {"initial_angle": text})["options"]
    found = visit.evaluate(f"() => {player}.player.motion.about.options")
    assert wanted.items() <= found.items()


def test_two_elements_of_a_page_have_runs_of_their_own(visit):
    for which, length in ((0, "50 cm"), (1, "80 cm")):
        visit.evaluate(SET, [which, {"scenario": "fig02", "length": length, "duration": "2 s"}])
    assert shown(visit, "motion.about.options.length") == [0.5, 0.8]
    visit.locator("latolato-player").nth(1).get_by_role("button", name="Play", exact=True).click()
    visit.wait_for_function(
        "() => document.querySelectorAll('latolato-player')[1].player.clock.time"
    )
    assert shown(visit, "clock.playing") == [False, True]


def test_an_element_may_leave_and_come_back(visit):
    visit.evaluate(SET, [0, {"scenario": "fig02", "duration": "2 s"}])
    counts = visit.evaluate(
        """async () => {
          const player = document.querySelector("latolato-player");
          const counts = [];
          for (let i = 0; i < 3; i += 1) {
            player.remove();
            counts.push(player.shadowRoot.querySelectorAll("canvas.scene").length);
            // It may leave again before it was there.
            document.body.append(player);
            player.remove();
            const done = new Promise((resolve) =>
              player.addEventListener("computed", resolve, { once: true }));
            document.body.append(player);
            await done;
            counts.push(player.shadowRoot.querySelectorAll("canvas.scene").length);
          }
          return counts;
        }"""
    )
    assert counts == [0, 1] * 3
    assert shown(visit, "motion.end") == [2.0]


def dashed(options):
    """Return options as attributes."""
    return {name.replace("_", "-"): value for name, value in options.items()}


def shown(visit, path):
    """Return a property of the player of each element."""
    return visit.evaluate(
        f"() => [...document.querySelectorAll('latolato-player')].map((each) => each.player.{path})"
    )


def test_an_element_speaks_the_language_around_it(visit):
    visit.evaluate("() => { document.body.lang = 'id-ID'; }")
    refused = visit.evaluate(SET, [0, {"scenario": "fig02", "length": "-1"}])
    assert refused["error"].startswith("length harus berada dalam (0, inf) m, tetapi diberikan -1")
    assert visit.get_by_role("button", name="Putar", exact=True).count() == 1


@pytest.mark.parametrize("languages, play", [(("en", "id"), "Play"), (("id", "en"), "Putar")])
def test_all_elements_of_a_page_speak_the_language_of_the_first(visit, languages, play):
    refused = [
        visit.evaluate(SET, [which, {"scenario": "fig02", "length": "-1", "lang": language}])
        for which, language in enumerate(languages)
    ]
    assert refused[0] == refused[1]
    names = visit.locator("latolato-player button.play").all_inner_texts()
    assert names == [play, play]
