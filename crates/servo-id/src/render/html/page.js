"use strict";

// Draws the plots of the page, zooms them together, shows values and switches traces. Without it the page
// shows them as drawings.
(() => {
  const HEIGHT = 250;
  const STEP = 0.01; // of what is shown, that an arrow key moves the cursor
  const PAN = 0.25; // of what is shown, that what is shown is moved
  const ZOOM = 0.5;
  const LEAST = 1e-6; // of the whole, that can be zoomed to
  const ROOM = 0.06; // above and below what is shown
  const LEFT = 60; // of the vertical axis, at least

  const hosts = [...document.querySelectorAll("figure.plot")];
  const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const shown = (value) => (value == null ? "" : String(Number(value.toPrecision(6))).replace("-", "−"));

  const TRACE_COLOURS = 4;
  const STRETCH_COLOURS = 9;

  // The lines of a figure, its traces and then its levels; on a logarithmic axis a place is the power of ten.
  function plotted({ horizontal, vertical, traces, levels, stretches, settled }) {
    const place = horizontal.is_logarithmic ? Math.log10 : (at) => at;
    const lines = traces.map(({ points, band }, number) => ({
      colour: number % TRACE_COLOURS,
      places: points.map(([at]) => place(at)),
      values: points.map(([, value]) => value),
      band: band.length ? band : null,
    }));
    const places = lines.flatMap((line) => [line.places[0], line.places.at(-1)]).filter((at) => at != null);
    const ends = places.length ? [Math.min(...places), Math.max(...places)] : [];
    const constants = levels.map(({ value }) => ({ places: ends, values: ends.map(() => value) }));
    return {
      abscissa: horizontal.name,
      logarithmic_abscissa: horizontal.is_logarithmic,
      names: horizontal.names,
      range: settled?.range ?? vertical.range,
      traces: [...lines, ...constants],
      stretches,
    };
  }
  const placeAt = ({ names, logarithmic_abscissa }, place) =>
    names ? (names[Math.round(place) - 1] ?? "") : shown(logarithmic_abscissa ? 10 ** place : place);

  // Where values of one, two or five times a power of ten stand, or the powers alone where these would stand on one
  // another, or any where none of these are shown. `decade` is its width, pixels.
  function decades(from, to, decade) {
    const TEXT = 48; // pixels that a figure takes
    for (const [parts, every] of [[[1, 2, 5], 1], [[1], 1], [[1], 2], [[1], 3]]) {
      const places = [];
      for (let power = Math.floor(from); power <= to; power += 1)
        if (power % every === 0) places.push(...parts.map((part) => power + Math.log10(part)));
      const seen = places.filter((place) => place >= from && place <= to);
      if (seen.length < 2) break;
      if (decade * (parts.length > 1 ? Math.log10(2) : every) >= TEXT) return seen;
    }
    return [0.15, 0.5, 0.85].map((part) => from + part * (to - from));
  }
  const figures = JSON.parse(document.getElementById("figures").textContent).map(plotted);
  let plots = [];

  // Room of the widest text at an axis.
  function sized(chart, values, axis, cycle) {
    const { font, ticks, gap, _size } = chart.axes[axis];
    if (cycle > 1) return _size;
    [chart.ctx.font] = font;
    const widths = (values ?? []).map((text) => chart.ctx.measureText(text ?? "").width / devicePixelRatio);
    return Math.ceil(Math.max(LEFT, ticks.size + gap + Math.max(0, ...widths) + 2));
  }

  // What is shown of each abscissa, and what there is.
  const views = new Map();

  function measure() {
    for (const view of views.values()) view.whole = [Infinity, -Infinity];
    for (const figure of figures) {
      const view = views.get(figure.abscissa) ?? { whole: [Infinity, -Infinity], now: null };
      for (const { places } of figure.traces) {
        if (places.length === 0) continue;
        view.whole[0] = Math.min(view.whole[0], places[0]);
        view.whole[1] = Math.max(view.whole[1], places[places.length - 1]);
      }
      views.set(figure.abscissa, view);
    }
  }

  const within = (abscissa) => {
    const { now, whole } = views.get(abscissa);
    return now ?? (whole[0] < whole[1] ? whole : [0, 1]);
  };

  function show(abscissa, from, to) {
    const view = views.get(abscissa);
    const [first, last] = view.whole;
    const length = Math.min(Math.max(to - from, LEAST * (last - first)), last - first);
    const begin = Math.min(Math.max(from, first), last - length);
    view.now = length < last - first ? [begin, begin + length] : null;
    const [min, max] = within(abscissa);
    plots.filter((plot) => plot.abscissa === abscissa).forEach(({ chart }) => chart.setScale("x", { min, max }));
  }

  function zoom(abscissa, how, at) {
    const [from, to] = within(abscissa);
    const length = to - from;
    const about = at ?? (from + to) / 2;
    const scaled = (by) => show(abscissa, about - (about - from) * by, about + (to - about) * by);
    if (how === "in") scaled(ZOOM);
    if (how === "out") scaled(1 / ZOOM);
    if (how === "left") show(abscissa, from - PAN * length, to - PAN * length);
    if (how === "right") show(abscissa, from + PAN * length, to + PAN * length);
    if (how === "reset") show(abscissa, -Infinity, Infinity);
    if (typeof how === "number") scaled(how);
  }

  // The traces over one set of places, the last first, so that the first is in front; what a trace has no value for
  // is left undefined, and bridged.
  function table(figure) {
    const tables = figure.traces.toReversed().map(({ places, values, band }) => {
      if (!band) return [places, values];
      const edge = (sign) => values.map((value, i) => (band[i] == null ? null : value + sign * band[i]));
      return [places, values, edge(1), edge(-1)];
    });
    return uPlot.join(tables);
  }

  const nearest = (chart, series, index) => {
    const values = chart.data[series];
    for (let off = 0; off < values.length; off++) {
      if (values[index - off] != null) return index - off;
      if (values[index + off] != null) return index + off;
    }
    return index;
  };

  function draw(number) {
    const figure = figures[number];
    const host = hosts[number];
    const canvas = host.querySelector(".canvas");
    const buttons = [...host.querySelectorAll("button[data-traces]")];
    const place = host.querySelector(".place");
    const font = `12px ${style("--sans")}`;
    const soft = style("--soft");
    const grid = { stroke: style("--grid"), width: 1 };
    const series = [{}];
    const bands = [];
    const first = []; // the series of each trace

    for (const [trace, { colour, band }] of [...figure.traces.entries()].reverse()) {
      const stroke = style(`--trace-${colour ?? "dashed"}`);
      first[trace] = series.length;
      series.push({ stroke, width: colour == null ? 1.2 : 1.5, dash: colour == null ? [6, 4] : undefined, points: { show: false } });
      if (!band) continue;
      const edge = { stroke: "transparent", width: 0, points: { show: false } };
      bands.push({
        series: [series.length, series.length + 1],
        fill: `color-mix(in srgb, ${stroke} ${100 * Number(style("--band"))}%, transparent)`,
      });
      series.push({ ...edge }, { ...edge });
    }

    const chart = new uPlot(
      {
        width: canvas.clientWidth,
        height: HEIGHT,
        series,
        bands,
        legend: { show: false },
        padding: [10, 24, 0, 0],
        cursor: {
          dataIdx: nearest,
          y: false,
          drag: { x: true, y: false, setScale: false },
          bind: { dblclick: () => () => zoom(figure.abscissa, "reset") },
          focus: { prox: -1 },
          points: { size: 7 },
          sync: {
            key: figure.abscissa,
            scales: ["x", null],
            filters: { pub: (type) => type === "mousemove" || type === "mouseleave" },
          },
        },
        scales: {
          x: { time: false, range: () => within(figure.abscissa) },
          y: {
            range: (_, low, high) => {
              const { range } = figures[number];
              if (range && views.get(figure.abscissa).now == null) return range;
              if (low == null) return range ?? [0, 1];
              const room = ROOM * (high - low) || 0.1 * Math.abs(high) || 1;
              return [low - room, high + room];
            },
          },
        },
        axes: [
          { stroke: soft, grid, ticks: { ...grid, size: 4 }, font, label: figure.abscissa, labelFont: font, labelSize: 20, labelGap: 0, size: 28, gap: 4,
            ...(figure.names && {
              size: figure.names.length > 4 ? 54 : 28,
              splits: () => figure.names.map((_, place) => place + 1),
              // Many are on three lines, so that none lies on another.
              values: () => figure.names.map((name, place) => "\n".repeat(figure.names.length > 4 ? place % 3 : 0) + name),
            }),
            ...(figure.logarithmic_abscissa && {
              splits: ({ width }, axis, from, to) => decades(from, to, (width - 2 * LEFT) / (to - from)),
              values: (_, splits) => splits.map((place) => String(Number((10 ** place).toPrecision(3)))),
            }) },
          { stroke: soft, grid, ticks: { ...grid, size: 4 }, font, size: sized, gap: 4,
            values: (_, splits) => splits.map((value) => (value == null ? "" : String(Number(value.toPrecision(9))).replace("-", "−"))) },
        ],
        hooks: {
          drawClear: [(chart) => shade(chart, figures[number])],
          setSelect: [
            (chart) => {
              const { left, width } = chart.select;
              if (width < 3) return;
              const [from, to] = [left, left + width].map((at) => chart.posToVal(at, "x"));
              chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
              show(figure.abscissa, from, to);
            },
          ],
          setCursor: [
            (chart) => {
              const { left, idx, idxs } = chart.cursor;
              const is = left >= 0 && idx != null;
              place.textContent = is ? `${figure.abscissa.split(" [")[0]} ${placeAt(figure, chart.posToVal(left, "x"))}` : "";
              for (const button of buttons) {
                const [trace] = tracesOf(button);
                const series = first[trace];
                const value = is && chart.series[series].show ? chart.data[series][idxs[series]] : null;
                button.querySelector("output").textContent = shown(value);
              }
            },
          ],
        },
      },
      table(figure),
      canvas,
    );

    const switched = (button) => {
      const is = button.getAttribute("aria-pressed") === "true";
      for (const trace of tracesOf(button)) {
        const count = figure.traces[trace].band ? 3 : 1;
        for (let i = first[trace]; i < first[trace] + count; i++) chart.setSeries(i, { show: is });
      }
    };
    for (const button of buttons) {
      button.onclick = () => {
        button.setAttribute("aria-pressed", String(button.getAttribute("aria-pressed") !== "true"));
        switched(button);
      };
      if (button.getAttribute("aria-pressed") === "false") switched(button);
    }
    keys(canvas, chart, figure.abscissa);
    pinch(chart, figure.abscissa);
    canvas.classList.add("drawn");
    return { chart, canvas, abscissa: figure.abscissa };
  }

  const tracesOf = (button) => button.dataset.traces.split(" ").map(Number);

  function shade(chart, figure) {
    const { ctx, bbox } = chart;
    ctx.save();
    ctx.globalAlpha = Number(style("--stretch"));
    for (const { extent, colour } of figure.stretches) {
      const [from, to] = extent.map((at) =>
        Math.min(Math.max(chart.valToPos(at, "x", true), bbox.left), bbox.left + bbox.width));
      ctx.fillStyle = style(`--stretch-${colour % STRETCH_COLOURS}`);
      ctx.fillRect(from, bbox.top, to - from, bbox.height);
    }
    ctx.restore();
  }

  function keys(canvas, chart, abscissa) {
    const move = (by) => {
      const width = chart.over.clientWidth;
      const from = chart.cursor.left >= 0 ? chart.cursor.left : width / 2;
      const left = Math.min(Math.max(from + by * width, 0), width);
      chart.setCursor({ left, top: chart.over.clientHeight / 2 });
    };
    canvas.onkeydown = (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const { key, shiftKey } = event;
      if (key === "ArrowLeft" || key === "ArrowRight") {
        const forward = key === "ArrowRight";
        if (shiftKey) zoom(abscissa, forward ? "right" : "left");
        else move(forward ? STEP : -STEP);
      } else if (key === "+" || key === "=") zoom(abscissa, "in", at(chart));
      else if (key === "-") zoom(abscissa, "out", at(chart));
      else if (key === "0" || key === "Escape") zoom(abscissa, "reset");
      else return;
      event.preventDefault();
    };
  }

  // The place of the cursor, if it is there.
  const at = (chart) => (chart.cursor.left >= 0 ? chart.posToVal(chart.cursor.left, "x") : null);

  // Two fingers, or a wheel with Ctrl, which is what touch pads make of two fingers.
  function pinch(chart, abscissa) {
    const { over } = chart;
    const fingers = new Map();
    const apart = () => {
      const [one, other] = [...fingers.values()];
      return Math.max(Math.abs(one - other), 20);
    };
    over.addEventListener("pointerdown", (event) => {
      if (event.pointerType === "touch") fingers.set(event.pointerId, event.offsetX);
    });
    over.addEventListener("pointermove", (event) => {
      if (!fingers.has(event.pointerId)) return;
      const before = fingers.size === 2 ? apart() : null;
      fingers.set(event.pointerId, event.offsetX);
      if (before == null) return;
      const [one, other] = [...fingers.values()];
      zoom(abscissa, before / apart(), chart.posToVal((one + other) / 2, "x"));
    });
    for (const end of ["pointerup", "pointercancel", "pointerleave"])
      over.addEventListener(end, (event) => fingers.delete(event.pointerId));
    over.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      zoom(abscissa, Math.exp(0.005 * event.deltaY), chart.posToVal(event.offsetX, "x"));
    }, { passive: false });
  }

  function drawAll() {
    for (const { chart } of plots) chart.destroy();
    measure();
    plots = figures.map((_, number) => draw(number));
    window.plots = plots;
  }

  for (const host of hosts) {
    const canvas = host.querySelector(".canvas");
    canvas.tabIndex = 0;
    // Values are spoken where keys move the cursor, not wherever the pointer passes.
    const speak = (how) => host.querySelectorAll("output").forEach((output) => output.setAttribute("aria-live", how));
    canvas.onfocus = () => speak("polite");
    canvas.onblur = () => speak("off");
    canvas.setAttribute("role", "group");
    canvas.setAttribute("aria-roledescription", "plot");
    canvas.setAttribute("aria-label", host.querySelector(".title").textContent);
  }
  for (const toolbar of document.querySelectorAll(".toolbar")) {
    toolbar.hidden = false;
    toolbar.addEventListener("click", ({ target }) => {
      if (target.dataset.zoom) for (const abscissa of views.keys()) zoom(abscissa, target.dataset.zoom);
    });
  }
  drawAll();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  const sizes = new ResizeObserver(() => {
    for (const { chart, canvas } of plots)
      if (canvas.clientWidth > 0 && canvas.clientWidth !== chart.width) chart.setSize({ width: canvas.clientWidth, height: HEIGHT });
  });
  hosts.forEach((host) => sizes.observe(host));
})();
