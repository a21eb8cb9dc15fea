/** Videos of the page: numbers with deviations, flags, and the frames of the clock. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { isAsFound, pivotAndBalls } from "../../../src/latolato/app/static/js/measure/session.js";
import { ClipClock } from "../../../src/latolato/app/static/js/measure/video_clock.js";
import { clockText } from "../../../src/latolato/app/static/js/measure/setup.js";
import { panelsOf, Track } from "../../../src/latolato/app/static/js/measure/track.js";
import { valueAt } from "../../../src/latolato/app/static/js/player/traces.js";
import { toPlace, withSigma } from "../../../src/latolato/app/static/js/page/unit_text.js";

test("a number is told to the second digit of its deviation", () => {
  assert.equal(withSigma(0.0027411, 1.2e-6), "0.0027411 ± 0.0000012");
  assert.equal(withSigma(-123.456, 0.2), "−123.46 ± 0.20");
  assert.equal(withSigma(2.7e-5, 1e-7), "(2.700 ± 0.010) × 10⁻⁵");
  assert.equal(withSigma(20, 150), "20 ± 150");
  assert.equal(withSigma(5, 0), "5");
  assert.equal(withSigma(NaN, 1), "–");
});

test("the ends of an interval have the digits of the standard deviation", () => {
  assert.equal(toPlace(1.209257, 8.2e-6), "1.2092570");
  assert.equal(toPlace(-0.5, 0.01), "−0.500");
  assert.equal(toPlace(123456, 300), "123460");
  assert.equal(toPlace(-3.14e-5, 2e-7), "−3.14 × 10⁻⁵");
  assert.equal(toPlace(5, NaN), "5");
  assert.equal(toPlace(-0.0002, 0.01), "0.000");
  // Sigma decides, also where the value is much smaller: both are read as one number.
  assert.equal(withSigma(3e-5, 0.01), "0.000 ± 0.010");
  assert.equal(toPlace(3e-5, 0.01), "0.000");
  assert.equal(toPlace(0, 0.01), "0.000");
  assert.equal(toPlace(3e-7, 5e-5), "0");
  // Below the place of that digit, 100, a value is rounded to it.
  assert.deepEqual([95, 60, 40, -60, -40].map((value) => toPlace(value, 3000)), ["100", "100", "0", "−100", "0"]);
  assert.equal(toPlace(9.6e-7, 5e-5), "10⁻⁶");
});

const track = (afterGaps = []) => new Track({
  about: { balls: 1, width: 100, height: 80, flags: ["ok", "collision", "occluded", "lost"],
    after_gaps: afterGaps,
    attributes: { geometry: "metric", radius_pixels: 5 } },
  arrays: {
    time: Float64Array.from([1, 1.1, 1.2, 1.3]), media_time: Float64Array.from([0, 0.1, 0.2, 0.3]),
    flag: Uint8Array.from([0, 2, 2, 3]), pivot: Float32Array.from([50, 50, 50, 50, 9, 9, 9, 9]),
    centre: Float32Array.from([10, 20, 30, 40, 60, 61, 62, NaN]),
  },
  shapes: { flag: [1, 4], pivot: [2, 4], centre: [2, 4] },
});

test("stretches of one flag are one shade, half a frame wider to both sides", () => {
  const found = track().shades().map(({ from, to, paint }) =>
    [from.toFixed(3), to.toFixed(3), paint]);
  assert.deepEqual(found, [["0.050", "0.250", "flag-occluded"], ["0.250", "0.350", "flag-lost"]]);
  assert.deepEqual(track().counts(), [{ flag: "ok", count: 1 }, { flag: "occluded", count: 2 },
    { flag: "lost", count: 1 }]);
});

test("no curve is drawn over a gap between samples, which is shaded", () => {
  const [shade] = track([2]).shades();
  assert.deepEqual([shade.from.toFixed(3), shade.to.toFixed(3), shade.paint], ["0.100", "0.200", "flag-lost"]);
  const [{ values }] = track([2]).perBall(() => [1, 2, 3, NaN], 10);
  assert.deepEqual(values, [10, 20, null, null]);
  // The legend of the chart has no value there either.
  assert.deepEqual([0, 1, 1.5, 2].map((time) => valueAt([0, 1, 2, 3], values, time)), [10, 20, NaN, NaN]);
  const [{ label }] = panelsOf(track([2]));
  assert.equal(label, "angle [°]; shaded where there are no samples");
});

test("places are those of the frame", () => {
  const { pivot, balls, ghosts } = track().places(2);
  assert.deepEqual([pivot, balls, ghosts], [{ u: 50, v: 9 }, [{ u: 30, v: 62 }], []]);
});

test("the clock asks for the middle of a frame and tells the one on show", () => {
  const video = new EventTarget();
  Object.assign(video, { seeking: false, currentTime: 0, pause() {}, paused: true });
  const clock = new ClipClock(video);
  clock.load(Float64Array.from([0, 0.1, 0.3]), Float64Array.from([0, 0.1, 0.3]));
  clock.go(1);
  assert.ok(video.currentTime > 0.1 && video.currentTime < 0.3);
  video.dispatchEvent(new Event("seeked"));
  assert.equal(clock.index, 1);
  assert.equal(clock.time, 0.1);
  clock.seek(0.29);
  assert.ok(video.currentTime > 0.3);
  video.seeking = true;
  clock.go(0);
  clock.go(1);
  assert.ok(video.currentTime > 0.3);
  video.seeking = false;
  video.dispatchEvent(new Event("seeked"));
  assert.ok(video.currentTime > 0.1 && video.currentTime < 0.3);
});

test("a pivot or ball that nobody touched stays found", () => {
  const proposed = { pivot: { u: 5, v: 1 }, ball_1: { u: 7, v: 9 } };
  const clip = { about: { proposal: { click_frame: 4 } }, clickFrame: 4, isPivotOutside: false,
    places: { ...proposed, stick_1: { u: 0, v: 0 } }, pointed: new Set(), proposed };
  const found = { pivot: [5, 1], balls: [[7, 9]], is_pivot_found: true, is_proposed: true };
  assert.deepEqual([pivotAndBalls(clip), isAsFound(clip)], [found, true]);
  assert.equal(isAsFound({ ...clip, clickFrame: 5 }), false);
  clip.pointed.add("ball_1");
  assert.deepEqual([pivotAndBalls(clip), isAsFound(clip)], [found, false]);
  clip.pointed.add("pivot");
  assert.deepEqual(pivotAndBalls(clip), { ...found, is_pivot_found: false, is_proposed: false });
  clip.places.ball_2 = { u: 1, v: 2 };
  clip.isPivotOutside = true;
  assert.deepEqual(pivotAndBalls(clip), { pivot: "outside", balls: [[7, 9], [1, 2]], is_pivot_found: false,
    is_proposed: true });
});

test("what a file says of slow motion is told, and nothing of one at life's pace", () => {
  const clock = { capture_rate: 240, shown_rate: 30.00003, slow_motion: 8, is_sure: true };
  assert.match(clockText(clock), /240 frames a second filmed, 30 shown.* divided by 8/);
  assert.match(clockText({ ...clock, is_sure: false }), /if this is slow motion, give the factor 8/);
  assert.equal(clockText({ ...clock, slow_motion: 1 }), "");
  assert.equal(clockText(undefined), "");
});
