import { colorOf, element, inkOn } from "./colors.js";

const SVG = "http://www.w3.org/2000/svg";
const [WIDE, HIGH] = [440, 270];

function svg(tag, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

const words = (state) => state.toLowerCase().replaceAll("_", " ");

/** The state machine of the behavior in control, or of one that was chosen, with its state lit. */
export class Machine {
  constructor(app) {
    this.app = app;
    this.box = document.getElementById("machines");
    this.name = document.getElementById("machine-name");
    this.drawn = new Map();
    this.chosen = "";
    this.shown = "";
  }

  /** The description at `parent/child`. */
  described(path) {
    const [name, ...children] = path.split("/");
    return children.reduce((found, child) => found?.children?.[child], this.app.run.behaviors.get(name));
  }

  draw() {
    const { run, moment } = this.app;
    const driver = this.app.behavior || run.driverAt(moment);
    const paths = [...run.states.keys()].filter((path) => path.startsWith(`${driver}/`) && run.stateAt(path, moment));
    const path = this.chosen.startsWith(driver) && driver ? this.chosen : driver;
    const key = [path, ...paths].join();
    if (key !== this.shown) this.show(path, driver, paths);
    this.shown = key;
    this.light(path);
  }

  show(path, driver, children) {
    const what = this.described(path);
    const chosen = this.app.behavior;
    this.name.textContent = driver ? `of ${path}${chosen ? " (chosen)" : ", in control"}` : "";
    const chips = element("div", { className: "chips" });
    if (chosen) chips.append(element("button", { textContent: "back to who drives", onclick: () => this.app.showBehavior("") }));
    if (children.length)
      for (const each of [driver, ...children]) {
        const chip = element("button", { textContent: each.split("/").at(-1), ariaPressed: String(each === path) });
        chip.addEventListener("click", () => {
          this.chosen = each;
          this.shown = "";
          this.app.redraw();
        });
        chips.append(chip);
      }
    if (!what) {
      const why = driver ? "This recording does not say what its states are." : "Nobody drives.";
      this.box.replaceChildren(chips, element("p", { textContent: why }));
      return;
    }
    if (!this.drawn.has(path)) this.drawn.set(path, diagram(what));
    const { picture, ways } = this.drawn.get(path);
    this.box.replaceChildren(chips, picture, ways);
  }

  light(path) {
    const drawn = this.drawn.get(path);
    if (!drawn) return;
    const state = this.app.run.stateAt(path, this.app.moment);
    if (drawn.lit === state) return;
    drawn.lit = state;
    const color = colorOf(path.split("/")[0]);
    drawn.picture.style.setProperty("--lit", color);
    drawn.picture.style.setProperty("--lit-ink", inkOn(color));
    for (const [name, box] of drawn.states) box.classList.toggle("lit", name === state);
    for (const [source, edge] of drawn.edges) edge.classList.toggle("out", source === state);
    const out = drawn.table.filter(([source]) => source === state);
    const way = ([, target, triggers]) => `${triggers.replaceAll("_", " ")} \u2192 ${words(target)}`;
    drawn.ways.textContent = state ? `From ${words(state)}: ${out.map(way).join("; ") || "no way out"}` : "It is not active.";
    drawn.picture.setAttribute("aria-label", `${path}: ${state ? words(state) : "not active"}`);
  }
}

function diagram({ states, edges, initial }) {
  const places = new Map();
  states.forEach((state, index) => {
    const angle = (2 * Math.PI * index) / states.length;
    const alone = states.length === 1 ? 0 : 1;
    places.set(state, [
      WIDE / 2 + alone * (WIDE / 2 - 66) * Math.sin(angle),
      HIGH / 2 - alone * (HIGH / 2 - 26) * Math.cos(angle),
    ]);
  });
  const picture = svg("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img" });
  const drawnEdges = edges.map(([source, target, label]) => [source, arrow(places, source, target, label)]);
  const drawnStates = states.map((state) => [state, box(places.get(state), state, state === initial)]);
  picture.append(...drawnEdges.map(([, edge]) => edge), ...drawnStates.map(([, each]) => each));
  const ways = element("p", { className: "ways" });
  return { picture, ways, table: edges, states: drawnStates, edges: drawnEdges, lit: null };
}

const halfWidth = (state) => 3.3 * words(state).length + 9;

function box([x, y], state, initial) {
  const half = halfWidth(state);
  const text = svg("text", { x, y: y + 4, "text-anchor": "middle" }, words(state));
  const rect = svg("rect", { x: x - half, y: y - 11, width: 2 * half, height: 22, rx: 7 });
  const parts = [rect, text];
  if (initial) parts.unshift(svg("circle", { cx: x - half - 7, cy: y, r: 3, fill: "currentColor" }));
  return svg("g", { class: "state" }, ...parts);
}

/** Where the line from the middle of a state's box towards a point leaves the box. */
function rim([x, y], half, [tx, ty]) {
  const [dx, dy] = [tx - x, ty - y];
  const share = Math.min((half + 3) / Math.max(1e-6, Math.abs(dx)), 14 / Math.max(1e-6, Math.abs(dy)));
  return [x + share * dx, y + share * dy];
}

function arrow(places, source, target, triggers) {
  const label = triggers.replaceAll("_", " ");
  const title = svg("title", {}, `${words(source)} - ${label} - ${words(target)}`);
  const [from, to] = [places.get(source), places.get(target)];
  const group = svg("g", { class: "edge" }, title);
  if (source === target) {
    const [x, y] = [from[0] + halfWidth(source) - 8, from[1] - 11];
    group.append(svg("path", { d: `M${x - 10},${y} C${x - 12},${y - 18} ${x + 12},${y - 18} ${x + 6},${y}` }));
    return group;
  }
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const middle = [(from[0] + to[0]) / 2 - 0.16 * dy, (from[1] + to[1]) / 2 + 0.16 * dx];
  const start = rim(from, halfWidth(source), middle);
  const end = rim(to, halfWidth(target), middle);
  group.append(svg("path", { d: `M${start} Q${middle} ${end}` }));
  const angle = Math.atan2(end[1] - middle[1], end[0] - middle[0]);
  const tip = [0, 2.7, -2.7].map((turn) => [end[0] + (turn ? 8 * Math.cos(angle + turn) : 0), end[1] + (turn ? 8 * Math.sin(angle + turn) : 0)]);
  group.append(svg("polygon", { points: tip.map((point) => point.join()).join(" ") }));
  return group;
}
