/** The sound of two balls that meet: a short burst of noise, as hard wood gives it. */

const LENGTH = 0.06; // s
// The burst dies away by this factor in so long.
const DECAY = 0.012; // s
// Balls that meet above the hand sound a little higher.
const PITCH = { bottom: 1500, top: 1900 }; // Hz
const SHARPNESS = 3;
// The harder the balls meet, the brighter the burst.
const BRIGHTNESS = [2500, 9000]; // Hz
const VOLUME = 1.6;

/**
 * Return noise that dies away; it is the same each time.
 * @param {BaseAudioContext} context
 */
export function makeBurst(context) {
  const burst = context.createBuffer(1, Math.ceil(LENGTH * context.sampleRate), context.sampleRate);
  const samples = burst.getChannelData(0);
  let seed = 1;
  for (let i = 0; i < samples.length; i += 1) {
    seed = (16807 * seed) % 2147483647; // Park and Miller, 1988
    samples[i] = (2 * seed / 2147483647 - 1) * Math.exp(-i / (DECAY * context.sampleRate));
  }
  return burst;
}

/**
 * Play the sound of balls that meet at an instant.
 * @param {AudioBuffer} burst
 * @param {AudioNode} out
 * @param {number} at [s] of the context
 * @param {number} loudness from 0 to 1
 * @param {"bottom" | "top"} kind
 */
export function playClack(burst, out, at, loudness, kind) {
  const { context } = out;
  const source = new AudioBufferSourceNode(context, { buffer: burst });
  const [dull, bright] = BRIGHTNESS;
  const wood = new BiquadFilterNode(context,
    { type: "bandpass", frequency: PITCH[kind], Q: SHARPNESS });
  const force = new BiquadFilterNode(context,
    { type: "lowpass", frequency: dull + loudness * (bright - dull) });
  source.connect(wood).connect(force)
    .connect(new GainNode(context, { gain: VOLUME * loudness })).connect(out);
  source.start(at);
}
