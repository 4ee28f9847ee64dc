// What the map of a sweep and the curves of runs share: numbers, ticks, canvases, arrays.
"use strict";

const byId = (id) => document.getElementById(id);

function make(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

function num(value, digits = 4) {
  if (!Number.isFinite(value)) return value === Infinity ? "∞" : value === -Infinity ? "−∞" : "none";
  const short = Number(value.toPrecision(digits));
  const size = Math.abs(short);
  const text = size !== 0 && (size < 1e-4 || size >= 1e6) ? short.toExponential() : String(short);
  return text.replace(/-/g, "−").replace("e+", "e");
}

const withUnit = (value, unit) => (unit ? `${num(value)} ${unit}` : num(value));

// Round numbers from lo to hi, about `most` of them, each with its text of equally many decimals.
function ticks(lo, hi, most, whole = false) {
  const raw = (hi - lo) / Math.max(most, 1);
  if (!(raw > 0) || !Number.isFinite(raw)) return [[lo, num(lo)]];
  const power = 10 ** Math.floor(Math.log10(raw));
  let step = power * [1, 2, 5, 10].find((factor) => factor * power >= 0.999999 * raw);
  if (whole) step = Math.max(1, Math.round(step));
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const plain = decimals <= 5 && Math.max(-lo, hi) < 1e6;
  const found = [];
  for (let k = Math.ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * step; k++) {
    const at = Number((k * step).toPrecision(12));
    found.push([at, plain ? at.toFixed(decimals).replace("-", "−") : num(at)]);
  }
  return found;
}

// Bytes are little-endian, as of every machine that runs a browser today.
function decoded(id, Kind) {
  const text = atob(byId(id).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new Kind(bytes.buffer);
}

const ink = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// Fit a canvas to its box in dots of the screen, and draw again when box, colours or medium change.
function follow(canvas, height, draw) {
  const fit = () => {
    const width = Math.max(200, Math.floor(canvas.parentElement.clientWidth));
    const tall = height(width);
    const dots = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * dots);
    canvas.height = Math.round(tall * dots);
    canvas.style.height = `${tall}px`;
    const context = canvas.getContext("2d");
    context.setTransform(dots, 0, 0, dots, 0, 0);
    context.font = '12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
    draw(context, width, tall);
  };
  new ResizeObserver(fit).observe(canvas.parentElement);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", fit);
  // Paper is white, whatever the screen is.
  const root = document.documentElement.classList;
  for (const [event, on] of [["beforeprint", true], ["afterprint", false]]) {
    window.addEventListener(event, () => {
      root.toggle("paper", on);
      fit();
    });
  }
  return fit;
}

function turned(context, text, x, y, most) {
  context.save();
  context.translate(x, y);
  context.rotate(-Math.PI / 2);
  context.textAlign = "center";
  context.fillText(text, 0, 0, most);
  context.restore();
}
