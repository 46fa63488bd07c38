// A worker with a module of its own: it runs, judges, tunes and identifies, one request after the other.
let module;

const text = () => new TextDecoder().decode(new Uint8Array(module.memory.buffer, module.text(), module.text_length()));
const numbers = () => new Float64Array(module.memory.buffer, module.numbers(), module.numbers_length()).slice();

function give(values) {
  // The buffer first: with it the memory may grow and be another.
  const place = module.input(8 * values.length);
  new Float64Array(module.memory.buffer, place, values.length).set(values);
}

// Each answers with what is true of it, or with a refusal.
const requests = {
  run({ values }) {
    const begun = performance.now();
    give(values);
    const done = module.run();
    return done ? { rows: numbers(), took: performance.now() - begun } : { refusal: text() };
  },
  judge({ values }) {
    give(values);
    if (!module.run() || !module.judge()) return { refusal: text() };
    const verdict = text();
    const tuned = module.tune();
    return tuned ? { verdict, tuned: text(), steps: numbers() } : { verdict, refusal: text() };
  },
  scenario({ values }) {
    give(values);
    return module.scenario() ? { scenario: text() } : { refusal: text() };
  },
  identify({ log, stated }) {
    const answers = new TextEncoder().encode(stated);
    const place = module.input(answers.length + log.length);
    const memory = new Uint8Array(module.memory.buffer, place, answers.length + log.length);
    memory.set(answers);
    memory.set(log, answers.length);
    const done = module.identify(answers.length);
    return done ? { verdict: text(), rows: numbers() } : { refusal: text() };
  },
};

onmessage = ({ data }) => {
  if (data.module) {
    module = new WebAssembly.Instance(data.module).exports;
    return;
  }
  let answer;
  try {
    answer = requests[data.request](data);
  } catch (fault) {
    answer = { fault: String(fault) };
  }
  const moved = [answer.rows, answer.steps].filter(Boolean).map((array) => array.buffer);
  postMessage({ ...answer, number: data.number }, moved);
};
