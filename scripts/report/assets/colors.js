// Colors that color-blind people tell apart (Okabe and Ito 2008), and those of the theme.

const SERIES = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8d8d8d", "#b8a800"];
export const ROWS = {
  control: { color: "#0072b2", label: "control", key: "c" },
  fault: { color: "#d55e00", label: "fault", key: "f" },
  node: { color: "#009e73", label: "node", key: "n" },
  closure: { color: "#cc79a7", label: "closure", key: "l" },
  map: { color: "#56b4e9", label: "map", key: "" },
  corner: { color: "#8d8d8d", label: "corner", key: "" },
  behavior: { color: "#b8a800", label: "behavior", key: "" },
  mission: { color: "#e69f00", label: "mission", key: "" },
  other: { color: "#8d8d8d", label: "other", key: "" },
};
const given = new Map();

/** The color of a behavior: the same all over the page. */
export function colorOf(name) {
  if (!name) return "#8d8d8d";
  if (!given.has(name)) given.set(name, SERIES[given.size % SERIES.length]);
  return given.get(name);
}

export function inkOn(color) {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
  return 0.3 * r + 0.59 * g + 0.11 * b > 135 ? "#000000" : "#ffffff";
}

let theme = {};
export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const names = "back panel ink soft line wall floor true free lattice arc foray blocked node ray robot accent unwanted";
  theme = Object.fromEntries(names.split(" ").map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}
export const shade = (name) => theme[name];

/** A canvas as large as it is shown, in the screen's own pixels; returns its context, in CSS pixels. */
export function fitted(canvas, width = canvas.clientWidth, height = canvas.clientHeight) {
  const ratio = window.devicePixelRatio || 1;
  const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
}

export function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name in made) made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}
