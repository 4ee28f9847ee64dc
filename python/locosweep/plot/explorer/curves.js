// Measured runs beside models of them: two panels over time, which zoom and answer to the pointer.
const data = JSON.parse(byId("curves-data").textContent);
const numbers = decoded("curves-numbers", Float32Array);
const canvas = byId("curves");
const shown = data.lines.map(() => true);
let range = null; // part of the run in s; null: all of it
let hover = null; // number of the sample under the pointer
let drag = null; // time where a selection began
let run = null; // arrays of the chosen run and channel
let plot = null; // rectangles of both panels
let context = null;

// Arrays follow each other: of each run its times, then by channel the nominal model and what
// every line adds to it, as errors of 32-bit positions would not be exact enough.
let next = 0;
for (const one of data.runs) {
  const take = () => numbers.subarray(next, (next += one.count));
  one.t = take();
  one.fields = Object.fromEntries(one.channels.map((name) => [name, [take(), data.lines.map(take)]]));
}

const redraw = follow(canvas, (width) => Math.max(360, Math.min(560, 0.6 * width)), (c, width, height) => {
  context = c;
  draw(width, height);
});

function pick() {
  const one = data.runs[Number(byId("curves-run").value)];
  const names = data.channels.filter((channel) => one.channels.includes(channel.name));
  const kept = byId("curves-channel").value;
  byId("curves-channel").replaceChildren(
    ...names.map(({ name, words }) => make("option", { value: name, textContent: words }))
  );
  if (one.channels.includes(kept)) byId("curves-channel").value = kept;
  const channel = names.find(({ name }) => name === byId("curves-channel").value);
  const [base, added] = one.fields[channel.name];
  const lines = added.map((line) => Float64Array.from(line, (v, i) => base[i] + v));
  const errors = added.slice(1).map((line) => Float64Array.from(line, (v, i) => added[0][i] - v));
  run = { one, channel, lines, errors };
  [range, hover] = [null, null];
  byId("curves-note").textContent = one.note;
  redraw();
  say();
}

const inView = () => range ?? [run.one.t[0], run.one.t.at(-1)];

function extent(fields, more = 0) {
  let [lo, hi] = [-more, more];
  if (!more) [lo, hi] = [Infinity, -Infinity];
  const [from, to] = inView();
  for (const field of fields) {
    for (let i = 0; i < field.length; i++) {
      if (run.one.t[i] < from || run.one.t[i] > to || field[i] !== field[i]) continue;
      lo = Math.min(lo, field[i]);
      hi = Math.max(hi, field[i]);
    }
  }
  if (!(hi >= lo)) return [-1, 1];
  const room = 0.05 * (hi - lo) || 0.5 * Math.abs(hi) || 1;
  return [lo - room, hi + room];
}

const inside = (x) => Math.max(plot[0].x, Math.min(plot[0].x + plot[0].w, x));
const atX = (t) => plot[0].x + ((t - inView()[0]) / (inView()[1] - inView()[0] || 1)) * plot[0].w;
const timeAt = (x) => inView()[0] + ((x - plot[0].x) / plot[0].w) * (inView()[1] - inView()[0]);

function draw(width, height) {
  const left = width < 520 ? 56 : 74;
  const [w, tall] = [width - left - 8, height - 62];
  plot = [{ x: left, y: 8, w, h: 0.58 * tall }, { x: left, y: 8 + 0.58 * tall + 16, w, h: 0.42 * tall }];
  const { channel, lines, errors } = run;
  context.clearRect(0, 0, width, height);
  const seen = lines.filter((_, k) => shown[k]);
  panel(plot[0], extent(seen), channel.factor, `${channel.words} [${channel.unit}]`, (y) => {
    lines.forEach((line, k) => shown[k] && curve(line, y, data.lines[k], k ? 1.6 : 3.4));
  });
  const rests = errors.filter((_, k) => shown[k + 1]);
  const band = channel.noise;
  const unit = `error [${channel.errorUnit}]`;
  panel(plot[1], extent(rests, band), channel.errorFactor, unit, (y) => {
    context.fillStyle = ink("gap");
    if (band) context.fillRect(plot[1].x, y(band), w, y(-band) - y(band));
    errors.forEach((line, k) => shown[k + 1] && curve(line, y, data.lines[k + 1], 1.4));
  });
  context.fillStyle = ink("text");
  context.textAlign = "center";
  for (const [t, text] of ticks(...inView(), w / 80)) {
    context.fillRect(atX(t) - 0.5, plot[1].y + plot[1].h, 1, 4);
    context.fillText(text, atX(t), plot[1].y + plot[1].h + 16);
  }
  context.fillText("time since the run's start [s]", left + w / 2, height - 6);
  if (hover !== null) {
    context.fillRect(Math.round(atX(run.one.t[hover])), plot[0].y, 1, plot[1].y + plot[1].h - plot[0].y);
  }
  if (drag) {
    context.globalAlpha = 0.25;
    context.fillStyle = ink("link");
    const [a, b] = drag.map((t) => inside(atX(t)));
    context.fillRect(Math.min(a, b), plot[0].y, Math.abs(b - a), plot[1].y + plot[1].h - plot[0].y);
    context.globalAlpha = 1;
  }
}

function panel(box, [lo, hi], factor, label, lines) {
  const y = (v) => box.y + box.h - ((v - lo) / (hi - lo)) * box.h;
  context.save();
  context.beginPath();
  context.rect(box.x, box.y, box.w, box.h);
  context.clip();
  lines(y);
  context.restore();
  context.strokeStyle = context.fillStyle = ink("text");
  context.lineWidth = 1;
  context.setLineDash([]);
  context.strokeRect(box.x, box.y, box.w, box.h);
  context.textAlign = "right";
  for (const [v, text] of ticks(factor * lo, factor * hi, box.h / 36)) {
    context.fillRect(box.x - 4, y(v / factor) - 0.5, 4, 1);
    context.fillText(text, box.x - 6, y(v / factor) + 4, box.x - 22);
  }
  turned(context, label, 12, box.y + box.h / 2, box.h);
}

function curve(line, y, look, wide) {
  const t = run.one.t;
  const [from, to] = inView();
  context.beginPath();
  for (let i = 0, on = false; i < line.length; i++) {
    // One sample beyond either edge, so that lines reach it.
    const near = (t[i + 1] ?? to) >= from && (t[i - 1] ?? from) <= to;
    if (!near || line[i] !== line[i]) on = false;
    else {
      context[on ? "lineTo" : "moveTo"](atX(t[i]), y(line[i]));
      on = true;
    }
  }
  Object.assign(context, { strokeStyle: ink(look.ink), lineWidth: wide, lineJoin: "round" });
  context.setLineDash(look.dash);
  context.stroke();
  context.setLineDash([]);
}

function say() {
  const { one, channel, lines, errors } = run;
  const { factor, unit, errorFactor, errorUnit } = channel;
  const parts = [];
  if (hover !== null) {
    parts.push(`t = ${num(one.t[hover], 5)} s`);
    lines.forEach((line, k) => {
      if (!shown[k]) return;
      const error = k ? ` (error ${num(errorFactor * errors[k - 1][hover], 3)} ${errorUnit})` : "";
      const value = line[hover];
      parts.push(`${data.lines[k].words} ${value === value ? `${num(factor * value)} ${unit}${error}` : "missing"}`);
    });
  }
  byId("curves-readout").textContent = parts.join("; ") || data.hint;
}

function point(t) {
  const times = run.one.t;
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  hover = t - times[low] < times[high] - t ? low : high;
  redraw();
  say();
}

function zoom(from, to) {
  const t = run.one.t;
  const [first, last] = [t[0], t.at(-1)];
  const least = (10 * (last - first)) / run.one.samples;
  if (!(to - from > least)) return;
  range = from <= first && to >= last ? null : [Math.max(first, from), Math.min(last, to)];
  redraw();
}

const scaled = (by) => {
  const [from, to] = inView();
  const centre = hover === null ? (from + to) / 2 : Math.max(from, Math.min(to, run.one.t[hover]));
  zoom(centre - by * (centre - from), centre + by * (to - centre));
};
const whole = () => {
  range = null;
  redraw();
};
const placeOf = (event) => event.clientX - canvas.getBoundingClientRect().left;
canvas.onpointerdown = (event) => {
  // A finger scrolls the page; the keys and buttons zoom there.
  if (event.pointerType === "touch") return;
  drag = [timeAt(placeOf(event)), timeAt(placeOf(event))];
  canvas.setPointerCapture(event.pointerId);
};
canvas.onpointermove = (event) => {
  if (drag) drag[1] = timeAt(inside(placeOf(event)));
  point(timeAt(inside(placeOf(event))));
};
canvas.onpointerup = () => {
  const [a, b] = drag ?? [0, 0];
  drag = null;
  if (Math.abs(atX(a) - atX(b)) > 8) zoom(Math.min(a, b), Math.max(a, b));
  else redraw();
};
canvas.onpointerleave = () => {
  if (drag) return;
  hover = null;
  redraw();
  say();
};
canvas.ondblclick = whole;
canvas.onkeydown = (event) => {
  const times = run.one.t;
  const by = { ArrowLeft: -1, ArrowRight: 1, PageUp: -20, PageDown: 20 }[event.key];
  if (by) {
    const from = hover ?? Math.floor(times.length / 2);
    point(times[Math.max(0, Math.min(times.length - 1, from + by))]);
    const [a, b] = inView();
    if (times[hover] < a || times[hover] > b) zoom(times[hover] - (b - a) / 2, times[hover] + (b - a) / 2);
  } else if (event.key === "+" || event.key === "=") scaled(0.5);
  else if (event.key === "-") scaled(2);
  else if (event.key === "0" || event.key === "Escape") whole();
  else return;
  event.preventDefault();
};
for (const [name, act] of [["in", () => scaled(0.5)], ["out", () => scaled(2)], ["all", whole]]) {
  byId(`curves-${name}`).onclick = act;
}
byId("curves-switches").replaceChildren(...data.lines.map(({ words, ink: colour, dash }, k) => {
  const box = make("input", { type: "checkbox", checked: true });
  box.onchange = () => {
    shown[k] = box.checked;
    redraw();
    say();
  };
  const swatch = make("span", { className: "swatch" });
  swatch.style.borderTop = `3px ${dash.length ? "dashed" : "solid"} var(--${colour})`;
  return make("label", {}, box, " ", swatch, ` ${words}`);
}));
byId("curves-run").replaceChildren(
  ...data.runs.map((one, k) => make("option", { value: k, textContent: one.words }))
);
byId("curves-run").value = data.first;
byId("curves-run").onchange = byId("curves-channel").onchange = pick;
pick();
