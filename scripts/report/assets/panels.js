import { colorOf, element, ROWS } from "./colors.js";
import { upper } from "./model.js";
import { drawImage, metric, panorama, perceptual } from "./sheets.js";

const AROUND = 9; // events shown before and after the moment

/** How the wheels turn, in words. Counter-clockwise is to the left. */
export function motion(left, right) {
  const [sum, turn] = [left + right, right - left];
  const most = Math.max(Math.abs(left), Math.abs(right));
  if (most < 1) return "stands still";
  const side = turn > 0 ? "left" : "right";
  if (Math.abs(sum) < 0.25 * most) return `turns ${side} on the spot`;
  const way = sum < 0 ? "backs up" : "drives";
  if (Math.abs(turn) < 0.04 * most) return `${way} straight`;
  return `${way}, turning ${side}${Math.abs(turn) > 0.5 * most ? " sharply" : ""}`;
}

/** What happens at this moment, and why. */
export class Now {
  constructor(app) {
    this.app = app;
    this.box = document.getElementById("now");
    this.when = element("span", { className: "when" });
    this.swatch = element("i", { className: "swatch" });
    this.who = element("span", { className: "who" });
    this.what = element("p");
    this.wheels = element("p");
    this.since = element("p", { className: "since" });
    this.box.append(this.when, this.swatch, this.who, this.what, this.wheels, this.since);
  }
  draw() {
    const { run, moment, time } = this.app;
    const driver = run.driverAt(moment);
    const state = run.stateAt(driver, moment).toLowerCase().replaceAll("_", " ");
    const reason = driver ? run.reasonAt(driver, moment) : "";
    const [left, right] = [run.left.data[moment] ?? 0, run.right.data[moment] ?? 0];
    this.when.textContent = `${time.toFixed(2)} s`;
    this.swatch.style.background = colorOf(driver);
    this.who.textContent = driver ? `${driver} drives` : "nobody drives";
    const why = reason && reason !== state ? `, because: ${reason}` : "";
    this.what.textContent = driver ? `${state ? `It is in state ${state}` : "Its state is not recorded"}${why}.` : "";
    this.wheels.textContent = `The robot ${motion(left, right)}: left wheel ${Math.round(left)}, right ${Math.round(right)} steps/s.`;
    const change = run.last("ControlChanged", moment);
    this.since.textContent = change ? `Since ${run.time(change.at).toFixed(2)} s: ${change.text}` : "";
  }
}

/** How likely the robot is at each node, while it finds out where it is. */
export class Belief {
  constructor(app) {
    this.app = app;
    this.section = document.getElementById("belief");
    this.box = document.getElementById("beliefs");
  }
  draw() {
    const belief = this.app.run.beliefAt(this.app.moment);
    const known = Object.entries(belief).sort((a, b) => b[1] - a[1] || a[0] - b[0]);
    this.section.hidden = !known.length;
    const key = JSON.stringify(known);
    if (key === this.key) return;
    this.key = key;
    this.box.replaceChildren(
      ...known.slice(0, 12).map(([node, weight]) => {
        const bar = element("i");
        bar.style.width = `${100 * weight}%`;
        return element("div", { className: "bar" }, element("span", { textContent: `node ${node}` }), bar,
          element("span", { textContent: weight < 0.001 ? "~0" : weight.toFixed(3) }));
      }),
    );
  }
}

/** A node: its place, arcs, views and self-organizing maps. */
export class Detail {
  constructor(app) {
    this.app = app;
    this.section = document.getElementById("detail");
    this.select = document.getElementById("nodes");
    this.box = document.getElementById("details");
    this.unit = -1;
    this.select.addEventListener("change", () => app.select(this.select.value === "" ? undefined : Number(this.select.value)));
  }
  draw() {
    const { run, moment, node: chosen } = this.app;
    const there = [...run.nodes.values()].filter((node) => node.at <= moment).sort((a, b) => a.node - b.node);
    const names = there.map((node) => node.node).join();
    if (names !== this.names) {
      this.names = names;
      const none = element("option", { value: "", textContent: there.length ? "choose, or click one" : "none yet" });
      this.select.replaceChildren(none, ...there.map((node) =>
        element("option", { value: node.node, textContent: node.name === `n${node.node}` ? node.node : `${node.node} (${node.name})` })));
    }
    const node = there.find((each) => each.node === chosen);
    this.select.value = node ? String(chosen) : "";
    const arcs = run.arcs.filter((arc) => arc.start === chosen && arc.at <= moment);
    const key = [chosen, node && node.local && node.localAt <= moment, arcs.length, this.app.theme, run.version, this.unit].join();
    if (key === this.key) return;
    if (this.shown !== chosen) this.unit = -1;
    this.shown = chosen;
    this.key = key;
    this.box.replaceChildren(...(node ? this.told(node, arcs, node.local && node.localAt <= moment) : []));
  }
  told(node, arcs, mapped) {
    const degrees = (angle) => `${Math.round((180 * angle) / Math.PI)}\u00b0`;
    const facts = [["corner", node.corner]];
    if (node.turn !== undefined) facts.push(["turn", degrees(node.turn)], ["entry heading", degrees(node.entry)]);
    if (node.pose) facts.push(["drawn at", `${node.pose[0].toFixed(3)}, ${node.pose[1].toFixed(3)} m`]);
    const line = element("p", { textContent: facts.map(([name, value]) => `${name} ${value}`).join("; ") });
    const head = ["to", "by", "distance", "deviation", "driven"].map((text) => element("th", { textContent: text }));
    const rows = arcs.map((arc) => {
      const to = element("button", { className: "link", textContent: `node ${arc.end}` });
      to.addEventListener("click", () => this.app.select(arc.end));
      const cells = [to, `${arc.kind}${arc.blocked ? ", blocked" : ""}`, `${(100 * arc.distance).toFixed(1)} cm`,
        `${(100 * Math.sqrt(arc.variance)).toFixed(1)} cm`, `${arc.traversals} times`];
      return element("tr", {}, ...cells.map((cell) => element("td", {}, cell)));
    });
    const table = element("div", { className: "scroll" }, element("table", {}, element("tr", {}, ...head), ...rows));
    return [line, ...(rows.length ? [table] : []), ...(mapped ? [this.figures(node.local)] : [])];
  }
  figures(local) {
    const box = element("div", { className: "figures" });
    if (local.panorama) box.append(panorama(local.panorama));
    box.append(metric(local, this.unit));
    if (local.views) {
      const choose = (unit) => {
        this.unit = unit;
        this.app.redraw();
      };
      box.append(perceptual(local, choose, this.unit));
      if (this.unit >= 0) {
        const where = local.seen[this.unit]
          ? `${(100 * local.viewX[this.unit]).toFixed(1)}, ${(100 * local.viewY[this.unit]).toFixed(1)} cm from the node`
          : "nowhere in particular";
        box.append(panorama(local.views, 1024 * this.unit, `Unit ${this.unit}, seen ${where}: left, ahead, right, behind`));
      }
    }
    return box;
  }
}

/** A behavior: what it is for, its goal and its settings. */
export class Settings {
  constructor(app) {
    this.app = app;
    this.section = document.getElementById("settings");
  }
  draw() {
    const name = this.app.behavior;
    if (name === this.name) return;
    this.name = name;
    this.section.hidden = !name;
    if (!name) return;
    const what = this.app.run.behaviors.get(name);
    const close = element("button", { textContent: "Close", onclick: () => this.app.showBehavior("") });
    const title = element("h2", {}, `Behavior ${name}`, close);
    if (!what) return this.section.replaceChildren(title, element("p", { textContent: "This recording does not describe it." }));
    const about = element("p", { textContent: `${what.about} Priority ${what.priority}.` });
    const rows = Object.entries(what.settings).map(([key, value]) =>
      element("tr", {}, element("th", { textContent: key }), element("td", { textContent: JSON.stringify(value) })));
    const none = element("p", { textContent: "It has no settings." });
    this.section.replaceChildren(title, about, rows.length ? element("table", {}, ...rows) : none);
    this.section.scrollIntoView({ block: "nearest" });
  }
}

/** The last camera image that was taken. */
export class CameraImage {
  constructor(app) {
    this.app = app;
    this.section = document.getElementById("camera");
  }
  draw() {
    const image = this.app.run.imageAt(this.app.moment);
    this.section.hidden = !image;
    if (!image || image.at === this.at) return;
    this.at = image.at;
    drawImage(document.getElementById("image"), image);
    document.getElementById("image-time").textContent = `taken at ${this.app.run.time(image.at).toFixed(2)} s`;
  }
}

/** The events around this moment; a click goes there. */
export class Events {
  constructor(app) {
    this.app = app;
    this.list = document.getElementById("events");
    this.row = "";
    const select = element("select", { ariaLabel: "Which events" }, element("option", { value: "", textContent: "all" }));
    for (const [row, { label }] of Object.entries(ROWS)) select.append(element("option", { value: row, textContent: label }));
    select.addEventListener("change", () => {
      this.row = select.value;
      app.redraw();
    });
    document.getElementById("filters").append(select);
  }
  draw() {
    const { run, moment } = this.app;
    const [events, times] = this.chosen();
    const passed = upper(times, moment);
    const from = Math.max(0, passed - AROUND);
    const key = [this.row, from, passed, events.length].join();
    if (key === this.key) return;
    this.key = key;
    this.list.replaceChildren(
      ...events.slice(from, passed + AROUND).map((event, index) => {
        const dot = element("i", { className: "swatch" });
        dot.style.background = ROWS[event.row].color;
        const when = element("span", { className: "time", textContent: `${run.time(event.at).toFixed(2)} s` });
        const text = element("span", { className: "text", textContent: event.text, title: event.text });
        const button = element("button", { onclick: () => this.app.seek(run.time(event.at)) }, when, dot, text);
        const place = from + index - passed;
        return element("li", { className: place >= 0 ? "later" : place === -1 ? "current" : "" }, button);
      }),
    );
  }
  chosen() {
    const { run } = this.app;
    if (!this.row) return [run.events, run.eventTimes()];
    const known = `${this.row} ${run.events.length}`;
    if (known !== this.known) {
      this.known = known;
      this.filtered = run.events.filter((event) => event.row === this.row);
      this.filteredTimes = this.filtered.map((event) => event.at);
    }
    return [this.filtered, this.filteredTimes];
  }
}
