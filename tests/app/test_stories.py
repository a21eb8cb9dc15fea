"""Stories and challenges: their files, their physics, and their way through a page."""

from __future__ import annotations

import itertools
import json
import math
import re
import tomllib
from pathlib import Path
from urllib.parse import parse_qs, urlencode, urlsplit

import numpy as np
import pytest

import latolato as ll
import story_numbers
from app_pages import enter
from browser_checks import SIZES, assert_panels_have_room, serious_faults
from hanging import threshold_amplitude
from latolato import analysis
from latolato.app import STATIC, stories
from latolato.app.run_request import RunRequest
from latolato.app.site import write_site
from latolato.core.errors import InputError

HOW_TO = Path(__file__).parents[2] / "docs" / "how-to" / "stories.md"
FILES = {path.stem: stories.read(path) for path in stories.FOLDER.glob("*.toml")}
STORIES = [name for name, tables in FILES.items() if tables["kind"] == "story"]
CHALLENGES = [name for name, tables in FILES.items() if tables["kind"] == "challenge"]
# Each story in one language, every language in some stories; and the other way round.
LANGUAGES = ("en", "id")
IN_ONE = list(zip(STORIES, itertools.cycle(LANGUAGES)))
IN_OTHER = list(zip(STORIES, itertools.cycle(LANGUAGES[::-1])))
STEPS = [(name, i) for name in STORIES for i, _ in enumerate(FILES[name]["steps"], start=1)]
DEGREE = math.radians(1.0)

# What a reader does who follows "try" in each step.
TRIED = {
    "first_clack": [
        {"drive_amplitude": "4 cm"}, {"drive_amplitude": "0 cm"}, {"drive_amplitude": "4 cm"},
        {"restitution": "0.85"}, {"drive_amplitude": "7 cm"},
    ],
    "why_twice": [
        {"mass": "1.6 kg"}, {"drive_frequency": "6.26 rad/s"}, {"drive_frequency": "6.1 rad/s"},
        {"initial_angle": "0.0005 rad"}, {"damping": "0 kg m/s"},
        {"frequency_ratio": "1.95", "drive_amplitude": "0.1"},
    ],
    "high_then_low": [
        {"initial_offset": "10 deg"}, {"drive_amplitude": "20 mm"}, {"drive_amplitude": "40 mm"},
        {"frequency_ratios": "3.136, 2.389"}, {"initial_offset": "7 deg"},
        {"frequency_ratio": "2.389"},
    ],
    "order_and_chaos": [
        {"drive_amplitude": "80 mm"}, {"drive_amplitude": "87 mm"}, {"drive_amplitude": "89.8 mm"},
        {"drive_amplitude": "91.5 mm"}, {"initial_angle": "20.001 deg"},
        {"drive_frequency": "19", "drive_amplitude": "0.06"},
    ],
    "upside_down": [
        {"drive_frequency": "14 Hz"}, {"drive_frequency": "16.3 Hz"},
        {"drive_frequency": "205 rad/s"}, {"drive_frequency": "205 rad/s"},
        {"initial_angle": "100 deg"}, {"drive_frequency": "150", "drive_amplitude": "0.02"},
    ],
}  # fmt: skip
# How to do it by hand: what a control is called in the table of texts (or its label, or its unit),
# and what is typed.
BY_HAND = {
    "first_clack": [
        ("knobAmplitude", "40"), ("knobAmplitude", "0"), ("knobAmplitude", "40"),
        ("knobRestitution", "0.85"), ("knobAmplitude", "70"),
    ],
    "why_twice": [
        ("mass of one ball", "1600"), ("timesNatural", "2"), ("timesNatural", "1.95"),
        ("initial angle", "0.0005 rad"), ("knobDamping", "0"), ("map", ""),
    ],
    "high_then_low": [
        ("initial angle above the low contact angle", "10"), ("knobAmplitude", "20"),
        ("knobAmplitude", "40"), ("angular frequency of each stage", ""),
        ("initial angle above the low contact angle", "7"), ("low", ""),
    ],
    "order_and_chaos": [
        ("knobAmplitude", "80"), ("knobAmplitude", "87"), ("knobAmplitude", "89.8"),
        ("knobAmplitude", "91.5"), ("initial angle", "20.001"), ("map", ""),
    ],
    "upside_down": [
        ("knobFrequency", "14"), ("knobFrequency", "16.3"), ("knobFrequency", "32.7"),
        ("knobFrequency", "32.7"), ("initial angle", "100"), ("map", ""),
    ],
}  # fmt: skip
INDONESIAN = json.loads((STATIC / "languages" / "id.json").read_text(encoding="utf-8"))
ENGLISH = {
    "story": "Story", "storyAnyway": "Go on anyway", "storyNext": "Next", "storyFinish": "Finish",
    "stories": "Stories", "moreParameters": "More parameters",
    "timesNatural": "\N{MULTIPLICATION SIGN} ω₀",
    "knobAmplitude": "How far the hand moves", "knobFrequency": "How often",
    "knobRestitution": "Bounciness", "knobDamping": "Friction",
}  # fmt: skip
SOLUTIONS = {
    "least_amplitude": {"drive_amplitude": "40 mm", "drive_frequency": "2.3 Hz"},
    "shortest_protocol": {"drive_times": "0 s, 1 s", "frequency_ratios": "3.3, 2.389"},
    "guess_tongue": {"guess": "120 mm, 57 mm, 8 mm, 49 mm, 95 mm"},
}


def said(text, language):
    """What a page in a language says for a text of a story, or for one named in the table."""
    if language == "en":
        return ENGLISH.get(text, text)
    return INDONESIAN["strings"].get(text) or INDONESIAN["texts"].get(" ".join(text.split()), text)


def texts_of(part):
    """All texts of a story that readers see."""
    for key, value in part.items() if isinstance(part, dict) else enumerate(part):
        if isinstance(value, dict | list):
            yield from texts_of(value)
        elif key in ("title", "text", "question", "answer", "label"):
            yield value


def options_of(name, step, tried):
    """Preset and options of a step, as it begins or when its reader has tried."""
    look = FILES[name]["steps"][step - 1]["look"]
    own = look.get("options", {})
    return look["preset"], {**own, **TRIED[name][step - 1]} if tried else own


def number(name, preset, angle=math.nan, **options):
    return story_numbers.quantity(name, story_numbers.run_of(preset, options), angle)


def degrees(name, preset, **options):
    return math.degrees(number(name, preset, **options))


def number_of(name, step, tried=False):
    """The number of a step, computed by Python."""
    shown = FILES[name]["steps"][step - 1]["number"]
    preset, options = options_of(name, step, tried)
    return number(shown["quantity"], preset, **options)


# Files.


def test_stories_have_five_to_seven_steps():
    assert len(STORIES) == 5
    for name in STORIES:
        assert 5 <= len(FILES[name]["steps"]) <= 7


def test_the_list_has_stories_in_their_order_and_then_challenges(page):
    page.goto("/?view=toy&story.list=1")
    titles = page.locator(".story-cards h4").all_text_contents
    page.locator(".story-cards h4").first.wait_for()
    ordered = sorted([*STORIES, *CHALLENGES], key=lambda name: FILES[name]["order"])
    ordered.sort(key=CHALLENGES.__contains__)
    assert ordered[0] == "first_clack"
    assert titles() == [FILES[name]["title"] for name in ordered]


def test_a_site_lists_the_files_of_a_teacher(tmp_path):
    write_site(tmp_path)
    folder = tmp_path / "stories"
    (folder / "mine.toml").write_text(example())
    write_site(tmp_path)
    listed = json.loads((folder / "contents.json").read_text())
    assert set(listed) == {*FILES, "mine"}
    assert len(listed["mine"]["steps"]) == 1
    (folder / "spoilt.toml").write_text(example().replace("minutes = 3", "minutes = 0"))
    with pytest.raises(InputError, match=r"spoilt\.toml: minutes must be a number above zero"):
        write_site(tmp_path)


@pytest.mark.parametrize(
    "content, reason",
    [(b"title = ", "at end of document"), (b"title = '\xe9'", "can't decode byte 0xe9"),
     (b"order = 2020-01-01", "date is not JSON"), (b"minutes = nan", "not JSON compliant")],
)  # fmt: skip
def test_a_site_refuses_a_file_that_is_not_toml(tmp_path, content, reason):
    write_site(tmp_path)
    (tmp_path / "stories" / "spoilt.toml").write_bytes(content)
    with pytest.raises(InputError, match=f"spoilt.toml' is not a story in TOML: .*{reason}"):
        write_site(tmp_path)


def example():
    """The complete story in the documentation."""
    return re.search(r"```toml\n(format.*?)```", HOW_TO.read_text(encoding="utf-8"), re.S)[1]


BROKEN = [
    ("format = 1", "format = 2", "it has format 2, and this version reads 1 at most"),
    ('kind = "story"', 'kind = "tale"', "there is no kind 'tale': known are story, challenge"),
    ("minutes = 3", "", "minutes is missing"),
    ("minutes = 3", 'minutes = "3"', "minutes must be a number above zero"),
    ("[steps.explanation]", "[steps.explanations]",
     "step 1: there is no entry 'explanations': did you mean 'explanation'?"),
    ('quantity = "swing_period"\n', "", "step 1, number: quantity is missing"),
    ('quantity = "swing_period"', 'quantity = "swing_perod"',
     "step 1, number: there is no quantity 'swing_perod': did you mean 'swing_period'?"),
    ('quantity = "swing_period"', 'quantity = "time_to_angle"',
     "step 1, number: angle is missing: time_to_angle needs one"),
    ('preset = "fig02"', 'preset = "fig20"',
     "step 1, look: there is no preset 'fig20': did you mean 'fig02'?"),
    ('view = "toy"', 'view = "stage"',
     "step 1, look: there is no view 'stage': known are toy, map"),
    ('view = "toy"', 'view = "toy"\nextra = { scenario = "toy" }',
     'step 1, look: extra must be a table of texts with names such as "map.x"'),
    ("right = true", "right = false", "step 1, predict: one choice must be right, got 0"),
    ("right = true", "right = 1", "step 1, predict, choice 2: right must be true or false"),
    ('length = "1 m"', 'lenght = "1 m"',
     "step 1, look: unknown option 'lenght': did you mean 'length'?"),
    ('parameter = "length"', 'parameter = "lengths"',
     "step 1, try, condition 1: there is no parameter 'lengths': did you mean 'length'?"),
    ('parameter = "length"', 'parameter = "length", quantity = "contacts"',
     "step 1, try, condition 1: name one of parameter, quantity, address"),
    ('at_most = "30 cm"', 'at_most = "30 s"',
     "step 1, try, condition 1: at_most must be given in m (or a unit that converts to it), "
     "got '30 s'"),
]  # fmt: skip


def test_what_is_wrong_with_a_file_is_one_sentence():
    for old, new, sentence in BROKEN:
        assert old in example()
        with pytest.raises(InputError) as refused:
            stories.check(tomllib.loads(example().replace(old, new, 1)))
        assert str(refused.value) == sentence


def test_the_example_of_the_documentation_is_a_story():
    stories.check(tomllib.loads(example()))
    step = tomllib.loads(example())["steps"][0]
    run = story_numbers.run_of(step["look"]["preset"], step["look"]["options"])
    long = story_numbers.quantity(step["number"]["quantity"], run)
    run = story_numbers.run_of(
        step["look"]["preset"], step["look"]["options"] | {"length": "25 cm"}
    )
    short = story_numbers.quantity(step["number"]["quantity"], run)
    assert long / short == pytest.approx(2.0, rel=1e-3)  # as its text says


def test_the_documentation_names_every_entry_quantity_and_rule():
    text = HOW_TO.read_text(encoding="utf-8")
    schema = stories.SCHEMA
    entries = {entry.rstrip("?") for table in schema["tables"].values() for entry in table}
    for name in [*entries, *schema["quantities"], *schema["rules"]]:
        assert f"`{name}`" in text, name


# Numbers.


def test_pages_and_python_compute_the_same_numbers(ask_node):
    asked, expected = [], []
    for name, step in STEPS:
        look = FILES[name]["steps"][step - 1]["look"]
        shown = FILES[name]["steps"][step - 1]["number"]["quantity"]
        for tried in (False, True):
            if look["view"] == "map":  # the run on show is that of a point
                look = {**look, "view": "toy"}
            more = TRIED[name][step - 1] if tried else {}
            asked.append({"look": look, "options": more, "name": shown, "angle": None})
            expected.append(number_of(name, step, tried))
    angle = {"name": "time_to_angle", "angle": 45 * DEGREE}
    asked.append({"look": {"view": "toy", "preset": "fig12"}, "options": {}, **angle})
    expected.append(number("time_to_angle", "fig12", 45 * DEGREE))
    still = {"drive_amplitude": "0 m"}
    assert math.isnan(number("shakes_per_swing", "fig02", **still))
    fig02 = {"view": "toy", "preset": "fig02"}
    asked.append({"look": fig02, "options": still, "name": "shakes_per_swing"})
    expected.append(math.nan)
    asked.append({"look": {"view": "toy", "preset": "toy"}, "options": {}, "name": "contacts"})
    expected.append(number("contacts", "toy"))
    found = ask_node("stories_in_node.mjs", {"numbers": asked, "scores": []})["numbers"]
    found = [math.nan if each is None else each for each in found]
    # Nine seconds of chaos amplify the last digit of two builds of the same code.
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("name", CHALLENGES)
def test_a_challenge_can_be_solved_and_pages_give_its_score(name, ask_node):
    challenge, options = FILES[name], SOLUTIONS[name]
    score = story_numbers.score(challenge, options)
    assert score.beats_par
    asked = {"challenge": challenge, "options": options}
    [found] = ask_node("stories_in_node.mjs", {"numbers": [], "scores": [asked]})["scores"]
    assert found == pytest.approx(score.value, rel=1e-6)  # times lie between samples


def test_a_challenge_does_not_begin_at_its_goal():
    assert not story_numbers.score(FILES["least_amplitude"], {}).beats_par
    assert not story_numbers.score(FILES["shortest_protocol"], {}).beats_par
    weak = story_numbers.score(FILES["least_amplitude"], {"drive_amplitude": "1 mm"})
    assert math.isnan(weak.value)


def test_what_a_challenge_does_not_leave_free_counts_not():
    challenge = FILES["least_amplitude"]
    cheat = {"drive_amplitude": "20 mm", "restitution": "1", "initial_angle": "170 deg"}
    assert math.isnan(story_numbers.score(challenge, cheat).value)


def test_the_tongue_is_that_of_the_analysis():
    challenge = FILES["guess_tongue"]
    system = RunRequest("fig02", {}).to_scenario().system
    for ratio, side in zip(
        challenge["task"]["ratios"], ["low", "low", None, "high", "high"], strict=True
    ):
        amplitude = threshold_amplitude(
            frequency_ratio=ratio, length=system.length, mass=system.mass,
            damping=system.damping, gravity=system.gravity,
        )  # fmt: skip
        if side is None:  # the tip is not sharp in the ratio
            continue
        edges = analysis.tongue_edges(system, drive_amplitude=amplitude)
        assert float(edges[side]) == pytest.approx(ratio, rel=1e-6)


# What the texts say.


def test_from_rest_to_clack_tells_the_truth():
    rest = {"initial_offset": "0 deg"}
    contact = degrees("largest_angle", "toy", drive_amplitude="0 m", **rest)
    for millimetres in (20, 25, 27):
        options = {"drive_amplitude": f"{millimetres} mm", **rest}
        assert number("drive_acceleration_ratio", "toy", **options) < 1
        assert degrees("largest_angle", "toy", **options) == pytest.approx(contact, abs=1e-6)
    trembling = {"drive_amplitude": "30 mm", **rest}
    assert number("drive_acceleration_ratio", "toy", **trembling) > 1
    assert degrees("largest_angle", "toy", **trembling) < contact + 0.1
    assert degrees("late_angle", "toy", drive_amplitude="2 cm") > 15
    still = story_numbers.run_of("toy", {"drive_amplitude": "0 m"})
    assert "rest" in still.contact_kind
    assert degrees("largest_angle", "toy", drive_amplitude="4 cm") < 90
    assert number("top_contacts", "toy") > 0
    run = RunRequest("toy", {}).to_scenario().simulate()
    for name in ("drive_work", "damping_loss", "impact_loss"):
        assert float(run[name][-1]) > 0
    bottom = run.contact_kind.values == "bottom"
    before, after = run.angular_velocity_before.values, run.angular_velocity_after.values
    np.testing.assert_allclose(np.abs(after[bottom] / before[bottom]), 0.9, rtol=1e-9)
    assert number("top_contacts", "toy", restitution="0.85") == 0
    played = story_numbers.run_of("toy", {})
    late = played.contact_time >= 10.0
    clacks = [kind for kind, is_late in zip(played.contact_kind, late, strict=True) if is_late]
    assert (clacks.count("bottom"), clacks.count("top")) == (30, 30)  # three shakes a second
    assert number("top_time", "toy", drive_amplitude="7 cm") < number("top_time", "toy")


def test_why_twice_tells_the_truth():
    alone = {"drive_amplitude": "0 m", "initial_angle": "10 deg", "duration": "20 s"}
    light = number("swing_period", "fig02", **alone)
    assert number("swing_period", "fig02", mass="1.6 kg", **alone) == pytest.approx(light, rel=1e-3)
    short = {"initial_angle": "5 deg", "duration": "60 s"}
    assert degrees("largest_angle", "fig02", drive_frequency="3.13 rad/s", **short) < 5.001
    assert degrees("late_angle", "fig02", drive_frequency="3.13 rad/s", **short) < 2
    assert degrees("late_angle", "fig02", drive_frequency="6.26 rad/s", **short) > 30
    locked = {"initial_angle": "1 deg", "duration": "100 s", "drive_frequency": "6.1 rad/s"}
    assert number("shakes_per_swing", "fig02", **locked) == pytest.approx(2, abs=0.01)
    system = RunRequest("fig02", {}).to_scenario().system
    assert 6.1 / system.natural_frequency == pytest.approx(1.95, abs=0.005)
    scenario = RunRequest("fig02", {}).to_scenario()
    known = float(analysis.growth_rate(scenario.system, scenario.drive)["growth_rate"])
    for angle in ("0.001 rad", "0.0005 rad"):
        rate = number("growth_rate", "fig02", initial_angle=angle, duration="40 s")
        assert rate == pytest.approx(known, rel=0.005)
    assert math.log(2) / 0.1 == pytest.approx(7, abs=0.1)
    assert 60 < degrees("largest_angle", "fig02", damping="0 kg m/s") < 90
    free = story_numbers.run_of("fig02", {"damping": "0 kg m/s"})
    size = np.abs(free.angle[0])
    peaks = size[1:-1][(size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])]
    late = peaks[len(peaks) // 2 :]
    assert late.max() > 5 * late.min()  # it goes up and down, undiminished
    assert late.max() == pytest.approx(peaks.max(), rel=0.01)


def test_first_high_then_low_tells_the_truth():
    low = {"drive": "harmonic", "drive_amplitude": "34 mm", "frequency_ratio": "2.389"}
    high = {**low, "frequency_ratio": "3.136"}
    rest = degrees("largest_angle", "fig12", **low)
    assert degrees("largest_angle", "fig12", mass="1 kg", **low) == pytest.approx(rest)
    assert degrees("largest_angle", "fig12", duration="300 s", **low) == pytest.approx(rest)
    assert degrees("late_angle", "fig12", initial_offset="10 deg", **low) > 40
    assert number("drive_acceleration_ratio", "fig12", **low) < 1
    assert number("drive_acceleration_ratio", "fig12", **high) > 1
    assert degrees("largest_angle", "fig12", **{**high, "drive_amplitude": "20 mm"}) < rest + 0.1
    alone = degrees("largest_angle", "fig12", **high)
    for amplitude in ("34 mm", "40 mm"):
        assert degrees("largest_angle", "fig12", drive_amplitude=amplitude) > 2 * alone
    swapped = {"drive_amplitude": "34 mm", "frequency_ratios": "2.389, 3.136"}
    late = degrees("late_angle", "fig12", **high)
    assert degrees("late_angle", "fig12", **swapped) == pytest.approx(late, rel=0.01)
    assert degrees("late_angle", "first_push", initial_offset="5 deg") < rest + 0.1
    assert degrees("late_angle", "first_push", initial_offset="7 deg") > 40


def test_order_and_chaos_tells_the_truth():
    soft = {"restitution": "0.5", "duration": "60 s"}
    known = {60: 1, 80: 1, 82: 1, 87: 2, 89.8: 4, 91.5: math.nan}
    for millimetres, period in known.items():
        found = number("response_period", "toy", drive_amplitude=f"{millimetres} mm", **soft)
        assert found == pytest.approx(period, nan_ok=True)
    # Where the rhythm doubles [mm]: each step is about a fifth of the one before.
    toy = RunRequest("toy", soft).to_scenario()
    beyond = {84.8: 1, 85.0: 2, 89.3: 2, 89.5: 4, 90.2: 4, 90.35: 8, 90.45: 8, 90.5: 16}
    grid = ll.sweep(
        toy.system, toy.drive, axes={"drive_amplitude": [1e-3 * each for each in beyond]},
        initial_angle=20 * DEGREE, duration=300.0, observables=["response_period"], tolerance=1e-9,
    )  # fmt: skip
    assert list(grid["response_period"]) == list(beyond.values())
    lasting = ll.sweep(
        toy.system, toy.drive, axes={"drive_amplitude": [0.0915]}, initial_angle=20 * DEGREE,
        duration=1000.0, transient=100.0, observables=["lyapunov_exponent"],
    )  # fmt: skip
    assert lasting.rests.item() == 0
    assert lasting.lyapunov_exponent.item() > 0.9
    # A map and the story beside it say the same of a point.
    point = {
        "drive_frequency": f"{16 + 19 * 6 / 49} rad/s",
        "drive_amplitude": f"{70 + 24 * 40 / 49} mm",
    }
    assert number("response_period", "toy", **point, **soft) == 8
    hair = {"restitution": "0.5", "duration": "12 s"}

    def ends(amplitude):
        return [
            degrees("final_angle", "toy", drive_amplitude=amplitude, initial_angle=angle, **hair)
            for angle in ("20 deg", "20.001 deg")
        ]

    calm, chaotic = ends("80 mm"), ends("91.5 mm")
    assert abs(calm[1] - calm[0]) < 1e-4  # a tenth of what was between them
    assert abs(chaotic[1] - chaotic[0]) > 10


def test_upside_down_tells_the_truth():
    def stands(**options):
        return degrees("farthest_from_top", "kapitza", **options) < 45

    assert stands()
    assert 2 * math.pi * 24 == pytest.approx(150, rel=0.01)
    assert not stands(drive_frequency="90 rad/s")
    assert stands(drive_frequency="130 rad/s")
    gravity = 9.80665
    for length, amplitude in ((0.2, 0.02), (0.2, 0.01), (0.8, 0.02)):
        limit = math.sqrt(2 * gravity * length)
        for share, is_up in ((0.98, False), (1.04, True)):
            frequency = f"{share * limit / amplitude} rad/s"
            options = {"length": f"{length} m", "drive_amplitude": f"{amplitude} m"}
            assert stands(drive_frequency=frequency, **options) == is_up
    assert math.sqrt(2 * gravity * 0.2) == pytest.approx(1.98, abs=0.005)
    assert degrees("farthest_from_top", "kapitza", initial_angle="120 deg") < 60.1
    assert degrees("farthest_from_top", "kapitza", initial_angle="100 deg") > 170


# In a page.


def address(name, step=1, tried=False):
    preset, options = options_of(name, step, tried)
    look = FILES[name]["steps"][step - 1]["look"]
    extra = look.get("extra", {})
    story = {"story.name": name, "story.step": step}
    return "/?" + urlencode({"view": look["view"], "scenario": preset, **options, **extra, **story})


def tab_to(page, locator):
    """Press Tab until an element has the focus."""
    for _ in range(200):
        if locator.evaluate("(element) => element === document.activeElement"):
            return
        page.keyboard.press("Tab")
    raise AssertionError(f"Tab never reaches {locator}")


def value_on(page):
    number = page.locator(".story-number strong[data-value]")
    number.wait_for()
    return float(number.get_attribute("data-value"))


# How far an element reaches out of the window, or of what it scrolls in [px].
HIDDEN = """(elements) => elements.map((element) => {
  const { top, bottom } = element.getBoundingClientRect();
  const frame = document.querySelector(".story-body").getBoundingClientRect();
  return Math.max(frame.top - top, bottom - frame.bottom, bottom - innerHeight, 0);
})"""


@pytest.mark.parametrize("name, language", IN_ONE)
def test_a_story_is_told_to_its_end_by_keys_alone_on_a_phone(page, name, language):
    page.set_viewport_size(SIZES[1])
    steps = FILES[name]["steps"]
    foreign = {text for text in texts_of(FILES[name]) if said(text, language) != text}
    assert bool(foreign) == (language != "en")
    page.goto(f"/?view=toy&story.list=1&lang={language}")
    link = page.locator(".story-cards").get_by_role(
        "link", name=said(FILES[name]["title"], language)
    )
    link.wait_for()
    tab_to(page, link)
    page.keyboard.press("Enter")
    panel = page.get_by_role("complementary", name=said("story", language))
    for i, step in enumerate(steps, start=1):
        title = said(step["title"], language)
        panel.get_by_role("heading", name=title, exact=True, level=3).wait_for()
        choices = step["predict"]["choices"]
        right = [choice.get("right", False) for choice in choices].index(True)
        radios = panel.get_by_role("radio")
        if "toy.hand" in step["look"].get("extra", {}):  # whose stage leaves the focus where it is
            page.locator("[data-ready]").wait_for()
        assert page.evaluate("document.activeElement.textContent") == title
        # All answers and the button that checks one are in view, in a longer language a swipe away.
        assert panel.locator("[type=submit]").evaluate_all(HIDDEN) == pytest.approx([0], abs=1), i
        answers = panel.locator(".check")
        if language == "en":
            assert answers.evaluate_all(HIDDEN) == pytest.approx([0] * answers.count(), abs=1), i
        answers.last.scroll_into_view_if_needed()
        assert answers.evaluate_all(HIDDEN)[-1] == pytest.approx(0, abs=1)
        tab_to(page, radios.first)
        page.keyboard.press("Space")
        for _ in range(right):
            page.keyboard.press("ArrowDown")
        page.keyboard.press("Enter")
        panel.get_by_text(f"✓ {said(choices[right]['answer'], language)}").wait_for()
        if step["look"]["view"] != "map":
            expected = number_of(name, i)
            assert value_on(page) == pytest.approx(expected, rel=1e-5, nan_ok=True)
        explanation = panel.get_by_text(said(step["explanation"]["text"], language))
        assert not explanation.is_visible()
        anyway = panel.get_by_role("button", name=said("storyAnyway", language))
        tab_to(page, anyway)
        page.keyboard.press("Enter")
        explanation.wait_for()
        assert foreign.isdisjoint(panel.inner_text().split("\n"))
        next_one = said("storyFinish" if i == len(steps) else "storyNext", language)
        tab_to(page, panel.get_by_role("button", name=next_one))
        page.keyboard.press("Enter")
    panel.get_by_role("heading", level=2, name=said("stories", language)).wait_for()
    assert "story.name" not in page.url


def try_by_hand(page, name, step, language):
    """Do what "try" says, with the controls that it names."""
    control, text = BY_HAND[name][step - 1]
    if control == "map":
        page.locator("[data-done]").wait_for()
        page.locator("main canvas").first.click()
        return
    if control == "low":
        task = said(FILES[name]["steps"][step - 1]["try"]["text"], language)
        button = re.search("“(.+?)”", task)[1]
        page.get_by_role("button", name=re.compile(f"^{button}")).click()
        return
    label = said(control, language)
    if not control.startswith(("knob", "times")):
        more = page.get_by_text(said("moreParameters", language), exact=True)
        if more.locator("xpath=..").get_attribute("open") is None:
            more.click()
    if control == "angular frequency of each stage":
        fields = [page.get_by_label(f"{label} {row}", exact=True) for row in (1, 2)]
        for field, value in zip(
            fields, [field.input_value() for field in fields][::-1], strict=True
        ):
            enter(field, value)
        return
    if control == "timesNatural":
        field = page.locator(".knobs .entry .entry", has_text=label).get_by_role("textbox")
    else:
        field = page.get_by_role("textbox", name=re.compile(rf"^{label}(\s\S+)?$"))
    enter(field, text)


@pytest.mark.parametrize("name, language", IN_OTHER)
def test_what_a_step_says_can_be_tried_with_the_controls_of_the_page(page, name, language):
    page.goto(address(name) + f"&lang={language}")
    steps = FILES[name]["steps"]
    for step, tables in enumerate(steps, start=1):
        page.get_by_role("heading", name=said(tables["title"], language), exact=True).wait_for()
        page.locator(".story-step .check").last.click()
        page.locator(".story-step [type=submit]").click()
        page.locator(".story-number strong[data-value]").wait_for(state="attached")
        page.locator("main .view").wait_for()
        why = page.get_by_text(said(tables["explanation"]["text"], language))
        assert not why.is_visible()
        try_by_hand(page, name, step, language)
        why.wait_for()
        if step < len(steps):
            page.get_by_role("button", name=said("storyNext", language), exact=True).click()


def test_the_way_back_takes_away_what_was_not_yet_done_there(page):
    page.goto(address("why_twice"))
    page.locator(".story-step .check").first.click()
    page.locator(".story-step [type=submit]").click()
    page.locator(".story-number strong[data-value]").wait_for()
    try_by_hand(page, "why_twice", 1, "en")
    done = page.get_by_text("✓ That is it.")
    done.wait_for()
    page.wait_for_url("**story.tried=1**")
    page.go_back()
    done.wait_for(state="detached")
    page.go_forward()
    done.wait_for()
    # Grams where a kilogram and a half was meant: friction leaves no swing.
    enter(page.get_by_role("textbox", name=re.compile("^mass of one ball")), "1.6 g")
    page.get_by_text("none: in the second half, the ball does not swing there and back").wait_for()


def test_a_tick_stands_beside_a_run_that_does_what_was_to_be_tried_and_no_other(page):
    link = "/?scenario=toy&initial_offset=0+deg&story.name=first_clack&story.answers=1"
    page.goto(f"{link}&drive_amplitude=10+mm&story.tried=1")
    page.get_by_text("Why is that?").wait_for()
    assert value_on(page) < 1
    done = page.get_by_text("✓ That is it.")
    assert done.count() == 0
    amplitude = page.get_by_role("textbox", name=re.compile("^How far the hand moves"))
    enter(amplitude, "40")
    done.wait_for()
    enter(amplitude, "10")
    done.wait_for(state="detached")
    assert value_on(page) < 1
    assert page.get_by_text("Why is that?").is_visible()  # what was read stays


def test_a_story_survives_a_reload_and_the_way_back(page):
    page.goto("/?story.name=first_clack")
    page.get_by_role("heading", name="Hanging still").wait_for()
    page.wait_for_url("**scenario=toy**")
    page.get_by_label("We only have to wait longer.").check()
    page.get_by_role("button", name="Check").click()
    page.get_by_text("✗ Waiting does not help").wait_for()
    page.wait_for_url("**story.answers=3**")
    page.get_by_role("button", name="Next").click()
    page.get_by_role("heading", name="The first push").wait_for()
    page.reload()
    page.get_by_role("heading", name="The first push").wait_for()
    page.go_back()
    page.get_by_role("heading", name="Hanging still").wait_for()
    page.get_by_text("✗ Waiting does not help").wait_for()


def test_leaving_a_story_keeps_what_is_on_show(page):
    page.goto(address("first_clack", 2))
    page.get_by_role("button", name="Leave the story").click()
    page.wait_for_url(lambda url: "story" not in url)
    assert parse_qs(urlsplit(page.url).query)["drive_amplitude"] == ["20 mm"]
    assert not page.get_by_role("complementary", name="Story").is_visible()


@pytest.mark.parametrize("query, step", [("?", "99"), ("?scenario=toy&", "0"), ("?", "two")])
def test_a_step_that_there_is_not_is_named_and_the_story_begins(page, query, step):
    page.goto(f"/{query}story.name=first_clack&story.step={step}")
    page.locator("#story .story-step").wait_for()
    page.locator(".message").get_by_text(f"“story.step={step}”").wait_for()
    assert page.locator(".story-place").inner_text() == "Step 1 of 5"
    page.wait_for_url(lambda url: f"story.step={step}" not in url)


@pytest.mark.parametrize("name", ["no_such", "toString", "../../index"])
def test_a_story_that_is_gone_leads_to_the_list(page, name):
    page.goto(f"/?view=toy&story.name={name}&story.step=2&story.answers=1")
    page.locator(".stage-messages .message.bad").wait_for()
    assert not page.get_by_role("complementary", name="Story").is_visible()
    page.wait_for_url(lambda url: "story." not in url)
    page.locator(".stage").get_by_role("button", name="All stories and challenges").click()
    page.get_by_role("heading", level=2, name="Stories").wait_for()


def solved(name):
    """The address of a challenge with its solution."""
    look, options = FILES[name]["look"], dict(SOLUTIONS[name])
    extra = {"story.guess": options.pop("guess")} if "guess" in options else {}
    own = {**look.get("options", {}), **options}
    return {"view": "toy", "scenario": look["preset"], **own, "story.name": name, **extra}


@pytest.mark.parametrize("name", CHALLENGES)
def test_a_link_to_a_solution_shows_its_score(page, name):
    score = story_numbers.score(FILES[name], SOLUTIONS[name])
    page.goto("/?" + urlencode(solved(name)))
    page.get_by_text("You have reached the goal").wait_for()
    found = page.locator(".story-number").get_attribute("data-value")
    assert float(found) == pytest.approx(score.value, rel=1e-5)


def test_guesses_of_the_tongue_are_scored(page):
    page.goto("/?story.name=guess_tongue")
    fields = page.get_by_role("textbox", name="shakes per swing")
    fields.first.wait_for()
    for i, guess in enumerate(SOLUTIONS["guess_tongue"]["guess"].split(",")):
        fields.nth(i).fill(guess.split()[0])
    check = page.get_by_role("button", name="Score my guesses")
    for wrong, words in {"-5": "must be at least 0 mm", "": "A number belongs here"}.items():
        fields.nth(1).fill(wrong)
        check.click()
        page.get_by_text(words).wait_for()
    assert "story.guess" not in page.url
    fields.nth(1).fill("5,7 cm")
    check.click()
    page.get_by_text("You have reached the goal").wait_for()
    page.get_by_text("Theory says").wait_for()
    score = story_numbers.score(FILES["guess_tongue"], SOLUTIONS["guess_tongue"])
    found = float(page.locator(".story-number").get_attribute("data-value"))
    assert found == pytest.approx(score.value, rel=1e-6)


def test_a_refused_guess_is_seen_on_a_phone(page):
    page.set_viewport_size(SIZES[1])
    page.goto("/?story.name=guess_tongue&lang=id")
    check = page.get_by_role("button", name="Nilai tebakanku")
    check.click()
    for guess in range(2):
        field = page.locator(".story .knob").nth(guess)
        entry, error = field.locator("input"), field.get_by_role("alert")
        assert entry.evaluate("(each) => each === document.activeElement")
        top = page.locator(".story-body").bounding_box()["y"]
        bottom = check.bounding_box()["y"]
        for box in (entry.bounding_box(), error.bounding_box()):
            assert top <= box["y"] <= box["y"] + box["height"] <= bottom
        entry.fill("10")
        check.click()


@pytest.mark.parametrize(
    "place, theme",
    [
        ("/?view=toy&story.list=1", "light"),
        (address("first_clack", 3), "dark"),
        ("/?story.name=guess_tongue", "light"),
    ],
)
def test_stories_are_accessible_and_have_room(page, theme, place):
    page.emulate_media(color_scheme=theme)
    page.goto(place + "&story.answers=223" if "step" in place else place)
    page.locator(".story-step, .story-cards").first.wait_for()
    page.wait_for_timeout(500)
    assert not serious_faults(page)
    assert_panels_have_room(page)


def test_numbers_among_answers_are_written_as_the_language_does(page):
    page.goto(address("why_twice", 3) + "&lang=id")
    page.locator(".story-step .check").first.wait_for()
    answers = page.locator(".story-step .check").all_inner_texts()
    assert answers == ["1,95", "Tepat 2", "1"]


@pytest.mark.parametrize("place", [("first_clack", 1), ("upside_down", 6), ("high_then_low", 6)])
def test_a_phone_sees_the_stage_above_the_panel(page, place):
    page.set_viewport_size(SIZES[1])
    page.goto(address(*place))
    page.locator(".story-step").wait_for()
    page.wait_for_timeout(2500)  # the map is there, and its first point
    stage = page.locator("main canvas").first.bounding_box()
    panel = page.locator("#story").bounding_box()
    assert stage["y"] >= 0
    assert stage["y"] + stage["height"] <= panel["y"] + 1


@pytest.mark.parametrize("height", [664, 740])
def test_the_button_of_a_question_covers_no_answer_on_a_low_phone(page, height):
    page.set_viewport_size({"width": 390, "height": height})
    page.goto("/?view=toy&story.name=first_clack")
    answers = page.locator(".story-step .check")
    answers.last.wait_for()
    page.wait_for_timeout(500)  # fonts and the stage
    last = answers.last.bounding_box()
    check = page.locator(".story-step [type=submit]").bounding_box()
    assert last["y"] + last["height"] <= check["y"]


def test_a_low_window_shows_the_story_beside_the_stage(page):
    page.set_viewport_size({"width": 683, "height": 384})  # a laptop at 200 % zoom
    page.goto("/?story.name=first_clack&story.step=2")
    page.wait_for_selector("[data-runs]")
    panel, stage = (page.locator(each).bounding_box() for each in (".story", ".desk .stage .scene"))
    assert stage["x"] + stage["width"] <= panel["x"]
    assert stage["y"] + stage["height"] <= 384
    assert stage["height"] >= 140
