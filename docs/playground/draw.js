// Drawing on canvases: curves over an abscissa, with bands and levels.

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// About `count` round values between two ends.
function ticks(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((one) => one * power >= raw) * power;
  const all = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) all.push(i * step);
  return { all, step };
}

// A number in so many digits as its step needs.
function label(value, step) {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const text = Math.abs(value) >= 1e5 || (step < 1e-4 && value) ? value.toExponential(1) : value.toFixed(Math.min(digits, 6));
  return text.replace('-', '−');
}

// Draws a figure on a canvas: `x` ends, `y` ends, and in this order `band`, `levels` and `curves`. A curve has `x` and `y`
// as functions of the sample and `count`; of more samples than pixels each column shows lowest and highest.
function draw(canvas, { x, y, curves, band, levels = [], until = 1, unit = '' }) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (!width || !height) return;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext('2d');
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = `11px ${colour('--sans')}`;
  const of = ticks(y[0], y[1], Math.max(2, height / 32));
  const names = of.all.map((value) => label(value, of.step));
  const left = 8 + Math.max(...names.map((name) => pen.measureText(name).width));
  const [top, right, bottom] = [8, 10, 20];
  const w = width - left - right, h = height - top - bottom;
  const px = (value) => left + ((value - x[0]) / (x[1] - x[0])) * w;
  const py = (value) => top + ((y[1] - value) / (y[1] - y[0])) * h;

  pen.lineWidth = 1;
  pen.strokeStyle = colour('--grid');
  pen.fillStyle = colour('--soft');
  pen.textBaseline = 'middle';
  pen.textAlign = 'right';
  of.all.forEach((value, i) => {
    const at = Math.round(py(value)) + 0.5;
    pen.beginPath();
    pen.moveTo(left, at);
    pen.lineTo(left + w, at);
    pen.stroke();
    pen.fillText(names[i], left - 5, at);
  });
  const across = ticks(x[0], x[1], Math.max(2, w / 70));
  pen.textBaseline = 'alphabetic';
  across.all.forEach((value) => {
    const text = label(value, across.step) + (value === across.all.at(-1) ? ` ${unit}` : '');
    const half = pen.measureText(text).width / 2;
    pen.textAlign = 'center';
    pen.fillText(text, Math.max(left + half, Math.min(px(value), width - half - 1)), height - 5);
  });

  pen.save();
  pen.beginPath();
  pen.rect(left, top - 1, w * until, h + 2);
  pen.clip();
  const path = (curve, value) => {
    const step = Math.max(1, Math.floor(curve.count / (w * ratio)));
    for (let i = 0; i < curve.count; i += step) {
      const last = Math.min(i + step, curve.count);
      let low = Infinity, high = -Infinity;
      for (let k = i; k < last; k++) {
        const one = value(k);
        if (one < low) low = one;
        if (one > high) high = one;
      }
      if (low > high) continue;
      const at = px(curve.x(i));
      pen.lineTo(at, py(high));
      if (step > 1) pen.lineTo(at, py(low));
    }
  };
  if (band) {
    pen.fillStyle = colour(band.colour);
    pen.globalAlpha = Number(colour('--band'));
    pen.beginPath();
    const step = Math.max(1, Math.floor(band.count / (2 * w)));
    const seen = [];
    for (let i = 0; i < band.count; i += step) if (band.width(i) >= 0) seen.push(i);
    for (const i of seen) pen.lineTo(px(band.x(i)), clamp(py(band.y(i) + band.width(i))));
    for (const i of seen.reverse()) pen.lineTo(px(band.x(i)), clamp(py(band.y(i) - band.width(i))));
    pen.fill();
    pen.globalAlpha = 1;
  }
  for (const level of levels) {
    pen.strokeStyle = colour(level.colour);
    pen.lineWidth = 1.5;
    pen.setLineDash([6, 4]);
    pen.beginPath();
    for (const [at, value] of level.points ?? [[x[0], level.value], [x[1], level.value]]) pen.lineTo(px(at), py(value));
    pen.stroke();
    pen.setLineDash([]);
  }
  for (const curve of curves) {
    pen.strokeStyle = colour(curve.colour);
    pen.lineWidth = curve.thin ? 1 : 1.8;
    pen.lineJoin = 'round';
    pen.beginPath();
    path(curve, curve.y);
    pen.stroke();
  }
  pen.restore();

  // Far beyond the figure a canvas may lose a path.
  function clamp(at) {
    return Math.max(-height, Math.min(2 * height, at));
  }
}

// The ends of some values, with room.
function ends(values, least = 0) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return [-1, 1];
  const room = Math.max(0.08 * (high - low), least, 1e-12);
  return [low - room, high + room];
}
