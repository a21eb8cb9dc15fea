/**
 * Every text of the pages, by name, in English; another language is a table in `languages`.
 *
 * A text is a string with gaps, or one for each plural form of its gap `count`.
 * @typedef {string | Record<string, string>} Text
 *
 * A language: its own name, the texts of the pages by their names, and texts that are born as data
 * (titles of presets, labels of parameters, rules of refusals) by the English ones. There a gap
 * stands for whatever the English text has in its place.
 * @typedef {{name: string, beta?: boolean, strings: Record<string, Text>, texts: Record<string, string>}} Language
 */

export const STRINGS = {
  themeLight: "Light",
  themeDark: "Dark",
  themeAuto: "Auto",
  themeLabel: "Colours: {name}. Change them.",
  skip: "Skip to the content",
  views: "Views",
  language: "Language",
  languageBeta: "{name} (beta)",
  languageUnknown: "The link asks for the language “{name}”, which is not here. The page is in {spoken}.",
  languageUnread: "The texts in {name} could not be loaded, so the page is in English.",
  warning: "Note: {text}",
  program_experiment: "Experiment follows a pendulum in a video, fits its damping and its drive, and "
    + "compares many trials with the theory. Videos are read by the installed program, on your own machine.",
  program_analyse: "Analyse asks one toy a question: does it return after each shake, how strongly does it "
    + "feel small differences, which push decides? These analyses are computed by the installed program.",
  programHow: "This site has no program behind it. Install latolato (its documentation says how) and start",
  view_play: "Play",
  view_map: "Map",
  view_live: "Live",
  view_paper: "Paper",
  view_experiment: "Experiment",
  view_analyse: "Analyse",
  unknownView: "There is no view “{name}”.",
  newerAddress: "This link was made by a newer latolato, so it was not opened.",
  offline: "The server does not answer. The page tries again by itself.",
  // forms
  preset: "Begin with",
  presetNone: "— own values —",
  system: "System",
  drive: "Drive",
  start: "Start and duration",
  more: "More",
  unitOf: "unit of {name}",
  sliderOf: "{name}, slider",
  oneNumber: "One number belongs here. Decimals follow a point: {text}",
  addRow: "Add a row",
  removeRow: "Remove row {number}",
  // player
  animation: "Animation of pivot, rods and balls",
  play: "Play",
  pause: "Pause",
  stepBack: "One step back",
  stepForward: "One step on",
  scrub: "Instant",
  speed: "Speed",
  loop: "Loop",
  arrows: "Arrows",
  sound: "Sound",
  arrowsHint: "velocity and force of each ball",
  timeText: "t = {time} s",
  speedText: "{speed}×",
  curveAngle: "angle [°]",
  curveEnergy: "energy, all balls [J]",
  curvePower: "power, all balls [W]",
  time: "time [s]",
  phase: "Phase portrait",
  section: "Stroboscopic section",
  sectionHint: "one point each drive period",
  contacts: "Contacts",
  noContacts: "The balls never touch.",
  contactsMore: "the first {shown} of {count}",
  ledger: "Where the energy goes",
  ledgerHint: "What came in equals what went out plus what is left: each side adds up to 100 %.",
  cameIn: "In",
  wentOut: "Out, and left",
  atStart: "at the start",
  noise: "random kicks",
  impacts: "impacts",
  capture: "coming to rest",
  left_over: "left at the end",
  angle: "angle",
  angularVelocity: "angular velocity",
  kind: "kind",
  before: "before [rad/s]",
  after: "after [rad/s]",
  ball: "ball",
  right: "right ball",
  left: "left ball",
  kinetic: "kinetic",
  potential: "potential",
  total: "total",
  drivePower: "drive",
  dampingPower: "damping",
  code: "Python and command line",
  codeHint: "These lines make the same run.",
  // a cell of a notebook
  cellBack: "Back to the run of this cell",
  cellHint: "Other values are computed here in the page, without a kernel.",
  cellBeyond: "Only Python can compute this run with other values: pages do not have its law “{name}”.",
  copy: "Copy",
  copied: "Copied.",
  download: "Download",
  share: "Copy the address",
  pin: "Pin this run",
  unpin: "Take the pin off",
  pinned: "pinned",
  hand: "the hand",
  recordingGone: "That recording is no longer here: a page keeps it until it is reloaded. Recordings last as downloads.",
  // live
  liveStage: "The toy, running. Drag a ball with the mouse or a finger; keys steer it.",
  liveTry: "Try the trick of Fig. 12",
  liveHint: "At a low frequency the resting balls stay together, however long you wait. First high, then low gets them swinging:",
  liveStep1: "Go high and wait until the balls fly apart:",
  liveStep2: "then go low: they swing far higher.",
  liveMore: "If they stay together, take a little more amplitude: at 34 mm they always lift off, at the 30 mm assumed for Fig. 12 only sometimes.",
  highFrequency: "High: {ratio} ω₀",
  lowFrequency: "Low: {ratio} ω₀",
  liveControls: "Change it while it runs",
  liveKeys: "Drag a ball, or use the keys beside the names. Also P push, Space pause, R restart, C record.",
  liveReadout: "t = {time} s · drive at {ratio} ω₀ · {count} contacts",
  liveReadoutOne: "t = {time} s · drive at {ratio} ω₀",
  ratioText: "{ratio} ω₀",
  push: "Push",
  restart: "Restart",
  record: "● Record",
  stopRecording: "■ Stop ({time} s)",
  recorded: "Recorded {time} s.",
  recordedExact: "Its parameters make the same motion again, to rounding.",
  recordedHand: "A hand took part, so no parameters make it again: what opens is the recording itself, 240 samples a second.",
  recordedChaos: "The motion was chaotic: recomputed, it diverges from what you saw, so what opens is the recording itself.",
  recordedNote: "recorded live",
  recordedHandNote: "recorded live: a hand took part, so no scenario makes it again; noise_work is the work of the hand",
  openInPlay: "Open in Play",
  lastSeconds: "time from now [s]",
  liveCosine: "Here the pivot moves as a cosine, with the amplitude and frequency that this drive begins with.",
  liveHidden: "The toy was paused while its tab was in the background.",
  liveSlow: " · this device reaches {share}× real time",
  liveFault: "The toy starts again: {text}.",
  noNumber: "“{text}” is no number with a known unit.",
  outOfRange: "It must lie between {low} and {high} {unit}.",
  // map
  cut: "{text}…",
  mapSource: "Map of",
  mapShipped: "Maps of the paper",
  mapStored: "Opened files",
  mapOwn: "Your own",
  mapPage: "the toy of Play",
  mapFigure: "{title} (Fig. {figure})",
  mapIntro: "Every point of the picture is a run of its own: its place sets two parameters, its "
    + "colour shows what came of it. Click one to see it move.",
  mapAxes: "Axes",
  mapX: "To the right",
  mapY: "Upwards",
  mapFrom: "from",
  mapTo: "to",
  mapWhat: "What is shown",
  mapObservable: "Colour shows",
  mapTogether: "computed together",
  mapAlone: "others: a new computation each",
  mapBall: "Ball",
  mapSize: "Points",
  mapSizeText: "{n} × {n} ({points})",
  mapDuration: "each run lasts",
  mapTransient: "leave out the first",
  mapTransientHint: "time after which means and late angles begin",
  mapColours: "Colours",
  mapScale: "Scale",
  mapLog: "logarithmic",
  mapLogX: "logarithmic, to the right",
  mapLogY: "logarithmic, upwards",
  mapLogColours: "logarithmic colours",
  mapLogOf: "logarithmic: {name}",
  mapLow: "darkest at",
  mapHigh: "brightest at",
  mapLimits: "The darkest colour must stand for less than the brightest one.",
  mapOver: "Curves and trials",
  mapContours: "Contour lines",
  mapContoursNone: "none",
  mapContoursColours: "of what the colours show",
  mapContoursOf: "equal {what}",
  mapContoursLater: "Drawn when the map is finished, or stopped.",
  mapContoursFlat: "No round value lies between the least and the largest one.",
  mapContoursNowhere: "The map never passes these values.",
  mapContoursTiny: "Rings about single points are left out ({count}).",
  mapLevels: "at the values",
  mapLevelsOf: "Contour lines at these values of {what}; an empty field stands for round ones",
  noLevels: "“{text}” is no list of numbers. Try 10, 20, 50.",
  mapTongue: "Mathieu tongue (eq14)",
  mapLift: "lift-off from rest (A₀ω² = g)",
  tooManyLevels: "At most {most} values at a time, got {count}.",
  mapTrials: "Trial table",
  mapTrialsHint: "A CSV as “latolato trials” writes it: drive_amplitude, frequency, class.",
  mapTrialCount: {
    one: "{count} trial, {outside} of them outside the map.",
    other: "{count} trials, {outside} of them outside the map.",
  },
  mapParameters: "Parameters that do not vary",
  mapVaries: "varies over the map",
  mapBar: "Colour bar",
  mapKeys: "Map. Arrows move the cross, Enter shows the run there, plus and minus zoom, Shift with "
    + "arrows moves the map, Escape zooms out.",
  onePoint: "One point",
  mapPickHint: "Click a point of the map, or move the cross with the arrow keys and press Enter: its "
    + "run appears here.",
  mapHoverHint: "Click for a run. Drag a box to zoom in, with Shift to move. Escape zooms out.",
  mapGoOn: "Go on",
  mapAgain: "Compute again",
  mapBack: "Zoom out",
  mapIn: "Enlarge about the cross",
  mapOut: "Show twice as much",
  mapPan: "Move",
  mapFileHint_csv: "a row for each point, for a spreadsheet",
  mapFile_screen: "PNG of the screen",
  mapFile_png: "PNG for print",
  mapFileHint_screen: "the map as it is here, with its colour bar",
  mapFileHint_nc: "everything; opens again with “latolato app --open”",
  mapFileHint_zarr: "the same as a zipped store of “latolato sweep”",
  mapFileHint_png: "picture with axes, colours and curves",
  mapFileHint_svg: "the same, for print",
  mapFilesHint: "The page writes the first two. The program computes the map once more for the others, and "
    + "stores all observables that are computed together.",
  mapFilesProgram: "The installed program also stores NetCDF, Zarr and figures for print, and opens stored "
    + "maps: “latolato app --open FILE”.",
  mapFilesNone: "There is no map yet.",
  mapStoredPart: "{name} is stored. {missing} points are not computed yet.",
  mapProgress: "How much is computed",
  mapBegins: "Starting …",
  mapLong: "This map takes about {time}. Compute it?",
  mapRestarted: "A part of the computation ended unexpectedly ({message}) and was started again.",
  mapStoredProgram: "The installed program opens stored maps: “latolato app --open FILE”.",
  mapRate: "{percent} %, {rate} runs/s, {left} s left",
  mapDone: "{points} runs in {seconds} s, {rate} runs/s",
  mapDonePart: "{all} points, {points} of them new: {seconds} s, {rate} runs/s",
  mapKnown: "{points} points",
  mapKnownPart: "{points} points, {missing} of them not computed",
  mapMisread: "Ignored in the address, as it could not be read: {parts}.",
  mapStopped: "Stopped. What is computed stays.",
  mapNoAnswer: "no answer ({count})",
  mapZero: "zero or less ({count})",
  mapNone: "no answer ({status})",
  notYet: "not computed yet",
  noValue: "no value",
  mapCoarse: "(of a point nearby, so far)",
  mapStoredZoom: "A stored map has the points that it has.",
  mapCodeHint: "These lines compute the same map.",
  trial_none: "trial, none",
  trial_weak: "trial, weak",
  trial_strong: "trial, strong",
  bottom: "bottom",
  top: "top",
  rest: "rest",
  release: "release",
  // long work
  loading: "Loading …",
  computing: "Computing …",
  longRun: "This run takes about {count} minutes.",
  computeLong: "Compute it",
  stop: "Stop",
  runStopped: "The run was stopped.",
  workerAgain: "The computation failed and was started again.",
  workerGone: "the computation failed twice; reload the page",
  cancel: "Cancel",
  job_bar: "How far the work is",
  job_waiting: "Waiting for other work to end …",
  job_starting: "Starting a process for it … {seconds} s",
  job_working: "Working … {seconds} s",
  job_compiling: "Compiling, once for this kind of question (some 10 s) … {seconds} s",
  job_left: "Working … about {left} left",
  job_progress: "{percent} % done, {seconds} s",
  stored: "Stored {name}.",
  // downloads
  fileProgram: "The installed program also stores NetCDF files, figures and films of a run.",
  file_csv: "CSV",
  "file_contacts.csv": "CSV of contacts",
  file_nc: "NetCDF",
  file_zarr: "Zarr",
  file_png: "PNG",
  file_svg: "SVG",
  file_toml: "TOML",
  file_mp4: "Make an MP4",
  fileHint_csv: "a table for a spreadsheet",
  "fileHint_contacts.csv": "a row for each touch",
  fileHint_nc: "everything, for Python and others",
  fileHint_png: "picture of the run",
  fileHint_svg: "the same, for print",
  fileHint_toml: "the scenario, to run it again",
  fileHint_mp4: "The animation beside its curves, 30 pictures a second.",
  // paper
  paperTitle: "The paper’s claims, recalculated",
  paperLead: "What the paper on the Lato Lato 2.0 says, in its own words, beside what an " +
    "accurate calculation gives. Figures are computed as you reach them, with fewer points than " +
    "the full report of “latolato reproduce”. Every verdict follows from the numbers and limits " +
    "below it.",
  paperList: "Figures",
  paperAll: "Judge everything now (about half a minute)",
  paperOpen: "{count} of {total} not judged yet",
  paperUnjudged: "Not judged yet.",
  paperFilm: "Make this figure",
  paperUnread: "This figure could not be loaded, and this browser has not kept it. Come back to it when "
    + "there is a network.",
  paperTurn: "Waiting for its turn …",
  paperWaits: "Waiting for {name} …",
  paperFilmHint: "This makes and evaluates a synthetic experiment, in up to some tens of seconds. " +
    "The caption says what is filmed and tracked, and what is simulated with the tracker’s noise.",
  paperQuick: "Quick numbers: scans have fewer points than in the full report.",
  paperReport: "From the stored report.",
  paperAssumed: "Assumed:",
  paperCases: "Runs behind it ({count}):",
  openTitleInPlay: "Open in Play: {title}",
  openTitleInMap: "Open in Map: {title}",
  REPRODUCED: "reproduced",
  ASSUMED: "reproduced with an assumption",
  NOT_AS_PRINTED: "not as printed",
  METHOD_CHECK: "method check, not testable from the paper",
  shape_REPRODUCED: "●",
  shape_ASSUMED: "△",
  shape_NOT_AS_PRINTED: "✕",
  shape_METHOD_CHECK: "◇",
  // analyse
  questions: "Questions",
  compute: "Compute",
  askCost: "takes about {time}: press Compute",
  lawsOfQuestion: "System, drive and start",
  questionOf: "{title}: {system}, drive {drive}",
  termOf: "Physicists say: {term}.",
  moreSettings: "More settings",
  fromScenario: "as set",
  automatic: "automatic",
  yes: "yes",
  no: "no",
  numbers: "Numbers",
  codeAsks: "These lines ask the same.",
  pictureOf: "Picture: {name}",
  pointsOf: "Picture: {name} Arrow keys move the mark, Enter shows its run.",
  pointsHint: "Click a point (or move there with the arrow keys and press Enter) to see its run.",
  pointUse: "Ask about this point",
  pointSaid: "{values}.",
  pointSaidStart: "{values}. This run begins as set under “System, drive and start”.",
  unfitSystem: "Ask it of one pendulum with the same length and mass",
  unfitToy: "Ask it of a toy with two such balls",
  unfitDrive: "Shake the pivot",
  unknownQuestion: "There is no question “{name}”. This is another one.",
  unknownSetting: "“{name}” is no setting of this question and was left out.",
  seconds: "{count} s",
  minutes: "{count} min",
  held: "held",
  failed: "did not hold",
  // experiment
  clipDrop: "Drop a video here, or choose one",
  clipDropHint: "MP4, MOV, WebM, AVI: up to {size} MB, {minutes} minutes, {pixels}",
  clipPrivate: "It stays on this computer’s server and is removed when this page closes.",
  exampleHint: "No video at hand? Let the computer film one, with known truth:",
  example_decay: "A free swing that dies away",
  example_driven: "A pendulum on a driven pivot",
  example_toy: "Two colliding balls",
  steps: "From a video to numbers",
  step1: "Upload a video of a pendulum or of a Lato Lato. The camera must stand still.",
  step2: "The pivot and the balls are found automatically. Correct them in the first frame; give the "
    + "length from pivot to ball centre.",
  step3: "Track it. Look at every frame, at the curves, and at what they say about the motion.",
  clips: "Videos",
  clipRemove: "Remove {name}",
  clipsLost: "The connection to the server was lost; its videos are gone.",
  uploadTooLarge: "{name} is larger than {limit} MB, the limit for an upload.",
  clipLabel: "Frame of the video with what was found",
  setup: "Set-up",
  setupHint: "Drag the handles to pivot and ball centres, or move them with the arrow keys "
    + "(Shift: 10 pixels, Ctrl: a tenth). The circle is as large as length and radius say: it "
    + "should be the ball’s edge.",
  setupFound: "Found automatically: is it right?",
  setupNotFound: "Nothing was found automatically. Put the handles on pivot and ball.",
  setupNoPivot: "The pivot was not found: put its handle there, or tick under More that it is not "
    + "in the picture.",
  setupAgain: "Correct the set-up",
  setupBack: "Back to the result",
  findAgain: "As found",
  ballCount: "number of balls",
  scaleHint: "The length is the scale. Without it angles are known, but no metres. "
    + "The mass makes a damping coefficient of a decay rate.",
  pivotUnseen: "the pivot is not in the picture",
  pivot: "pivot",
  ball_1: "ball 1 (right)",
  ball_2: "ball 2 (left)",
  handle: "{name}: column {column}, row {row}. Arrow keys move it.",
  track: "Track",
  trackAgain: "Track again",
  cancelled: "Cancelled.",
  stage_uploading: "uploading",
  stage_waiting: "waiting",
  stage_starting: "starting a process",
  stage_compiling: "compiling, once",
  stage_working: "working",
  stage_painting: "filming the example",
  stage_reading: "reading the video",
  stage_finding: "looking for pivot and balls",
  stage_tracking: "tracking",
  stage_fitting: "fitting",
  stage_drawing: "drawing",
  progressOf: "{stage}, {percent} %",
  frame: "Frame",
  cannotPlay: "This browser does not play H.264, so there is no picture; tracking works all the "
    + "same.",
  frameBack: "One frame back",
  frameOn: "One frame on",
  frameText: "frame {frame} of {count}, t = {time} s",
  angleText: "{angle}° ± {sigma}°",
  overlay: "what was found",
  flag_ok: "seen",
  flag_ok_hint: "measured, apart from the other ball",
  flag_collision: "collision",
  flag_collision_hint: "measured while the balls touch",
  flag_occluded: "occluded",
  flag_occluded_hint: "measured, partly hidden",
  flag_predicted: "predicted",
  flag_predicted_hint: "not seen: carried on by the equation of motion",
  flag_lost: "lost",
  flag_lost_hint: "not seen, no number given",
  flagCount: "{flag} {count}",
  curvePlace: "column of the ball [pixel]",
  curveResidual: "measured minus model [mrad]",
  curvePivot: "pivot height [mm]",
  measured: "measured",
  model: "model",
  modelLeft: "model, left ball",
  fitOnce: "Fit the {name}",
  fitAgain: "Fit again with these values",
  quantity: "quantity",
  fitted: "fitted, with 95 % interval",
  truth: "truth",
  moreNumbers: "More numbers",
  export_csv: "Table (CSV)",
  export_nc: "Table (NetCDF)",
  export_toml: "Set-up (TOML)",
  export_overlay: "Video with overlay (MP4)",
  export_report: "Report on the quality (HTML)",
  export_trials: "Trial table (CSV)",
  trials: "Trials",
  trialsHint: "Every tracked video with a driven pivot is a trial: strong for 90° at any time, "
    + "weak for 45° that last, else none.",
  set: "set",
  video: "video",
  trialAmplitude: "amplitude A₀ [mm]",
  trialFrequency: "frequency ω [rad/s]",
  trialRatio: "ω/ω₀",
  trialLargest: "largest angle [°]",
  trialAfterTransient: "settled angle [°]",
  trialClass: "class",
  note: "note",
  class_none: "none",
  class_weak: "weak",
  class_strong: "strong",
  borderline: "borderline",
  notHere: "What this video does not show",
  notTracked: "not tracked yet",
  megapixels: "{count} megapixels",
};

export const ENGLISH = "en";
const GAP = /\{(\w+)\}/g;

/** What the page speaks. */
const spoken = {
  code: ENGLISH,
  /** @type {Record<string, Text>} */
  strings: STRINGS,
  /** @type {Map<string, string>} */
  texts: new Map(),
  /** Texts with gaps, those with most letters first. @type {{shape: RegExp, gaps: string[], text: string}[]} */
  shapes: [],
};

/** Return the code of the language of the page. */
export function languageCode() {
  return spoken.code;
}

/**
 * Speak a language from now on; what is on the page stays as it is.
 * @param {string} code
 * @param {Language} language
 */
export function setLanguage(code, { strings, texts }) {
  const letters = (/** @type {string} */ text) => text.replace(GAP, "").length;
  const shapes = Object.keys(texts).filter((text) => text.search(GAP) >= 0)
    .sort((a, b) => letters(b) - letters(a)).map((text) => ({ text: texts[text],
      gaps: Array.from(text.matchAll(GAP), ([, gap]) => gap),
      shape: new RegExp(`^${text.split(GAP).map((part, i) =>
        (i % 2 ? "(.*?)" : part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"))).join("")}$`) }));
  Object.assign(spoken, { code, strings: { ...STRINGS, ...strings }, texts: new Map(Object.entries(texts)),
    shapes });
}

/**
 * Return a text with its gaps filled.
 * @param {keyof typeof STRINGS | string} name
 * @param {Record<string, string | number>} [values]
 * @returns {string}
 */
export function t(name, values = {}) {
  const text = spoken.strings[name];
  if (text === undefined) throw new Error(`there is no text '${name}'`);
  if (typeof text === "string") return filled(text, values);
  const form = new Intl.PluralRules(spoken.code).select(Number(values.count));
  return filled(text[form] ?? text.other, values);
}

/**
 * Return a text that was born as data in the language of the page; as it is where that has none.
 * A label that begins a line, with a capital, is that of the label.
 * @param {string} text in English
 * @returns {string}
 */
export function tr(text) {
  const line = text.replace(/\s+/g, " ").trim();
  const known = spoken.texts.get(line);
  if (known !== undefined) return known;
  const [begun, capital] = [line.charAt(0).toLowerCase(), line.charAt(0).toUpperCase()];
  const label = capital === begun ? undefined : spoken.texts.get(begun + line.slice(1));
  if (label !== undefined) return label.charAt(0).toUpperCase() + label.slice(1);
  for (const { shape, gaps, text: other } of spoken.shapes) {
    const parts = shape.exec(line);
    if (parts) return filled(other, Object.fromEntries(gaps.map((gap, i) => [gap, tr(parts[i + 1])])));
  }
  return text;
}

/**
 * @param {string} text
 * @param {Record<string, string | number>} values
 */
function filled(text, values) {
  return text.replace(GAP, (_, gap) => String(values[gap]));
}
