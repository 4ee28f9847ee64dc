// Pickers, sliders, pointer and keys of the map, and the commands that compute what it shows.
const map = byId("map");
let context = map.getContext("2d");
const redraw = follow(map, (width) => Math.max(260, Math.min(560, 0.62 * width)), (c, w, h) => {
  context = c;
  picture = cellsOfView();
  draw(c, w, h);
  commands();
});

function choose(id, names, chosen, change) {
  const options = names.map(([value, text]) => make("option", { value, textContent: text }));
  byId(id).replaceChildren(...options);
  byId(id).value = chosen;
  byId(id).onchange = () => change(Number(byId(id).value));
}

function controls() {
  choose("output", outputs.map((o, k) => [k, o.label]), view.output, (k) => changed({ output: k }));
  const names = long.map((k) => [k, axes[k].label]);
  // An axis that is picked a second time changes places with the first.
  choose("x", names, view.x, (k) => changed(k === view.y ? { x: k, y: view.x } : { x: k }));
  choose("y", names, view.y, (k) => changed(k === view.x ? { x: view.y, y: k } : { y: k }));
  const sliders = long.filter((k) => k !== view.x && k !== view.y).map((k) => {
    const { label, values, unit } = axes[k];
    const shown = make("output", { textContent: withUnit(values[view.at[k]], unit) });
    const slider = make("input", { type: "range", min: 0, max: values.length - 1, value: view.at[k] });
    slider.setAttribute("aria-valuetext", shown.textContent);
    slider.oninput = () => {
      view.at[k] = Number(slider.value);
      shown.textContent = withUnit(values[view.at[k]], unit);
      slider.setAttribute("aria-valuetext", shown.textContent);
      redraw();
    };
    return make("label", {}, make("span", { textContent: label }), slider, shown);
  });
  byId("sliders").replaceChildren(...sliders);
  byId("best").hidden = !outputs[view.output].best || view.y < 0;
}

function changed(what) {
  Object.assign(view, what, { cell: null, pinned: null });
  controls();
  redraw();
  point(null);
}

// The view in the words of the shell and of Python.
function commands() {
  const output = outputs[view.output];
  const shell = (v) => (v === Infinity ? "inf" : v === -Infinity ? "-inf" : String(v));
  const python = (v) => (Number.isFinite(v) ? String(v) : `float("${shell(v)}")`);
  const rest = axes.map((_, k) => k).filter((k) => k !== view.x && k !== view.y);
  const drawn = [view.y, view.x].filter((k) => k >= 0);
  const flags = output.flags.slice(-drawn.length);
  byId("shell").value = [
    output.shell, ...drawn.map((k, i) => `${flags[i]} ${axes[k].shell}`),
    ...rest.map((k) => `--set ${axes[k].name}=${shell(axes[k].values[view.at[k]])}`), output.tail,
  ].join(" ");
  const set = rest.map((k) => `${axes[k].name}=${python(axes[k].values[view.at[k]])}`);
  const call = (some) => `${output.python}${[...some, ...set, ...output.more].join(", ")})`;
  const swept = call(drawn.map((k) => `${axes[k].name}=${axes[k].python}`));
  const shown = drawn.length > 1 ? `heatmap("${axes[view.x].name}", "${axes[view.y].name}")` : `curves("${axes[view.x].name}")`;
  byId("python").value = `${sweep.imports}\n${swept}.plot.${shown}`;
  const cell = view.pinned;
  byId("cell").parentElement.hidden = !cell;
  if (!cell) return;
  const at = [view.x, view.y].filter((k) => k >= 0).map((k, i) => `${axes[k].name}=${python(axes[k].values[cell[i]])}`);
  byId("cell").value = `${sweep.imports}\n${call(at)}`;
}

function point(cell, pin = false) {
  view.cell = cell;
  if (pin) {
    view.pinned = cell;
    commands();
  }
  byId("readout").textContent = cell ? said(cell) : view.pinned ? said(view.pinned) : sweep.hint;
  context.clearRect(0, 0, map.width, map.height);
  context.drawImage(layer, 0, 0, map.clientWidth, map.clientHeight);
  cursor(context);
}

function under(event) {
  const box = map.getBoundingClientRect();
  const x = Math.floor(((event.clientX - box.left - place.x) / place.w) * picture.nx);
  const y = Math.floor(((place.y + place.h - event.clientY + box.top) / place.h) * picture.ny);
  return x >= 0 && y >= 0 && x < picture.nx && y < picture.ny ? [x, y] : null;
}
map.onpointermove = (event) => point(under(event));
map.onpointerleave = () => point(null);
map.onclick = (event) => point(under(event), true);
map.onkeydown = (event) => {
  const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
  const { nx, ny } = picture;
  const cell = view.cell ?? view.pinned ?? [nx >> 1, ny >> 1];
  if (step) point([0, 1].map((k) => Math.max(0, Math.min([nx, ny][k] - 1, cell[k] + step[k]))));
  else if (event.key === "Enter" || event.key === " ") point(cell, true);
  else if (event.key === "Escape") [view.pinned, view.cell] = [null, null], point(null, true);
  else return;
  event.preventDefault();
};
byId("colours").onchange = byId("ridge").onchange = redraw;
for (const button of document.querySelectorAll("button[data-copy]")) {
  button.onclick = () => {
    const text = byId(button.dataset.copy);
    text.select();
    // Old, but works in a file and in a notebook, where the clipboard may be closed to a page.
    byId("copied").textContent = document.execCommand("copy") ? "Copied." : "Marked: copy it with Ctrl+C.";
  };
}
controls();
redraw();
point(null);
