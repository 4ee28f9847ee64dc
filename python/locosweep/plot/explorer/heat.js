// A sweep as a map: two axes are drawn, sliders stand for the others.
const sweep = JSON.parse(byId("sweep").textContent);
const { axes, outputs, statuses } = sweep;
for (const axis of axes) axis.values = axis.values.map(Number);
const strides = axes.map((_, k) => axes.slice(k + 1).reduce((n, a) => n * a.values.length, 1));
const long = axes.map((_, k) => k).filter((k) => axes[k].values.length > 1);
const FIRST_STATUS = 65504; // of 16 bits: codes from here on are statuses

// First the two longest axes, as they show most; the last one to the right.
const length = (k) => axes[k].values.length;
const first = [...long].sort((a, b) => length(b) - length(a) || b - a).slice(0, 2).sort((a, b) => b - a);
const view = {
  output: 0,
  x: first[0],
  y: first[1] ?? -1,
  at: sweep.start,
  cell: null,
  pinned: null,
};
let picture = null; // cells of the view: values, codes, extremes
let layer = null; // what is drawn but for the cell under the pointer
let place = null; // rectangle of the map on the canvas

const store = outputs.map((output, k) => {
  if (output.kind === "uint16") {
    const codes = decoded(`values-${k}`, Uint16Array);
    const step = (output.hi - output.lo) / (FIRST_STATUS - 1);
    return {
      value: (i) => (codes[i] < FIRST_STATUS ? output.lo + step * codes[i] : NaN),
      status: (i) => Math.max(0, codes[i] - FIRST_STATUS),
    };
  }
  // The status stands in the lowest bits of a NaN.
  const values = decoded(`values-${k}`, Float32Array);
  const bits = new Uint32Array(values.buffer);
  return { value: (i) => values[i], status: (i) => (values[i] === values[i] ? 0 : bits[i] & 31) };
});

function cellsOfView() {
  const { value, status } = store[view.output];
  const nx = axes[view.x].values.length;
  const ny = view.y < 0 ? 1 : axes[view.y].values.length;
  let start = 0;
  axes.forEach((_, k) => {
    if (k !== view.x && k !== view.y) start += strides[k] * view.at[k];
  });
  const found = { nx, ny, values: new Float64Array(nx * ny), codes: new Uint8Array(nx * ny) };
  let [lo, hi, best] = [Infinity, -Infinity, -1];
  for (let j = 0, i = 0; j < ny; j++) {
    const row = start + (view.y < 0 ? 0 : strides[view.y] * j);
    for (let k = 0; k < nx; k++, i++) {
      const from = row + strides[view.x] * k;
      const v = (found.values[i] = value(from));
      if (v !== v) found.codes[i] = status(from);
      if (v > hi) [hi, best] = [v, i];
      if (v < lo) lo = v;
    }
  }
  return Object.assign(found, { lo, hi, best });
}

// Ends of the colours.
function scaleOf(output) {
  const own = byId("colours").value === "view" && picture.best >= 0;
  const [lo, hi] = own ? [picture.lo, picture.hi] : [output.lo, output.hi];
  const size = Math.max(-lo, hi);
  return output.both ? [-size, size] : [lo, hi];
}

const lut = Object.fromEntries(Object.entries(sweep.colours).map(([name, text]) =>
  [name, text.match(/.{6}/g).map((one) => parseInt(one, 16))]));
const SLANTS = [[0, -1, 1].map((d) => [10 * d - 1, 11, 10 * d + 11, -1]), [0, -1, 1].map((d) => [10 * d - 1, -1, 10 * d + 11, 11])];
const FLAT = [[0, 5, 10, 5]];
const STEEP = [[5, 0, 5, 10]];
const HATCHES = [SLANTS[0], SLANTS[1], SLANTS.flat(), [2.5, 7.5], [5], [...FLAT, ...STEEP], FLAT, STEEP];

// A hatch: lines from point to point, or dots on the diagonal.
function tile(context, code) {
  const small = make("canvas", { width: 10, height: 10 });
  const c = small.getContext("2d");
  // There are more reasons than hatches: others are drawn light on dark, and then bold.
  const turn = Math.floor((code - 1) / HATCHES.length);
  const [below, above] = turn % 2 ? ["hatch", "gap"] : ["gap", "hatch"];
  c.fillStyle = ink(below);
  c.fillRect(0, 0, 10, 10);
  c.strokeStyle = ink(above);
  c.lineWidth = 1.3 + 1.6 * (turn >> 1);
  for (const line of HATCHES[(code - 1) % HATCHES.length]) {
    c.beginPath();
    if (Array.isArray(line)) c.moveTo(line[0], line[1]), c.lineTo(line[2], line[3]);
    else c.arc(line, line, 1.8, 0, 7);
    c.stroke();
  }
  return context.createPattern(small, "repeat");
}

function axisTicks(axis, pixels) {
  const v = axis.values;
  const step = (v.at(-1) - v[0]) / (v.length - 1 || 1);
  const even = v.length > 1 && v.every((one, i) => Math.abs(one - v[0] - i * step) < 1e-6 * step);
  const most = Math.max(2, Math.floor(pixels / 58));
  if (even) return ticks(v[0], v.at(-1), most, axis.integer).map(([t, text]) => [(t - v[0]) / step, text]);
  const every = Math.ceil(v.length / most);
  return v.map((one, i) => [i, num(one)]).filter(([i]) => i % every === 0);
}

// Cells as an image, whose rows go down where values rise.
function image(colourOf) {
  const { nx, ny } = picture;
  const pixels = new ImageData(nx, ny);
  const words = new Uint32Array(pixels.data.buffer);
  for (let j = 0, i = 0; j < ny; j++) {
    for (let k = 0, o = (ny - 1 - j) * nx; k < nx; k++, i++, o++) words[o] = colourOf(i);
  }
  const small = make("canvas", { width: nx, height: ny });
  small.getContext("2d").putImageData(pixels, 0, 0);
  return small;
}

function draw(context, width, height) {
  const output = outputs[view.output];
  const narrow = width < 520;
  place = { x: narrow ? 52 : 66, y: 10, h: height - 56, w: width - (narrow ? 128 : 162) };
  const { values, codes } = picture;
  const [lo, hi] = scaleOf(output);
  const colours = lut[output.both ? "both" : "one"];
  const packed = colours.map((c) => ((255 << 24) | ((c & 255) << 16) | (c & 0xff00) | (c >> 16)) >>> 0);
  const factor = hi > lo ? 255 / (hi - lo) : 0;
  const seen = new Map();
  context.clearRect(0, 0, width, height);
  context.imageSmoothingEnabled = false;
  const map = image((i) => {
    if (!codes[i]) return packed[Math.round(factor * (values[i] - lo))];
    seen.set(codes[i], (seen.get(codes[i]) ?? 0) + 1);
    return 0;
  });
  context.drawImage(map, place.x, place.y, place.w, place.h);
  for (const code of seen.keys()) {
    const large = make("canvas", { width: Math.ceil(place.w), height: Math.ceil(place.h) });
    const c = large.getContext("2d");
    c.imageSmoothingEnabled = false;
    c.drawImage(image((i) => (codes[i] === code ? 0xff000000 : 0)), 0, 0, large.width, large.height);
    c.globalCompositeOperation = "source-in";
    c.fillStyle = tile(c, code);
    c.fillRect(0, 0, large.width, large.height);
    context.drawImage(large, place.x, place.y, place.w, place.h);
  }
  frame(context, width, height);
  bar(context, output, lo, hi, colours, narrow);
  if (output.best) marks(context);
  legend(seen);
  layer ??= make("canvas", {});
  [layer.width, layer.height] = [context.canvas.width, context.canvas.height];
  layer.getContext("2d").drawImage(context.canvas, 0, 0);
  cursor(context);
}

// Middle of a cell on the canvas, also between cells.
const across = (i) => place.x + ((i + 0.5) / picture.nx) * place.w;
const upward = (j) => place.y + place.h - ((j + 0.5) / picture.ny) * place.h;

function frame(context, width, height) {
  context.strokeStyle = context.fillStyle = ink("text");
  context.lineWidth = 1;
  context.strokeRect(place.x, place.y, place.w, place.h);
  context.textAlign = "center";
  for (const [at, text] of axisTicks(axes[view.x], place.w)) {
    context.fillRect(across(at) - 0.5, place.y + place.h, 1, 4);
    context.fillText(text, across(at), place.y + place.h + 16);
  }
  context.fillText(axes[view.x].label, place.x + place.w / 2, height - 12, width - 12);
  if (view.y < 0) return;
  context.textAlign = "right";
  for (const [at, text] of axisTicks(axes[view.y], 1.6 * place.h)) {
    context.fillRect(place.x - 4, upward(at) - 0.5, 4, 1);
    context.fillText(text, place.x - 6, upward(at) + 4);
  }
  turned(context, axes[view.y].label, 12, place.y + place.h / 2, place.h);
}

function bar(context, output, lo, hi, colours, narrow) {
  const left = place.x + place.w + 10;
  const whole = output.integer && hi - lo < 16;
  const count = whole ? hi - lo + 1 : 128;
  for (let i = 0; i < count; i++) {
    const colour = colours[Math.round((255 * i) / Math.max(1, count - 1))];
    context.fillStyle = `#${colour.toString(16).padStart(6, "0")}`;
    context.fillRect(left, place.y + place.h * (1 - (i + 1) / count), 13, place.h / count + 0.6);
  }
  context.strokeStyle = context.fillStyle = ink("text");
  context.strokeRect(left, place.y, 13, place.h);
  context.textAlign = "left";
  for (const [t, text] of ticks(lo, hi, place.h / 40, output.integer)) {
    const up = whole ? (t - lo + 0.5) / count : hi > lo ? (t - lo) / (hi - lo) : 0.5;
    context.fillRect(left + 13, place.y + place.h * (1 - up) - 0.5, 3, 1);
    context.fillText(text, left + 18, place.y + place.h * (1 - up) + 4, narrow ? 34 : 52);
  }
  turned(context, output.label, left + (narrow ? 60 : 78), place.y + place.h / 2, place.h);
}

// The highest value, and the y of the highest value above each x.
function marks(context) {
  const { nx, ny, values, best } = picture;
  if (best < 0) return;
  if (byId("ridge").checked && ny > 1) {
    for (const [colour, wide] of [["#000", 3.6], ["#fff", 1.6]]) {
      context.beginPath();
      for (let k = 0, drawing = false; k < nx; k++) {
        let top = -1;
        for (let j = 0; j < ny; j++) {
          const i = j * nx + k;
          if (values[i] === values[i] && (top < 0 || values[i] > values[top])) top = i;
        }
        if (top < 0) drawing = false;
        else {
          context[drawing ? "lineTo" : "moveTo"](across(k), upward(Math.floor(top / nx)));
          drawing = true;
        }
      }
      Object.assign(context, { strokeStyle: colour, lineWidth: wide });
      context.stroke();
    }
  }
  context.beginPath();
  for (let k = 0; k < 10; k++) {
    const [r, angle] = [k % 2 ? 4 : 10, (Math.PI * k) / 5];
    context.lineTo(
      across(best % nx) + r * Math.sin(angle),
      upward(Math.floor(best / nx)) - r * Math.cos(angle)
    );
  }
  context.closePath();
  Object.assign(context, { fillStyle: "#fff", strokeStyle: "#000", lineWidth: 1.2 });
  context.fill();
  context.stroke();
}

function cursor(context) {
  for (const [cell, dash] of [[view.pinned, []], [view.cell, [4, 3]]]) {
    if (!cell) continue;
    const [w, h] = [place.w / picture.nx, place.h / picture.ny];
    const [wide, tall] = [Math.max(w, 7), Math.max(h, 7)];
    for (const [colour, line] of [["#000", 3], ["#fff", 1.4]]) {
      Object.assign(context, { strokeStyle: colour, lineWidth: line });
      context.setLineDash(dash);
      context.strokeRect(across(cell[0]) - wide / 2, upward(cell[1]) - tall / 2, wide, tall);
    }
    context.setLineDash([]);
  }
}

function legend(seen) {
  const items = [...seen].sort((a, b) => a[0] - b[0]).map(([code, n]) => {
    const swatch = make("canvas", { width: 30, height: 16, ariaHidden: "true" });
    const c = swatch.getContext("2d");
    c.fillStyle = tile(c, code);
    c.fillRect(0, 0, 30, 16);
    return make("li", {}, swatch, ` ${statuses[code]} (${num((100 * n) / picture.codes.length, 2)} % of the map)`);
  });
  byId("legend").replaceChildren(...items);
  const { best, hi, nx } = picture;
  const output = outputs[view.output];
  const where = best < 0 ? "" : named([best % nx, Math.floor(best / nx)]);
  const high = `Highest in this map${output.best ? " (star)" : ""}: ${withUnit(hi, output.unit)} at ${where}.`;
  byId("highest").textContent = best < 0 ? "No cell of this map has a value." : high;
}

const named = (cell) =>
  [view.x, view.y].filter((k) => k >= 0)
    .map((k, i) => `${axes[k].words} ${withUnit(axes[k].values[cell[i]], axes[k].unit)}`).join(", ");

function said(cell) {
  const i = cell[1] * picture.nx + cell[0];
  const code = picture.codes[i];
  const output = outputs[view.output];
  const what = code ? `no value: ${statuses[code]}` : `${output.words} ${withUnit(picture.values[i], output.unit)}`;
  return `${named(cell)}: ${what}`;
}
