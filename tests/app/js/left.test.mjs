// How much time is left: nothing before it is measured, then near the truth, never to and fro.
import assert from "node:assert/strict";
import { test } from "node:test";

import { statusText } from "../../../src/latolato/app/static/js/shared/jobs.js";
import { spanText, TimeLeft } from "../../../src/latolato/app/static/js/shared/left.js";

/** Return times left while work goes on at a rate that may change; by a clock of its own. */
function follow(seconds, rateAt, expected = null) {
  let time = 0;
  let done = 0;
  const left = new TimeLeft(expected, () => time);
  const told = [];
  for (time = 0.2; done < 1; time += 0.2) {
    done = Math.min(1, done + 0.2 * rateAt(time / seconds) / seconds);
    left.heed(done);
    told.push({ time, done, seconds: left.seconds });
  }
  return told;
}

test("no time is told before the first tenth or three seconds are done", () => {
  const told = follow(20, () => 1);
  for (const { time, done, seconds } of told)
    if (done < 0.9 && Math.abs(done - 0.1) > 1e-6 && Math.abs(time - 3) > 1e-6)
      assert.equal(seconds === null, done < 0.1 && time < 3, `${time} s`);
  assert.equal(new TimeLeft(null, () => 5).seconds, null);
});

test("what is told is near the truth for work at a steady rate", () => {
  for (const { time, seconds } of follow(60, () => 1))
    if (seconds !== null) assert.ok(Math.abs(seconds - (60 - time)) < 3);
});

test("the time left does not go up for work that is now faster, now slower", () => {
  const told = follow(60, (share) => 1 + 0.5 * Math.sin(300 * share))
    .filter(({ done, seconds }) => done < 0.9 && seconds !== null).map(({ seconds }) => seconds);
  assert.ok(told.length > 100);
  told.forEach((seconds, i) => assert.ok(i === 0 || seconds <= told[i - 1]));
});

test("work that becomes far slower is told so in few steps, and near the truth again", () => {
  const told = follow(100, (share) => (share < 0.2 ? 1 : 0.1));
  const rises = told.filter(({ seconds }, i) => i > 0 && seconds > (told[i - 1].seconds ?? 0)
    && told[i - 1].seconds !== null).length;
  assert.ok(rises > 0 && rises <= 8, `${rises} rises`);
  for (const { time, seconds } of told.slice(told.length / 2, -20))
    assert.ok(seconds > 0.6 * (820 - time) - 5 && seconds < 1.2 * (820 - time) + 1);
});

test("a halt within the work is measured neither before nor after it", () => {
  let time = 0;
  const left = new TimeLeft(null, () => time);
  for (; left.share < 0.24; time += 0.1) left.heed(left.share + 0.03);
  assert.ok(left.seconds < 4);
  time += 60; // it compiles
  left.heed(0.28);
  assert.equal(left.seconds, null);
  for (; left.share < 0.6; time += 0.1) left.heed(left.share + 0.02);
  assert.ok(Math.abs(left.seconds - (1 - left.share) / 0.2) < 0.5);
});

test("what was done before the first moment is no rate", () => {
  let time = 0;
  const left = new TimeLeft(null, () => time);
  left.heed(0.15);
  assert.equal(left.rate, 0);
  time = 1;
  left.heed(0.32);
  assert.ok(Math.abs(left.rate - 0.17) < 1e-9);
});

test("what was measured before counts until the work itself is measured", () => {
  let time = 0;
  const left = new TimeLeft(30, () => time);
  assert.equal(left.seconds, 30);
  time = 10;
  left.heed(0.5);
  assert.equal(left.seconds, 18); // eased from 20 towards 10
  for (; left.share < 0.9; time += 1) left.heed(left.share + 0.05);
  assert.ok(left.seconds < 3);
  time = 31;
  assert.equal(left.seconds, null);
  assert.equal(left.isLate, true);
});

test("words hold a time only where one was measured", () => {
  let time = 0;
  const status = { state: "working", elapsed: 2 };
  const words = (left, progress) => statusText({ ...status, progress }, left);
  const unknown = new TimeLeft(null, () => time);
  assert.match(words(unknown), /not known yet/);
  assert.match(words(unknown, 0.02), /^Timing the first steps/);
  assert.match(words(new TimeLeft(42, () => time)), /about 40 s left, measured from earlier/);
  time = 4;
  unknown.heed(0.1);
  assert.equal(words(unknown, 0.1), "10 % done, about 35 s left at this rate");
  time = 60;
  assert.match(words(unknown, 0.1), /longer than measured/);
  assert.equal(statusText({ state: "waiting", elapsed: 0 }, unknown),
    "Waiting for other work to finish …");
});

test("times are rounded to what is known of them", () => {
  assert.deepEqual([0.2, 7.4, 41.2, 88, 100, 3599].map(spanText),
    ["1 s", "7 s", "40 s", "90 s", "2 min", "60 min"]);
});
