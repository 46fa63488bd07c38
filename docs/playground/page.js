// The page: settings, presets, verdict, figures, logs.

const byId = (id) => document.getElementById(id);
const element = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};

// Settings, in the order in which the module takes them.
const NAMES = ['a', 'b', 'coulomb', 'load', 'load_step', 'delay', 'resonance', 'inertia_ratio', 'counts', 'limit',
  'kp', 'ki', 'kd', 'sample_time', 'cutoff', 'reference', 'amplitude', 'period', 'duration', 'seed'];
const COLUMNS = 13;
// Standard errors to either side that are an interval of 95 %, as in the program.
const SIDES = 2;
// Time after which the address has the settings, ms.
const LINK_REST = 300;

const PRESETS = {
  paper: { title: 'Paper', a: 0.2174, b: 257.7, coulomb: 0, load: 20, load_step: 0, delay: 0, resonance: 0, inertia_ratio: 0.5,
    counts: 10000, limit: 10, kp: 9, ki: 4, kd: 0.19, sample_time: 0.001, cutoff: 500, reference: 0, amplitude: 0.2236,
    period: 0.1, duration: 6, seed: 1212121 },
  joint: { title: 'Robot joint', a: 3, b: 60, coulomb: 6, load: 8, load_step: 0, delay: 0.001, resonance: 0, inertia_ratio: 0.5,
    counts: 65536, limit: 8, kp: 31, ki: 130, kd: 1.2, sample_time: 0.001, cutoff: 600, reference: 0, amplitude: 0.2,
    period: 0.12, duration: 6, seed: 5 },
  linear: { title: 'Linear axis', a: 2.5, b: 5, coulomb: 1.25, load: 0, load_step: 0, delay: 0, resonance: 0, inertia_ratio: 0.5,
    counts: 6283185, limit: 8, kp: 540, ki: 2700, kd: 17.5, sample_time: 0.001, cutoff: 400, reference: 1, amplitude: 0.004,
    period: 0.9, duration: 6, seed: 1, unit: 'm' },
  hobby: { title: 'Coarse hobby servo', a: 9, b: 900, coulomb: 25, load: 15, load_step: 0, delay: 0, resonance: 0,
    inertia_ratio: 0.5, counts: 1024, limit: 1, kp: 1.2, ki: 2, kd: 0.05, sample_time: 0.002, cutoff: 250, reference: 0,
    amplitude: 0.4, period: 0.2, duration: 8, seed: 7 },
  belt: { title: 'Compliant belt', a: 1.5, b: 120, coulomb: 4, load: 0, load_step: 0, delay: 0, resonance: 63,
    inertia_ratio: 0.7, counts: 20000, limit: 8, kp: 8, ki: 6, kd: 0.25, sample_time: 0.001, cutoff: 400, reference: 0,
    amplitude: 0.25, period: 0.15, duration: 6, seed: 3 },
};

// From the place of a slider, 0 to 1, to a value and back.
const even = (low, high) => ({ low, high, to: (t) => low + t * (high - low), from: (v) => (v - low) / (high - low) });
const log = (low, high) => ({ low, high, to: (t) => low * (high / low) ** t, from: (v) => Math.log(v / low) / Math.log(high / low) });
const bent = (high) => ({ low: 0, high, to: (t) => high * t ** 3, from: (v) => Math.cbrt(v / high) });
const signed = (high) => ({ low: -high, high, to: (t) => high * (2 * t - 1) ** 3, from: (v) => (Math.cbrt(v / high) + 1) / 2 });
const among = (all) => ({ low: all[0], high: all.at(-1), all, to: (t) => all[Math.round(t * (all.length - 1))],
  from: (v) => all.reduce((best, one, i) => (Math.abs(one - v) < Math.abs(all[best] - v) ? i : best), 0) / (all.length - 1) });
// Rigid, then softer and softer.
const soft = (high, low) => ({ low: 0, high, to: (t) => (t < 0.02 ? 0 : high * (low / high) ** t),
  from: (v) => (v > 0 ? Math.max(0.02, Math.log(v / high) / Math.log(low / high)) : 0) });

const plain = (value) => String(Number(value.toPrecision(3))).replace('-', '−');
const REFERENCES = ['noise', 'two sines', 'square wave'];
const GROUPS = [
  ['Servo', [
    ['b', 'Gain over inertia b', log(1, 5000), (v) => `${plain(v)} ${unit()}/s² per unit`],
    ['a', 'Viscous friction a', bent(40), (v) => `${plain(v)} 1/s`],
    ['coulomb', 'Coulomb friction c', bent(150), (v) => `${plain(v)} ${unit()}/s²`],
    ['load', 'Load d', signed(150), (v) => `${plain(v)} ${unit()}/s²`],
    ['load_step', 'Load step at half time', signed(100), (v) => (v ? `${plain(v)} ${unit()}/s²` : 'none')],
    ['delay', 'Delay of the command', bent(0.006), (v) => (v ? `${plain(1e3 * v)} ms` : 'none')],
    ['resonance', 'Compliance', soft(1200, 20), (v) => (v ? `resonance at ${plain(v / 2 / Math.PI)} Hz` : 'rigid')],
    ['inertia_ratio', 'Share of inertia on the load side', even(0.05, 0.95), (v) => `${Math.round(100 * v)} %`],
  ]],
  ['Encoder and amplifier', [
    ['counts', 'Encoder', log(100, 1e7), (v) => `${Math.round(v)} counts/rev`],
    ['limit', 'Limit of the command', log(0.1, 100), (v) => `±${plain(v)}`],
  ]],
  ['Your controller', [
    ['kp', 'Proportional gain', log(0.01, 2000), plain],
    ['ki', 'Integral gain', bent(5000), plain],
    ['kd', 'Derivative gain', bent(50), plain],
    ['sample_time', 'Sample time', among([0.00025, 0.0005, 0.001, 0.002, 0.004]), (v) => `${plain(1e3 * v)} ms`],
  ]],
  ['Motion', [
    ['reference', 'Reference', null, (v) => REFERENCES[v]],
    ['amplitude', 'Amplitude', log(0.001, 3), (v) => `${plain(v)} ${unit()}`],
    ['period', 'Hold or period', log(0.02, 4), (v) => `${plain(v)} s`],
    ['duration', 'Length', even(1, 20), (v) => `${plain(v)} s`],
  ]],
];
const SCALES = Object.fromEntries(GROUPS.flatMap(([, sliders]) => sliders.map(([name, , scale]) => [name, scale])));

const TILES = [
  ['a', 'a', 'viscous friction', () => '1/s', 0.02],
  ['b', 'b', 'gain over inertia', () => `${unit()}/s² per unit`, 0],
  ['coulomb', 'c', 'Coulomb friction', () => `${unit()}/s²`, 0.02],
  ['load', 'd', 'load', () => `${unit()}/s²`, 0.02],
];

let chosen = 'paper';
let settings = { ...PRESETS.paper };
// The last run, its verdict, and the steps behind it.
let rows = null, verdict = null, steps = null, until = 1;
// Times of the frames while settings changed, ms: of computing and of drawing; and when the first was drawn.
const frames = [];
let loaded = 0;

const unit = () => settings.unit ?? 'rad';

// The values as the module takes them: times are whole samples.
function values() {
  const T = settings.sample_time;
  const whole = (time) => Number((Math.max(1, Math.round(time / 2 / T)) * 2 * T).toPrecision(12));
  const exact = { ...settings, period: whole(settings.period), duration: whole(settings.duration),
    cutoff: Math.min(settings.cutoff, 2.4 / T), counts: Math.round(settings.counts) };
  return NAMES.map((name) => exact[name]);
}

// Workers.

const source = URL.createObjectURL(new Blob([byId('worker').textContent], { type: 'text/javascript' }));
let compiled;

class Helper {
  constructor() {
    this.waiting = new Map();
    this.number = 0;
    this.start();
  }
  start() {
    this.worker = new Worker(source);
    this.worker.onmessage = ({ data }) => {
      this.waiting.get(data.number)?.(data);
      this.waiting.delete(data.number);
    };
    this.worker.postMessage({ module: compiled });
  }
  ask(request, moved = []) {
    const number = ++this.number;
    this.worker.postMessage({ ...request, number }, moved);
    return new Promise((answer) => this.waiting.set(number, answer)).then((answer) => {
      // A module that has stopped is good for nothing more.
      if (answer.fault) {
        this.worker.terminate();
        this.start();
      }
      return answer;
    });
  }
}
let runner, judge;

let running = false, again = false, judging = false, change = 0, timer = 0, linked = 0;

// Runs the settings, the newest where they change faster than they run, and has them judged when they stay.
async function refresh() {
  change++;
  clearTimeout(timer);
  again = true;
  if (running) return;
  running = true;
  const next = () => {
    if (!again) return null;
    again = false;
    return runner.ask({ request: 'run', values: values() });
  };
  for (let coming = next(); coming; coming ??= next()) {
    const answer = await coming;
    // The module runs while the page draws.
    coming = next();
    if (answer.rows) {
      rows = answer.rows;
      verdict = steps = null;
      say('underway', 'Identifying', 'The estimates converge; the verdict follows when no slider moves.');
      await new Promise(requestAnimationFrame);
      const begun = performance.now();
      drawAll();
      if (frames.length > 200) frames.shift();
      frames.push({ computed: answer.took, drawn: performance.now() - begun });
      loaded ||= performance.now();
    } else {
      rows = verdict = steps = null;
      refuse(answer.refusal ?? 'The module stopped at these settings and was restarted');
    }
  }
  running = false;
  timer = setTimeout(settle, 200);
}

// The verdict on settings that rest.
async function settle() {
  if (judging) return;
  judging = true;
  const of = change;
  const answer = rows ? await judge.ask({ request: 'judge', values: values() }) : {};
  judging = false;
  if (of !== change) {
    if (!running) timer = setTimeout(settle, 50);
    return;
  }
  if (answer.verdict) {
    verdict = parse(answer.verdict);
    steps = answer.tuned ? { ...parse(answer.tuned), rows: answer.steps } : { none: answer.refusal };
    say(tone(verdict.status), title(verdict), sentence(verdict));
    drawAll();
  } else if (answer.refusal || answer.fault) {
    refuse(answer.refusal ?? answer.fault);
  }
}

// Lines of name and parts.
function parse(text) {
  const found = { effects: [], findings: [], columns: [], chosen: {}, estimates: {} };
  for (const line of text.split('\n').filter(Boolean)) {
    const [name, ...parts] = line.split('\t');
    if (name === 'effect') found.effects.push(parts);
    else if (name === 'finding') found.findings.push(parts.map(inWords));
    else if (name === 'column') found.columns.push(parts[0]);
    else if (name === 'chosen') found.chosen[parts[0]] = parts[1];
    else if (['status', 'reason', 'unit', 'cap', 'none'].includes(name)) found[name] = inWords(parts[0]);
    else if (['gains', 'predicted', 'margins', 'command', 'step', 'rows', 'window'].includes(name)) found[name] = parts.map(Number);
    else found.estimates[name] = { value: Number(parts[0]), error: Number(parts[1]), unit: parts[2] };
  }
  return found;
}

const tone = (status) => ({ converged: 'good', aborted: 'failed' })[status] ?? 'doubtful';
const TITLES = { converged: 'The servo is identified', unexplained: 'The model does not explain this servo',
  partial: 'Only the gain is within tolerance', 'no-information': 'Too little information in the motion', moving: 'The estimates have not settled', aborted: 'The run was aborted' };
// An effect beside the model is why a servo is not known that has one.
const title = ({ status, effects }) => (status !== 'converged' && effects.length ? TITLES.unexplained : TITLES[status] ?? status);

function sentence({ reason, effects, estimates }) {
  // A parameter's letter stays as it is.
  const capital = /^\w /.test(reason) ? reason : reason.charAt(0).toUpperCase() + reason.slice(1);
  const delay = estimates.delay;
  const late = delay && delay.value > 3 * delay.error && delay.value > 2e-5 ? [`a delay of ${plain(1e3 * delay.value)} ms`] : [];
  const beside = [...late, ...effects.map(([, meaning]) => meaning)];
  const found = beside.length ? ` It also found ${beside.join(' and ')}.` : '';
  return `${capital}.${found}`;
}

function say(kind, head, text) {
  const box = document.querySelector('#answer .verdict');
  box.style.setProperty('--tone', `var(--${kind})`);
  if (byId('verdict').textContent !== head) byId('verdict').textContent = head;
  if (byId('reason').textContent !== text) byId('reason').textContent = text;
}

function refuse(text) {
  say('failed', 'This cannot run', `${text.charAt(0).toUpperCase()}${text.slice(1)}.`);
}

// Figures.

const column = (index) => (i) => rows[COLUMNS * i + index];

function shown(value, error) {
  if (!Number.isFinite(value)) return '–';
  const digits = Number.isFinite(error) && error > 0
    ? Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(error))))
    : Math.max(0, 3 - Math.floor(Math.log10(Math.abs(value) || 1)));
  return value.toFixed(Math.min(digits, 6)).replace('-', '−');
}

// The true value of a parameter at the end.
const truth = (name) => settings[name] + (name === 'load' ? settings.load_step : 0);

function drawTile([name, , , of, floor], place) {
  const tile = byId(`tile-${name}`);
  const count = rows.length / COLUMNS, end = column(0)(count - 1) + settings.sample_time;
  const estimate = column(5 + place), error = column(9 + place);
  const stepped = name === 'load' && settings.load_step !== 0;
  const target = truth(name), now = estimate(count - 1), bound = SIDES * error(count - 1);
  const put = (part, text) => { tile.querySelector(part).textContent = text; };
  const line = (part, value, known, target) => {
    const off = value - target, share = target ? Math.abs((100 * off) / target) : Infinity;
    put(`.${part} dd`, Number.isFinite(value) ? `${shown(value, known)} ± ${Number.isFinite(known) ? plain(Number(known.toPrecision(2))) : '?'}` : '…');
    const cell = tile.querySelector(`.${part} .off`);
    const size = share < 1000 ? `${share < 0.001 ? '0.001' : plain(Number(share.toPrecision(2)))} %` : shown(Math.abs(off), known);
    cell.textContent = Number.isFinite(off) ? `${share < 0.001 ? '<\u202f' : off < 0 ? '−' : '+'}${size}` : '';
    cell.className = `off ${Math.abs(off) <= Math.max(1.5 * known, 1e-3 * Math.abs(target)) ? 'within' : 'beyond'}`;
  };
  put('.truth dd', plain(target) + (stepped ? `, before ${plain(settings.load)}` : ''));
  line('online', now, bound, target);
  // The mean of a load that steps is what one value for the whole record can be.
  const whole = verdict?.estimates[name];
  line('record', whole ? whole.value : NaN, whole ? SIDES * whole.error : NaN, stepped ? settings.load + settings.load_step / 2 : target);
  put('h3 small', `${tile.dataset.meaning}, ${of()}`);

  // As far as the estimates and their bands reach behind the beginning, but for a tenth of the time.
  const reach = [];
  const step = Math.max(1, Math.floor(count / 400));
  for (let i = Math.floor(0.15 * count); i < count; i += step) {
    const one = Math.abs(estimate(i) - target) + SIDES * (error(i) || 0);
    if (Number.isFinite(one)) reach.push(one);
  }
  reach.sort((one, other) => one - other);
  const usual = 1.3 * (reach[Math.floor(0.9 * reach.length)] ?? 0);
  const half = Math.max(usual, floor, 2e-3 * Math.abs(target), stepped ? 1.2 * Math.abs(settings.load_step) : 0);
  const levels = stepped
    ? [{ colour: '--truth', points: [[0, settings.load], [end / 2, settings.load], [end / 2, truth(name)], [end, truth(name)]] }]
    : [{ colour: '--truth', value: target }];
  const canvas = tile.querySelector('canvas');
  canvas.setAttribute('aria-label', `${tile.dataset.meaning} over time: true ${plain(target)}, estimate ${shown(now, bound)}`);
  const curve = { colour: '--estimate', count, x: column(0), y: estimate };
  draw(canvas, { x: [0, end], y: [target - half, target + half], unit: 's', levels, until,
    band: { ...curve, width: (i) => SIDES * error(i) }, curves: [curve] });
}

function drawAll() {
  document.querySelectorAll('[data-unit]').forEach((one) => { one.textContent = unit(); });
  if (!rows) return;
  const count = rows.length / COLUMNS, end = column(0)(count - 1) + settings.sample_time;
  TILES.forEach(drawTile);
  const curve = (index, name) => ({ colour: name, count, x: column(0), y: column(index) });
  const part = Math.min(count, Math.ceil((2 * count) / Math.max(2, end)));
  const motion = [];
  for (let i = 0; i < part; i++) motion.push(column(1)(i), column(2)(i));
  draw(byId('motion'), { x: [0, part * settings.sample_time], y: ends(motion), unit: 's', until,
    curves: [{ ...curve(1, '--truth'), count: part, thin: true }, { ...curve(2, '--estimate'), count: part }] });
  drawStep();
}

function drawStep() {
  const text = byId('gains');
  if (!steps?.rows) {
    text.textContent = steps ? `Not tuned: ${steps.none}.` : 'Gains appear with the verdict.';
    draw(byId('step'), { x: [0, 1], y: [-0.02, 0.14], unit: 's', curves: [], levels: [{ colour: '--truth', value: 0.1 }] });
    return;
  }
  const { none, step: [size, T], rows: both } = steps;
  const count = none ? both.length : both.length / 2;
  const of = (from, name) => ({ colour: name, count, x: (i) => i * T, y: (i) => both[from + i] });
  draw(byId('step'), { x: [0, count * T], y: ends([...both, 0, 1.05 * size]), unit: 's', levels: [{ colour: '--truth', value: size }],
    curves: none ? [of(0, '--other')] : [of(0, '--other'), of(count, '--estimate')] });
  if (none) {
    text.textContent = `Not tuned: ${none}.`;
    return;
  }
  text.replaceChildren(...gainsOf(steps));
}

function gainsOf({ gains, predicted, margins, cap }) {
  const bold = (value) => element('b', { textContent: plain(value) });
  return ['Tuned: kp ', bold(gains[0]), ', ki ', bold(gains[1]), ', kd ', bold(gains[2]),
    `, velocity filter ${plain(gains[3])} rad/s${cap ? `; ${cap} allows no more` : ''}. `,
    `Predicted: rise time ${plain(1e3 * predicted[0])} ms, overshoot at most ${plain(100 * predicted[1])} %; largest sensitivity `,
    `${plain(margins[0])}, gain margins ${plain(margins[1])} and ${plain(margins[2])}.`];
}

// Controls.

function build() {
  for (const [name, { title: text }] of Object.entries(PRESETS)) {
    const button = element('button', { type: 'button', textContent: text });
    button.dataset.preset = name;
    button.onclick = () => choose(name);
    byId('presets').append(button);
  }
  for (const [legend, sliders] of GROUPS) {
    const set = element('fieldset', {}, element('legend', { textContent: legend }));
    for (const [name, text, scale, words] of sliders) {
      const id = `set-${name}`;
      const output = element('output', { htmlFor: id });
      const control = scale
        ? element('input', { type: 'range', id, min: 0, max: scale.all ? scale.all.length - 1 : 1000, step: 1 })
        : element('select', { id }, ...REFERENCES.map((one, i) => element('option', { value: i, textContent: one })));
      control.oninput = () => {
        const value = scale ? scale.to(control.value / control.max) : Number(control.value);
        settings[name] = scale && !scale.all ? Number(value.toPrecision(3)) : value;
        until = 1;
        changed();
      };
      const line = element('div', { className: 'slider' }, element('label', { htmlFor: id, textContent: text }), output, control);
      line.show = () => {
        const value = settings[name];
        output.textContent = scale ? words(value) : '';
        if (!scale) control.value = value;
        else if (document.activeElement !== control) control.value = Math.round(scale.from(value) * control.max);
        control.setAttribute('aria-valuetext', words(value));
      };
      set.append(line);
    }
    byId('controls').append(set);
  }
  byId('controls').onsubmit = (event) => event.preventDefault();
  for (const [name, letter, meaning, of] of TILES) {
    const tile = element('div', { className: 'tile', id: `tile-${name}` },
      element('h3', {}, `${letter} `, element('small', { textContent: `${meaning}, ${of()}` })));
    tile.dataset.meaning = meaning;
    const pair = (part, text) => element('div', { className: part }, element('dt', { textContent: text }),
      element('dd', { textContent: '…' }), element('dd', { className: 'off' }));
    tile.append(element('dl', {}, pair('truth', 'True'), pair('online', 'On-line'), pair('record', 'Record')));
    const canvas = element('canvas');
    canvas.setAttribute('role', 'img');
    tile.append(canvas);
    byId('tiles').append(tile);
  }
}

function changed() {
  document.querySelectorAll('.slider').forEach((line) => line.show());
  document.querySelectorAll('[data-preset]').forEach((button) => button.setAttribute('aria-pressed', button.dataset.preset === chosen));
  byId('done').textContent = '';
  clearTimeout(linked);
  linked = setTimeout(keepLink, LINK_REST);
  refresh();
}

// Once the sliders rest: browsers take some hundred addresses in ten seconds and no more.
function keepLink() {
  try {
    history.replaceState(null, '', link());
  } catch {
    // Some browsers change no address of a file; the link can be copied all the same.
  }
}

function choose(name) {
  chosen = name;
  settings = { ...PRESETS[name] };
  runIn();
  changed();
}

// The estimates are drawn as they came, in a second.
function runIn() {
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) return;
  const begun = performance.now();
  until = 0;
  const next = () => {
    if (until >= 1) return;
    until = Math.min(1, (performance.now() - begun) / 1000);
    if (rows) drawAll();
    requestAnimationFrame(next);
  };
  requestAnimationFrame(next);
}

// The address of the settings: the preset, and the values that are not its own.
function link() {
  const own = NAMES.filter((name) => settings[name] !== PRESETS[chosen][name]).map((name) => `${name}=${settings[name]}`);
  return `#${[chosen, ...own].join('&')}`;
}

// Takes the settings of an address, as far as they are allowed.
function follow(hash) {
  const [name, ...own] = hash.slice(1).split('&');
  chosen = Object.hasOwn(PRESETS, name) ? name : 'paper';
  settings = { ...PRESETS[chosen] };
  for (const pair of own) {
    const [key, text] = pair.split('=');
    const value = Number(text);
    if (!NAMES.includes(key) || text === undefined || text === '' || !Number.isFinite(value)) continue;
    const scale = SCALES[key];
    if (key === 'reference') settings[key] = Math.min(2, Math.max(0, Math.round(value)));
    else if (scale?.all) settings[key] = scale.to(scale.from(value));
    else if (scale) settings[key] = Math.min(scale.high, Math.max(scale.low, value));
    else if (key === 'seed') settings[key] = Math.abs(Math.round(value)) % 2 ** 32;
    else if (key === 'cutoff') settings[key] = Math.min(5000, Math.max(10, value));
  }
}

// Logs.

const LARGEST_LOG = 64e6;
let recording = null;

function found(...parts) {
  byId('found').replaceChildren(...parts);
}

function verdictBox(kind, head, text) {
  const box = element('div', { className: 'verdict' }, element('h2', { textContent: head }), element('p', { textContent: text }));
  box.style.setProperty('--tone', `var(--${kind})`);
  return box;
}

// With the columns of a log others can be chosen; without, another file.
function notTaken(text, ...choices) {
  const other = element('button', { type: 'button', textContent: 'Choose another file' });
  other.onclick = () => byId('file').click();
  found(verdictBox('failed', 'This log cannot be used', text), ...choices, other);
}

// The bytes of a file, unpacked if it is packed by gzip; or a sentence.
async function bytesOfLog(file) {
  if (file.size > LARGEST_LOG) {
    return `It has ${Math.round(file.size / 1e6)} MB, but this page takes at most ${LARGEST_LOG / 1e6} MB: use servo-id identify for any size.`;
  }
  if (!file.size) return 'The file is empty: a log has a row of column names and one row per sample.';
  let bytes;
  try {
    bytes = new Uint8Array(await file.arrayBuffer());
  } catch {
    return 'It cannot be read: it is a folder, was removed, or may not be read.';
  }
  if (bytes[0] === 0x1f && bytes[1] === 0x8b) {
    const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip')).getReader();
    const parts = [];
    let size = 0;
    try {
      for (let part = await reader.read(); !part.done; part = await reader.read()) {
        parts.push(part.value);
        size += part.value.length;
        if (size > LARGEST_LOG) {
          reader.cancel();
          return `It unpacks to more than ${LARGEST_LOG / 1e6} MB: use servo-id identify for any size.`;
        }
      }
    } catch {
      return 'It is a damaged gzip file: save the log again.';
    }
    bytes = new Uint8Array(await new Blob(parts).arrayBuffer());
  }
  const begin = String.fromCharCode(...bytes.subarray(0, 5));
  if (begin.slice(1) === 'MCAP') return 'It is an MCAP recording: convert it to .csv.';
  // The module names the formats that it recognises: text in UTF-16, workbooks.
  const named = /^(PK|\xff\xfe|\xfe\xff)/.test(begin);
  if (!named && bytes.subarray(0, 4096).includes(0)) return 'It is not text: a log is comma-separated text with one row per sample.';
  return bytes;
}

async function take(file, stated = {}) {
  recording = null;
  found(verdictBox('underway', 'Identifying', file.name));
  const bytes = await bytesOfLog(file);
  if (typeof bytes === 'string') {
    notTaken(`${file.name}: ${bytes}`);
    return;
  }
  const answer = await judge.ask({ request: 'identify', log: bytes, stated: options(stated) }, [bytes.buffer]);
  if (answer.fault) {
    notTaken(`${file.name}: the module stopped at this file (${answer.fault}) and was restarted; nothing else is lost.`);
    return;
  }
  if (answer.refusal) {
    const { columns } = parse(answer.refusal);
    const lines = answer.refusal.split('\n').filter((line) => line && !line.startsWith('column\t')).map(inWords);
    const questions = Object.fromEntries(lines.filter((line) => line.startsWith('?')).map((line) => line.slice(1).split('\t')));
    const text = lines.join(' ').replace(/^the log/, file.name);
    if (!columns.length && !Object.keys(questions).length) {
      notTaken(text);
      return;
    }
    const form = choices(file, stated, columns, {}, questions);
    if (Object.keys(questions).length) found(verdictBox('doubtful', 'The log does not show everything', `${file.name}: answer below.`), form);
    else notTaken(`${text}. Choose other columns or units below.`, form);
    form.open = true;
    (form.querySelector('[data-asked] :is(select, input)') ?? form.querySelector('select'))?.focus();
    return;
  }
  const parsed = parse(answer.verdict), end = parsed.rows?.[0] ?? answer.rows.length;
  recording = { ...parsed, rows: answer.rows.subarray(0, end), response: answer.rows.subarray(end) };
  showLog(file, stated);
}

// What a log may not show: option, words, and the choices, which are columns, a list or a number.
const SIGN = ['as recorded', 'reversed'];
const CHOICES = [
  ['Time', [['time', 'Column', 'column'], ['time-unit', 'Unit', ['s', 'ms', 'us', 'ns', 'samples', 'iso-8601']], ['sample-time', 'From row to row, s', 'number']]],
  ['Position', [['position', 'Column', 'column'], ['position-unit', 'Unit', ['rad', 'deg', 'turns', 'counts', 'm', 'mm']], ['position-sign', 'Sign', SIGN],
    ['position-scale', 'Scale', 'number'], ['counts-per-rev', 'Encoder counts per revolution', 'number'], ['wrap', 'Begins again after', 'number']]],
  ['Command that acted', [['command', 'Column', 'column'], ['command-sign', 'Sign', SIGN], ['command-scale', 'Scale', 'number']]],
  ['Or the goal of a servo with its own loop', [['goal', 'Column', 'column'], ['kp', 'kp, command units per rad', 'number'], ['kd', 'kd, per rad/s', 'number'],
    ['limit', 'Limit of its command', 'number'], ['velocity', 'Velocity it acts on', 'column']]],
  ['Reference, only shown', [['reference', 'Column', 'column']]],
];

// A text in which the options of the program, and the keys of a scenario, have the words of their fields.
const FIELDS = Object.fromEntries(CHOICES.flatMap(([legend, fields]) => fields.map(([name, text]) => [name, `“${legend}: ${text}”`])));
const inWords = (text) => text.replace(/(?:--|\b(?:log|encoder|inner)\.)([a-z][a-z_-]*)(?: [A-Z]+\b)?/g,
  (_, name) => FIELDS[name.replaceAll('_', '-')] ?? name);

// The lines of options of what is stated. A servo with a goal has no other command, and a sign is one of its scale.
function options(stated) {
  const { 'position-sign': position, 'command-sign': command, ...own } = stated;
  for (const [name, sign] of [['position-scale', position], ['command-scale', command]])
    if (sign) own[name] = (sign === SIGN[1] ? -1 : 1) * Math.abs(own[name] || 1);
  if (own.goal) delete own.command;
  return Object.entries(own).map(([name, value]) => `${name}\t${value}\n`).join('');
}

// The form with what is stated, and how the rest was taken.
function choices(file, stated, columns, chosen, questions = {}) {
  const form = element('form');
  const signed = { ...chosen };
  for (const of of ['position', 'command']) {
    const scale = Number(chosen[`${of}-scale`] ?? NaN);
    if (Number.isFinite(scale)) Object.assign(signed, { [`${of}-sign`]: SIGN[scale < 0 ? 1 : 0], [`${of}-scale`]: String(Math.abs(scale)) });
  }
  for (const [legend, fields] of CHOICES) {
    const set = element('fieldset', {}, element('legend', { textContent: legend }));
    for (const [name, text, kind] of fields) {
      const id = `take-${name}`, taken = signed[name];
      const names = kind === 'column' ? [...(['time', 'reference'].includes(name) ? ['none'] : []), ...columns] : kind;
      const shown = (one) => (kind === 'column' && /^\d+$/.test(one) ? `column ${one}` : one);
      const control = kind === 'number' ? element('input', { id, name, inputMode: 'decimal', autocomplete: 'off', placeholder: taken ?? '', value: stated[name] ?? '' })
        : element('select', { id, name }, element('option', { value: '', textContent: taken ? `found: ${shown(taken)}` : '–' }),
          ...names.map((one) => element('option', { value: one, textContent: shown(one), selected: one === stated[name] })));
      const line = element('div', { className: 'field' }, element('label', { htmlFor: id, textContent: text }), control);
      if (questions[name]) {
        line.dataset.asked = name;
        line.append(element('p', { textContent: `${questions[name]}.` }));
      }
      set.append(line);
    }
    form.append(set);
  }
  form.append(element('button', { textContent: 'Identify' }));
  form.onsubmit = (event) => {
    event.preventDefault();
    take(file, Object.fromEntries([...new FormData(form)].map(([name, value]) => [name, value.trim()]).filter(([, value]) => value)));
  };
  return element('details', { className: 'choices' }, element('summary', { textContent: 'Columns, units and signs' }), form);
}

const MEANINGS = { a: 'a, viscous friction', b: 'b, gain over inertia', coulomb: 'c, Coulomb friction', load: 'd, load', delay: 'delay' };

function showLog(file, stated) {
  const { findings, estimates, none, command, columns, chosen, unit, window: [free] = [] } = recording;
  const isStated = ['rad', 'm'].includes(unit);
  const small = (textContent) => element('small', { textContent });
  const numbers = Object.entries(estimates).map(([name, { value, error, unit: own }]) => element('p', {}, small(MEANINGS[name] ?? name),
    element('b', { textContent: `${shown(value, SIDES * error)} ± ${Number.isFinite(error) ? plain(Number((SIDES * error).toPrecision(2))) : '?'}` }), small(own)));
  const figure = (id, label, ...caption) => {
    const canvas = element('canvas', { className: 'wide', id: `log-${id}` });
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', label);
    return element('figure', {}, element('figcaption', {}, ...caption), canvas);
  };
  const taken = choices(file, stated, columns, chosen);
  taken.open = recording.status !== 'converged' || !isStated;
  const bold = (textContent) => element('b', { textContent });
  const key = (...names) => element('span', { className: 'key' }, ...names.flatMap(([className, name]) => [element('i', { className }), name]));
  found(verdictBox(isStated ? tone(recording.status) : 'doubtful', `${file.name}: ${title(recording).replace(/^T/, 't')}${isStated ? '' : `, in ${unit}`}`, sentence(recording)),
    element('div', { className: 'beside' }, element('div', { className: 'estimates' }, ...numbers), element('div', {}, figure('motion', 'Position of the log over time', bold(`Position of the log, ${unit}`),
      ...(free ? [key(['position', 'measured '], ['before', `model, free for ${plain(free)} s`])] : [])),
    ...(free ? [figure('left', 'Residual of the position over time', bold(`Residual, ${unit}`))] : []))),
    ...(none ? [element('p', { id: 'log-gains', textContent: `Not tuned: ${Number.isFinite(estimates.b?.value) ? none.replace(/^[a-z]+_[a-z_]+: /, '') : 'there is no servo yet'}.` })] : [
      figure('step', 'Predicted step response under the tuned gains', bold(`Predicted step under the tuned gains, ${unit}`)),
      element('p', { id: 'log-gains' }, ...gainsOf(recording),
        ` For commands of up to ${plain(command[0])} beyond that of the load, the largest in the log.`)]),
    taken,
    element('ul', {}, ...findings.map(([about, text]) => element('li', { textContent: `${about}: ${text}` }))));
  drawLog();
}

function drawLog() {
  const canvas = byId('log-motion');
  if (!canvas || !recording) return;
  const of = recording.rows, count = of.length / 3;
  const over = (canvas, ...signals) => {
    const some = [];
    for (let i = 0; i < count; i += Math.max(1, Math.floor(count / 2000))) some.push(...signals.map(([, y]) => y(i)));
    draw(canvas, { x: [of[0], of[3 * (count - 1)]], y: ends(some), unit: 's',
      curves: signals.map(([colour, y]) => ({ colour, count, x: (i) => of[3 * i], y, thin: y !== signals[0][1] })) });
  };
  over(canvas, ['--estimate', (i) => of[3 * i + 1]], ['--other', (i) => of[3 * i + 1] - of[3 * i + 2]]);
  if (byId('log-left')) over(byId('log-left'), ['--estimate', (i) => of[3 * i + 2]]);
  const stepped = byId('log-step');
  if (!stepped) return;
  const { step: [size, T], response } = recording;
  draw(stepped, { x: [0, response.length * T], y: ends([...response, 0, 1.05 * size]), unit: 's',
    levels: [{ colour: '--truth', value: size }],
    curves: [{ colour: '--estimate', count: response.length, x: (i) => i * T, y: (i) => response[i] }] });
}

function takeDropped(data) {
  const item = data.items?.[0];
  if (item?.webkitGetAsEntry?.()?.isDirectory) {
    notTaken(`${data.files[0]?.name ?? 'This'}: this is a folder: drop one log.`);
    return;
  }
  if (data.files.length > 1) notTaken(`These are ${data.files.length} files: drop one log at a time.`);
  else if (data.files.length) take(data.files[0]);
  else notTaken('This is no file: drop a log.');
}

// The beginning.

/** The bytes of a text of digits to the base 85, five for four of them. */
function unpacked(text) {
  const values = new Uint8Array(128);
  let count = 0;
  for (let code = 35; code <= 122; code += 1) {
    if (!'&<\\'.includes(String.fromCharCode(code))) {
      values[code] = count;
      count += 1;
    }
  }
  const bytes = new Uint8Array(4 * Math.ceil(text.length / 5));
  const view = new DataView(bytes.buffer);
  for (let group = 0; 5 * group < text.length; group += 1) {
    let value = 0;
    for (let place = 5 * group; place < 5 * group + 5; place += 1) {
      value = 85 * value + (place < text.length ? values[text.charCodeAt(place)] : 84);
    }
    view.setUint32(4 * group, value);
  }
  return bytes.subarray(0, Math.floor(4 * text.length / 5));
}

async function begin() {
  build();
  follow(location.hash);
  const module = new Blob([unpacked(byId('packed').textContent)]).stream().pipeThrough(new DecompressionStream('gzip'));
  compiled = await WebAssembly.compile(await new Response(module).arrayBuffer());
  runner = new Helper();
  judge = new Helper();
  runIn();
  changed();
}

addEventListener('hashchange', () => {
  follow(location.hash);
  changed();
});
new ResizeObserver(() => {
  drawAll();
  drawLog();
}).observe(document.body);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  drawAll();
  drawLog();
});

const drop = byId('drop');
addEventListener('dragover', (event) => {
  event.preventDefault();
  drop.classList.add('over');
});
addEventListener('dragleave', () => drop.classList.remove('over'));
addEventListener('drop', (event) => {
  event.preventDefault();
  drop.classList.remove('over');
  takeDropped(event.dataTransfer);
});
byId('file').onchange = ({ target }) => {
  if (target.files.length) take(target.files[0]);
  target.value = '';
};

byId('link').onclick = async () => {
  const address = location.href.split('#')[0] + link();
  try {
    await navigator.clipboard.writeText(address);
    byId('done').textContent = 'Copied.';
  } catch {
    byId('done').textContent = address;
  }
};
byId('save').onclick = async () => {
  const { scenario, refusal } = await judge.ask({ request: 'scenario', values: values() });
  if (!scenario) {
    byId('done').textContent = refusal;
    return;
  }
  const file = URL.createObjectURL(new Blob([scenario], { type: 'text/plain' }));
  element('a', { href: file, download: 'playground.toml' }).click();
  setTimeout(() => URL.revokeObjectURL(file), 1000);
  byId('done').textContent = 'Saved as playground.toml.';
};

begin();
