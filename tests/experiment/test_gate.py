"""The gate before a track: what is no ball is refused, what is one passes unchanged."""

from __future__ import annotations

import re

import numpy as np
import pytest

import latolato as ll
from conditions import conditions
from latolato.cli.main import main
from latolato.core.errors import InputError, Sentence
from latolato.experiment import follow
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.tracking import gate
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.sample import Sample
from latolato.experiment.tracking.steady import Bar, camera_motions, farthest
from latolato.experiment.video import Frame
from videos import rewritten

SWING = ll.Pendulum(length=0.363, mass=0.1, damping=0.003)
TOY = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.0)
WALL = "#d9d6ce"


def _place(attrs, name):
    return attrs[f"{name}_pixel_u"], attrs[f"{name}_pixel_v"]


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """Return a function that films a swing once: the file and its attributes."""
    folder = tmp_path_factory.mktemp("gate")
    made = {}

    def get(name, width=320, height=240, **scene):
        if name not in made:
            run = ll.simulate(SWING, DRIVE, initial_angle=0.9, duration=1.5)
            path = folder / f"{name}.mp4"
            camera = Camera(width=width, height=height, pixels_per_metre=330.0)
            truth = synthesise_video(run, path, Scene(ball_radius=0.02, **scene), camera, seed=3)
            made[name] = path, truth.attrs
        return made[name]

    return get


def _ok_share(path, pivot, ball, **arguments):
    """Return the share of samples that are ok; none are if the track is refused."""
    try:
        table = ll.track(path, pivot=pivot, balls=[ball], **arguments)
    except InputError:
        return 0.0
    return float((table.flag_1 == "ok").mean())


def _assert_refused(path, pivot, ball, match, **arguments):
    with pytest.raises(InputError, match=match) as caught:
        ll.track(path, pivot=pivot, balls=[ball], **arguments)
    # Pages say both in their language.
    assert all(isinstance(part, Sentence) for part in (caught.value.rule, caught.value.way_out))


quiet = pytest.mark.filterwarnings("ignore::RuntimeWarning")


@quiet
def test_a_panning_camera_is_refused(film, tmp_path):
    path, attrs = film("wide", width=480, height=320, background="texture", contrast=0.8)

    def panned(frames, k):
        left = k
        return frames[k][1][40:280, left : left + 320]

    pan = rewritten(path, tmp_path / "pan.mp4", panned)
    (u, v), (x, y) = _place(attrs, "pivot"), _place(attrs, "ball_1")
    assert _ok_share(pan, (u, v - 40), (x, y - 40), length=SWING.length) < 0.05


@quiet
@pytest.mark.parametrize("aside", [(0.3, -0.05), (-0.2, -0.1)])
def test_a_ball_at_rest_beside_the_one_that_swings_is_not_followed(film, aside):
    path, attrs = film(f"parked{aside}", parked_x=aside[0], parked_y=aside[1])
    click = _place(attrs, "parked")
    assert _ok_share(path, _place(attrs, "pivot"), click, length=SWING.length) < 0.05


@quiet
def test_a_ball_that_swings_about_another_pivot_is_refused_for_that(film):
    path, attrs = film("plain")
    u, v = _place(attrs, "pivot")
    ball = _place(attrs, "ball_1")
    _assert_refused(path, (u - 60, v + 20), ball, "so it does not swing about it")


@quiet
def test_what_the_rough_path_decides_is_refused_before_anything_is_learned(film, monkeypatch):
    def learned(*_, **__):
        pytest.fail("a scene was learned")

    monkeypatch.setattr(follow, "learn_image_model", learned)
    path, attrs = film("parked(0.3, -0.05)", parked_x=0.3, parked_y=-0.05)
    u, v = _place(attrs, "pivot")
    _assert_refused(path, (u, v), _place(attrs, "parked"), "it rests")
    _assert_refused(path, (u - 60, v + 20), _place(attrs, "ball_1"), "does not swing about it")


@quiet
def test_clicks_on_the_rod_and_the_wrong_way_round_blame_no_pivot(film):
    path, attrs = film("plain")
    pivot, ball = (np.array(_place(attrs, name)) for name in ("pivot", "ball_1"))
    for clicks in ((pivot, 0.5 * (pivot + ball)), (ball, pivot)):
        with pytest.raises(InputError) as caught:
            ll.track(path, pivot=clicks[0], balls=[clicks[1]], length=SWING.length)
        assert re.search(r"middle of the ball|ball that swings, and not at", caught.value.way_out)


@quiet
@pytest.mark.parametrize("click", [(60, 60), (160, 120)])
def test_a_click_on_a_textured_wall_is_not_followed(film, click):
    path, attrs = film("texture", background="texture")
    assert _ok_share(path, _place(attrs, "pivot"), click) < 0.05


@quiet
def test_a_wrong_radius_is_refused_with_both_radii(film, capsys, tmp_path):
    path, attrs = film("plain")
    pivot, ball = _place(attrs, "pivot"), _place(attrs, "ball_1")
    assert _ok_share(path, pivot, ball, length=SWING.length, radius=0.01) < 0.05
    output = tmp_path / "none.csv"
    clicks = ["--pivot", "{:g},{:g}".format(*pivot), "--ball", "{:g},{:g}".format(*ball)]
    arguments = ["--length", "36.3 cm", "--radius", "4 cm", "--output", str(output)]
    assert main(["track", str(path), *clicks, *arguments]) == 2
    assert re.search("declared radius is.*check radius and length", capsys.readouterr().err)
    assert not list(tmp_path.iterdir())


@quiet
def test_a_ball_of_the_walls_colour_is_not_followed(film):
    path, attrs = film("invisible", ball_colour=WALL, wall_colour=WALL, ambient=1.0, gloss=0.0)
    assert _ok_share(path, _place(attrs, "pivot"), _place(attrs, "ball_1")) < 0.05


@quiet
def test_a_still_video_is_not_followed(film, tmp_path):
    path, attrs = film("plain")
    still = rewritten(path, tmp_path / "still.mp4", lambda frames, k: frames[0][1])
    assert _ok_share(still, _place(attrs, "pivot"), _place(attrs, "ball_1")) < 0.05


def test_a_good_track_has_no_finding(swing):
    table = ll.track(swing.path, pivot=swing.pivot, balls=swing.balls, length=swing.length)
    assert (table.flag_1 == "ok").mean() > 0.95
    assert "warnings" not in table.attrs or "camera" not in table.attrs["warnings"]


# Drawn pictures, whose truth needs no tracker.

SIZE = (240, 320)


def _drawn(centres, radius=12.0, shifts=None, texture=40.0, ball=-90.0):
    """Return a sample of pictures of a disc before a textured wall."""
    rng = np.random.default_rng(4)
    wall = rng.normal(0.0, 1.0, (SIZE[0] // 4 + 20, SIZE[1] // 4 + 20))
    wall = np.kron(wall, np.ones((4, 4)))
    wall = 150.0 + texture * (wall - wall.mean()) / 3.0
    v, u = np.mgrid[: SIZE[0], : SIZE[1]]
    grey = np.full((SIZE[0] // 2, SIZE[1] // 2), 128, np.uint8)
    frames = []
    for k, centre in enumerate(centres):
        x, y = (0, 0) if shifts is None else shifts[k]
        luma = wall[20 + y : 20 + y + SIZE[0], 20 + x : 20 + x + SIZE[1]].copy()
        cover = np.clip(radius + 0.5 - np.hypot(u - centre[0], v - centre[1]), 0.0, 1.0)
        luma += cover * (150.0 + ball - luma)
        luma += rng.normal(0.0, 1.0, SIZE)
        frames.append(Frame(k, k / 30.0, np.clip(luma, 0, 255).astype(np.uint8), grey, grey))
    return Sample(np.arange(len(frames)) / 30.0, frames)


def _swinging(count=30):
    angle = 0.8 * np.cos(np.arange(count) / 4.0)
    return np.stack([160.0 + 150.0 * np.sin(angle), 30.0 + 150.0 * np.cos(angle)], axis=-1)


def _track(centres, radius=12.0):
    track = Positions.unknown(np.arange(len(centres)) / 30.0, 1, radius)
    track.centres[:, 0], track.pivots[:], track.flags[:] = centres, [160.0, 30.0], "ok"
    return track


def test_the_ball_that_swings_passes_every_check():
    centres = _swinging()
    assert gate.examine(_drawn(centres), _track(centres), centres[:1], 11.0) == []


def test_a_ball_beside_the_click_is_refused():
    centres = _swinging()
    track = _track(centres)
    assert gate.clicked_ball(track, [centres[0] + [0.0, 14.0]]) is None
    far = gate.clicked_ball(track, [centres[0] + [0.0, 16.0]])
    assert far is not None
    assert far.is_refusal
    assert "16 pixels" in far.fault.rule


def test_a_ball_that_comes_to_the_click_only_later_is_refused():
    centres = _swinging()
    track = _track(centres)
    track.flags[:3] = "lost"
    assert gate.clicked_ball(track, [centres[0]]) is None
    track.flags[3] = "lost"
    late = gate.clicked_ball(track, [centres[4]])
    assert late is not None
    assert late.is_refusal
    assert "4 frames" in late.fault.rule


def test_a_cut_is_told_and_what_follows_it_given_up():
    whole = _swinging(90)
    cut = np.concatenate([whole[:40], whole[52:]])
    assert gate.uncut_clip(_track(whole)) is None
    found = gate.uncut_clip(_track(cut))
    assert found is not None
    assert "it is cut at 1.333 s" in found.fault.rule
    assert np.flatnonzero(found.doubtful[:, 0]).tolist() == [40]


def test_a_single_wrong_place_is_no_cut():
    centres = _swinging(90)
    centres[40] += 80.0
    assert gate.uncut_clip(_track(centres)) is None


def test_a_pause_is_told_and_given_up():
    whole = _swinging(90)
    stop = 45  # on its way, not at a turning point
    centres = np.concatenate([whole[:stop], np.repeat(whole[stop : stop + 1], 20, 0), whole[stop:]])
    found = gate.uncut_clip(_track(centres))
    assert found is not None
    assert "stands still from 1.5 to 2.167 s" in found.fault.rule
    assert np.flatnonzero(found.doubtful[:, 0]).tolist() == list(range(46, 66))


def test_a_ball_that_a_hand_holds_and_releases_is_no_pause():
    whole = _swinging(90)
    held = np.concatenate([whole[:26], np.repeat(whole[25:26], 20, 0), whole[26:]])
    assert gate.uncut_clip(_track(held)) is None


@pytest.mark.parametrize(
    "declared,passes", [(9.0, True), (7.9, False), (17.9, True), (18.1, False)]
)
def test_the_radius_may_differ_by_half(declared, passes):
    finding = gate.declared_radius(_track(_swinging()), declared)
    assert (finding is None) is passes


def test_what_rests_is_refused():
    places = np.tile([100.0, 100.0], (30, 1)) + np.random.default_rng(1).normal(0, 0.3, (30, 2))
    finding = gate.moving_ball(_track(places))
    assert finding is not None
    assert finding.is_refusal
    moves = places + np.arange(30)[:, None] * [0.2, 0.0]
    assert gate.moving_ball(_track(moves)) is None
    assert gate.moving_ball(_track(moves, radius=80.0)) is not None


@pytest.mark.parametrize("step", [1, 0])
def test_the_cameras_motion_is_measured(step):
    centres = _swinging(16)
    shifts = [(step * k, step * (k // 2)) for k in range(16)]
    _, motions, unknown = camera_motions(
        _drawn(centres, shifts=shifts), [Bar(centres[0], centres[0], 18.0)]
    )
    assert unknown == 0.0
    # The last but one frame has the second largest shift.
    assert farthest(motions).moved == pytest.approx(step * np.hypot(14, 7), abs=0.6)


def test_a_swing_filmed_by_hand_is_warned_of_and_what_moves_with_the_wall_refused():
    shifts = [(k // 4, k // 8) for k in range(24)]
    moves = np.array(shifts, float)
    centres = _swinging(24) - moves
    sample = _drawn(centres, shifts=shifts)
    finding = gate.resting_camera(sample, _track(centres))
    assert finding is not None
    assert not finding.is_refusal
    carried = gate.resting_camera(sample, _track(np.array([60.0, 180.0]) - moves))
    assert carried is not None
    assert carried.is_refusal
    assert "moves with it" in carried.fault.rule


def test_a_camera_before_a_plain_wall_is_unknown():
    centres = _swinging(16)
    _, motions, _ = camera_motions(
        _drawn(centres, texture=0.0), [Bar(centres[0], centres[0], 18.0)]
    )
    assert farthest(motions) is None


@pytest.mark.parametrize("texture", [0.0, 40.0])
def test_a_path_that_no_ball_runs_along_is_refused(texture):
    sample = _drawn(_swinging(), texture=texture)
    wrong = _swinging() * [1.0, 0.0] + [0.0, 60.0]
    finding = gate.changing_pixels(sample, _track(wrong))
    assert finding is not None
    assert finding.is_refusal


def test_a_disc_much_larger_than_the_ball_is_refused():
    centres = _swinging()
    finding = gate.changing_pixels(_drawn(centres, radius=6.0), _track(centres, radius=20.0))
    assert finding is not None
    assert finding.is_refusal


def test_the_part_of_a_track_that_leaves_the_ball_is_taken_back():
    centres = _swinging(40)
    followed = centres.copy()
    followed[32:] = centres[:8] * [1.0, 0.0] + [0.0, 60.0]
    finding = gate.changing_pixels(_drawn(centres), _track(followed))
    assert finding is not None
    assert not finding.is_refusal
    assert finding.doubtful[34:].all()
    assert not finding.doubtful[:30].any()


def test_a_disc_about_the_middle_of_the_ball_is_warned_of():
    centres = _swinging()
    finding = gate.changing_pixels(_drawn(centres, radius=20.0), _track(centres, radius=6.0))
    assert finding is not None
    assert not finding.is_refusal
    assert "part of something larger" in finding.fault.rule


def test_two_discs_that_may_be_parts_of_one_ball_are_refused():
    centres = _swinging()
    track = Positions.unknown(np.arange(len(centres)) / 30.0, 2, 6.0)
    aside = np.array([7.0, 0.0])
    track.centres[:] = np.stack([centres - aside, centres + aside], axis=1)
    track.pivots[:], track.flags[:] = [160.0, 30.0], "ok"
    finding = gate.changing_pixels(_drawn(centres, radius=20.0), track)
    assert finding is not None
    assert finding.is_refusal
    assert "part of something larger" in finding.fault.rule


@pytest.mark.parametrize(
    "extent,place,reason",
    [(16.0, [100.0, 150.0], None), (16.0, [220.0, 150.0], "change"), (3.0, [100.0, 150.0], "too")],
)
def test_a_disc_that_moves_by_less_than_its_radius_is_believed_by_its_edge(extent, place, reason):
    path = np.stack([0.5 * extent * np.cos(np.arange(30) / 4.0), np.zeros(30)], axis=-1)
    sample = _drawn(np.array([100.0, 150.0]) + path, radius=40.0)
    finding = gate.changing_pixels(sample, _track(np.array(place) + path, radius=40.0))
    assert (finding.is_refusal and reason in finding.fault.rule) if reason else finding is None


def test_a_ball_before_a_background_that_changes_is_refused_for_that(monkeypatch):
    shares = np.tile([1.0, 0.83, 0.33, 1.0], (30, 1, 1))
    monkeypatch.setattr(gate, "change_shares", lambda sample, track: (np.arange(30), shares))
    finding = gate.changing_pixels(_drawn(_swinging()), _track(_swinging()))
    assert finding.is_refusal
    assert "cannot be told from the background, which changes as well" in finding.fault.rule
    assert "background at rest" in finding.fault.way_out


def test_light_that_changes_for_all_changes_nothing():
    centres = _swinging()
    sample = _drawn(centres)
    brighter = [
        Frame(f.number, f.time, np.minimum(f.luma, 225) + np.uint8(f.number), f.blue, f.red)
        for f in sample.frames
    ]
    assert gate.changing_pixels(Sample(sample.times, brighter), _track(centres)) is None


# Every way of filming that `latolato synthesise` knows, in pictures as small as the gate accepts,
# and other materials. The gate examines each ball by itself: a few films of two balls are enough.
ODD = {
    "mirror": {"ball_colour": "#c9ccd1", "metal": 1.0, "gloss": 1.0},
    "white": {"ball_colour": "#ffffff", "background": "gradient"},
    "black": {"ball_colour": "#101010", "background": "texture"},
    "banded": {"pattern": 0.5},
}
# These have what the gate looks at, each in another way: walls and balls that look alike or change,
# smears, noise, time stamps, pictures that are turned or bent, balls that are hidden or meet.
QUICK = {
    *("wood", "variable", "rotated", "blur", "lowlight", "compressed", "lens", "mirror"),
    *("occluded-two", "steel-two"),
}
FILMED = [
    pytest.param(*values, id=name, marks=[] if name in QUICK else [pytest.mark.slow])
    for name, values in (
        {name: (SWING, name, {}) for name in conditions}
        | {name: (SWING, "clean", scene) for name, scene in ODD.items()}
        | {f"{name}-two": (TOY, name, {}) for name in ("clean", "occluded", "steel")}
    ).items()
]


@quiet
@pytest.mark.parametrize("system,name,scene", FILMED)
def test_every_way_of_filming_passes_the_gate_whole(system, name, scene, tmp_path, monkeypatch):
    turned = conditions[name].make()[1].rotation in (90, 270)
    size = {"width": 360, "height": 480} if turned else {"width": 480, "height": 360}
    run = ll.simulate(system, DRIVE, initial_angle=0.9, duration=0.8)
    made = conditions[name].make({"ball_radius": 0.02, **scene}, size)
    path = tmp_path / "clip.mp4"
    clicks = synthesise_video(run, path, *made, seed=3).attrs
    findings = []
    monkeypatch.setattr(follow, "examine", lambda *seen: findings.append(gate.examine(*seen)) or [])
    ll.track(
        path,
        pivot=_place(clicks, "pivot"),
        balls=[_place(clicks, ball) for ball in ("ball_1", "ball_2")[: 1 + (system is TOY)]],
        length=clicks["length"],
        radius=clicks["radius"],
    )
    assert findings
    assert not any(findings)


def test_a_track_with_few_clean_samples_says_so_and_why(film, capsys):
    path, attrs = film("half hidden", post_width=0.3, post_x=-0.26)
    pivot, ball = (tuple(map(round, _place(attrs, name))) for name in ("pivot", "ball_1"))
    expected = r"only \d+ % of the samples are ok \(.*% lost.*\): most of the others lie between"
    with pytest.warns(RuntimeWarning) as caught:
        table = ll.track(path, pivot=pivot, balls=[ball])
    assert [
        one for one in caught if re.search(f"{expected}.* look at the overlay", str(one.message))
    ]
    assert re.search(expected, table.attrs["warnings"])
    assert (table.flag_1 == "ok").mean() < 0.7
    main(["track", str(path), "--pivot", "{},{}".format(*pivot), "--ball", "{},{}".format(*ball)])
    assert re.search(r"only \d+ % of the samples are ok", capsys.readouterr().out)


def _followed(flags, step=1.0):
    """A track of one ball with flags, which moves by `step` pixels from frame to frame."""
    seen = Positions.unknown(np.arange(len(flags)) / 10.0, 1, radius=10.0)
    seen.centres[:] = 0.0
    seen.centres[:, 0, 0] = step * np.arange(len(flags))
    seen.angles[:] = 0.0
    seen.flags[:, 0] = flags
    return seen


@pytest.mark.parametrize(
    "flags,step,reason",
    [
        (["ok"] * 10 + ["lost"] * 10, 1.0, "lie between 1 and 1.9 s"),
        (["ok", "ok", "lost"] * 7, 45.0, "moves by 2.2 of its diameters"),
        (["ok", "occluded"] * 10, 1.0, "partly hidden"),
        (["ok", "lost"] * 10, 1.0, "the camera looks at an angle"),
    ],
)
def test_the_likely_reason_for_few_clean_samples(flags, step, reason):
    assert reason in _followed(flags, step).gaps_text(np.ones(len(flags), bool))


def test_frames_that_repeat_a_picture_do_not_make_a_track_poor():
    flags = ["ok", "lost"] * 10
    assert _followed(flags).clean_share(np.arange(20) % 2 == 0) == 1.0


@quiet
def test_a_ball_that_fingers_cover_at_first_is_learned_where_it_swings(tmp_path):
    run = ll.simulate(SWING, initial_angle=0.9, duration=2.5)
    path, camera = tmp_path / "free.mp4", Camera(width=400, height=300)
    truth = synthesise_video(run, path, Scene(ball_radius=0.03), camera, seed=3)
    pivot, ball = (tuple(map(round, _place(truth.attrs, name))) for name in ("pivot", "ball_1"))
    (u, v), radius, held = ball, 16, 30

    def in_fingers(frames, k):
        picture = frames[max(k - held, 0)][1].copy()
        rows = range(v - radius, v + radius, radius // 2) if k < held else ()
        for row in rows:
            picture[row : row + radius // 4, u - 14 :] = 120, 70, 60
        picture[v - radius - 3 : v + radius + 3, u + 2 :] = 120, 70, 60
        return picture

    clip = rewritten(path, tmp_path / "held.mp4", in_fingers)
    table = ll.track(clip, pivot=pivot, balls=[ball], length=0.363)
    ok = table.flag_1.values[held:] == "ok"
    errors = table.angle_1.values[held:] - truth.angle_1.values[:-held]
    assert ok.mean() > 0.75  # 0.35 where it is learned from the first frame
    assert np.sqrt(np.mean(errors[ok] ** 2)) < 1e-3


@quiet
def test_two_balls_that_meet_are_not_taken_for_one(tmp_path):
    toy = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.9)
    run = ll.simulate(toy, DRIVE, initial_angle=0.6, duration=1.5)
    path, camera = tmp_path / "toy.mp4", Camera(width=320, height=240, pixels_per_metre=400.0)
    attrs = synthesise_video(run, path, Scene(), camera, seed=3).attrs
    pivot, ball = _place(attrs, "pivot"), _place(attrs, "ball_1")
    _assert_refused(path, pivot, ball, "a second ball that looks the same meets this one")
