import { Camera } from "./camera.js";
import { colorOf, element, fitted, shade } from "./colors.js";

const STEP = 0.006; // m between two points of a path that is drawn
const LAYERS = [
  ["believed", "believed path", "accent"],
  ["true", "true path", "true"],
  ["rays", "infrared", "ray"],
  ["soms", "metric SOMs", "lattice"],
  ["graph", "nodes and arcs", "arc"],
];

/** The points of a path worth drawing, as moments; kept up while the run grows. */
class Path {
  constructor(columns, drivers) {
    Object.assign(this, { columns, drivers, moments: [], seen: 0 });
  }
  extend(count) {
    const [xs, ys] = [this.columns[0].data, this.columns[1].data];
    let last = this.moments.at(-1) ?? -1;
    for (let i = this.seen; i < count; i++) {
      const far = last < 0 || Math.abs(xs[i] - xs[last]) + Math.abs(ys[i] - ys[last]) > STEP;
      if (far || (this.drivers && this.drivers.data[i] !== this.drivers.data[last])) {
        this.moments.push(i);
        last = i;
      }
    }
    this.seen = count;
  }
}

export class World {
  constructor(app) {
    this.app = app;
    this.canvas = document.getElementById("plan");
    this.camera = new Camera(app.run.bounds());
    this.base = document.createElement("canvas");
    this.trail = document.createElement("canvas");
    this.baseKey = this.trailKey = "";
    this.following = false;
    const { run } = app;
    this.paths = { true: new Path(run.true, null), believed: new Path(run.believed, run.driver) };
    this.shown = { believed: true, true: true, rays: true, soms: true, graph: true };
    this.switches();
    this.controls();
  }

  switches() {
    const box = document.getElementById("layers");
    for (const [name, label, color] of LAYERS) {
      const there = { true: this.app.run.hasTruth || this.app.run.track.length, soms: true, graph: true };
      if (!(there[name] ?? this.app.run.count > 0) && !this.app.live) continue;
      const input = element("input", { type: "checkbox", checked: true });
      input.addEventListener("change", () => {
        this.shown[name] = input.checked;
        this.app.redraw();
      });
      const line = element("i");
      line.style.borderColor = `var(--${color})`;
      box.append(element("label", { className: "layer" }, input, line, label));
    }
  }

  controls() {
    const { canvas, camera, app } = this;
    const button = (id, act) =>
      document.getElementById(id).addEventListener("click", () => {
        act();
        app.redraw();
      });
    button("zoom-in", () => camera.zoom(1.4));
    button("zoom-out", () => camera.zoom(1 / 1.4));
    button("fit", () => this.fit());
    button("follow", () => this.follow(!this.following));
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        camera.zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
        app.redraw();
      },
      { passive: false },
    );
    let from = null;
    let moved = 0;
    canvas.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      moved = 0;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!from) return this.hover(event.offsetX, event.offsetY);
      const [dx, dy] = [event.clientX - from[0], event.clientY - from[1]];
      moved += Math.abs(dx) + Math.abs(dy);
      from = [event.clientX, event.clientY];
      if (moved > 3) {
        this.follow(false);
        camera.pan(dx, dy);
        app.redraw();
      }
    });
    canvas.addEventListener("pointerup", (event) => {
      from = null;
      const node = moved <= 3 ? this.nodeAt(event.offsetX, event.offsetY) : undefined;
      if (node !== undefined) app.select(node);
    });
    canvas.addEventListener("pointercancel", () => (from = null));
  }

  fit() {
    this.follow(false);
    this.camera.bounds = this.app.run.bounds();
    this.camera.fit();
  }

  follow(on) {
    this.following = on;
    document.getElementById("follow").setAttribute("aria-pressed", String(on));
    if (on && this.camera.whole) this.camera.zoom(3);
  }

  nodeAt(px, py) {
    let best;
    let least = this.radius() + 7;
    for (const node of this.visibleNodes()) {
      const [x, y] = this.camera.toScreen(node.pose[0], node.pose[1]);
      const away = Math.hypot(x - px, y - py);
      if (away < least) [least, best] = [away, node.node];
    }
    return best;
  }

  hover(px, py) {
    const node = this.nodeAt(px, py);
    this.canvas.style.cursor = node === undefined ? "grab" : "pointer";
    const [x, y] = this.camera.toWorld(px, py);
    const name = node === undefined ? "" : `node ${node}, ${this.app.run.nodes.get(node).corner}; `;
    this.canvas.title = `${name}x ${x.toFixed(3)} m, y ${y.toFixed(3)} m`;
  }

  *visibleNodes() {
    for (const node of this.app.run.nodes.values())
      if (node.pose && node.at <= this.app.moment) yield node;
  }

  radius() {
    return Math.max(7, Math.min(13, 0.022 * this.camera.scale));
  }

  draw() {
    const { canvas, camera, app } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    camera.resize(width, height);
    if (this.following && app.run.count) [camera.x, camera.y] = app.run.poseAt(app.moment);
    this.drawBase(width, height);
    this.drawTrail(width, height);
    const context = fitted(canvas);
    context.clearRect(0, 0, width, height);
    context.drawImage(this.base, 0, 0, width, height);
    context.drawImage(this.trail, 0, 0, width, height);
    if (this.shown.graph) {
      this.drawLengths(context);
      this.drawNodes(context);
    }
    if (app.run.count) this.drawRobots(context);
    this.drawScale(context, width, height);
  }

  // --- walls and map: drawn again only when the view, the theme or the map has changed

  drawBase(width, height) {
    const { app, camera } = this;
    const nodes = [...this.visibleNodes()];
    const maps = nodes.filter((node) => node.local && node.localAt <= app.moment);
    const arcs = app.run.arcs.filter((arc) => arc.at <= app.moment);
    const key = [camera.key, app.theme, nodes.length, maps.length, arcs.length, app.run.version, this.shown.soms,
      this.shown.graph, this.shown.true].join();
    if (key === this.baseKey) return;
    this.baseKey = key;
    const context = fitted(this.base, width, height);
    context.fillStyle = shade("floor");
    context.fillRect(0, 0, width, height);
    if (this.shown.soms) for (const node of maps) this.drawFree(context, node);
    this.drawWalls(context);
    if (this.shown.soms) for (const node of maps) this.drawLattice(context, node);
    if (this.shown.true && app.run.track.length) this.drawTrack(context);
    if (this.shown.graph) this.drawArcs(context, arcs);
  }

  trace(context, points) {
    points.forEach(([x, y], index) => {
      const [px, py] = this.camera.toScreen(x, y);
      if (index) context.lineTo(px, py);
      else context.moveTo(px, py);
    });
  }

  drawWalls(context) {
    context.beginPath();
    for (const outline of this.app.run.walls) {
      this.trace(context, outline);
      context.closePath();
    }
    context.fillStyle = context.strokeStyle = shade("wall");
    context.lineWidth = 1;
    context.fill("nonzero");
    context.stroke();
  }

  units(node) {
    const [x, y, heading] = node.pose;
    const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
    const { x: xs, y: ys } = node.local;
    return Array.from(xs, (dx, i) => [x + cos * dx - sin * ys[i], y + sin * dx + cos * ys[i]]);
  }

  edges(context, node, units, wanted) {
    const { edges, blocked } = node.local;
    const closed = new Set(blocked);
    context.beginPath();
    for (let i = 0; i < edges.length; i += 2)
      if (closed.has(i / 2) === wanted) this.trace(context, [units[edges[i]], units[edges[i + 1]]]);
  }

  drawFree(context, node) {
    const units = this.units(node);
    const wide = 2 * this.app.run.robot.radius * this.camera.scale;
    context.globalAlpha = 1;
    context.strokeStyle = mixed(shade("free"), shade("floor"), 0.26);
    context.lineCap = context.lineJoin = "round";
    context.lineWidth = wide;
    this.edges(context, node, units, false);
    context.stroke();
    context.lineCap = context.lineJoin = "butt";
    context.lineJoin = "miter";
  }

  drawLattice(context, node) {
    const units = this.units(node);
    context.strokeStyle = context.fillStyle = shade("lattice");
    context.globalAlpha = 0.55;
    context.lineWidth = 0.7;
    this.edges(context, node, units, false);
    context.stroke();
    context.globalAlpha = 1;
    context.strokeStyle = shade("blocked");
    context.lineWidth = 1.6;
    this.edges(context, node, units, true);
    context.stroke();
    if (this.camera.scale < 250) return;
    context.beginPath();
    units.forEach(([x, y], unit) => {
      if (!node.local.hits[unit]) return;
      const [px, py] = this.camera.toScreen(x, y);
      context.moveTo(px + 1.6, py);
      context.arc(px, py, 1.6, 0, 7);
    });
    context.fill();
  }

  drawTrack(context) {
    context.beginPath();
    this.trace(context, this.app.run.track);
    context.strokeStyle = shade("true");
    context.lineWidth = 1;
    context.stroke();
  }

  drawArcs(context, arcs) {
    const drawn = new Set();
    this.lengths = [];
    for (const arc of arcs) {
      const [a, b] = [this.app.run.nodes.get(arc.start), this.app.run.nodes.get(arc.end)];
      const key = [Math.min(arc.start, arc.end), Math.max(arc.start, arc.end), arc.kind === "foray"].join();
      if (!a?.pose || !b?.pose || drawn.has(key) || a.at > this.app.moment || b.at > this.app.moment) continue;
      drawn.add(key);
      const [x0, y0] = this.camera.toScreen(a.pose[0], a.pose[1]);
      const [x1, y1] = this.camera.toScreen(b.pose[0], b.pose[1]);
      context.beginPath();
      if (a === b) context.arc(x0, y0, 1.7 * this.radius(), 0, 7);
      else {
        context.moveTo(x0, y0);
        if (arc.kind === "foray") context.quadraticCurveTo((x0 + x1) / 2 + (y1 - y0) / 8, (y0 + y1) / 2 - (x1 - x0) / 8, x1, y1);
        else context.lineTo(x1, y1);
      }
      context.setLineDash(arc.blocked ? [2, 4] : arc.kind === "foray" ? [6, 4] : []);
      context.strokeStyle = shade(arc.blocked ? "blocked" : arc.kind === "foray" ? "foray" : "arc");
      context.lineWidth = 2.4;
      context.stroke();
      context.setLineDash([]);
      if (Math.hypot(x1 - x0, y1 - y0) > 90) this.lengths.push([`${Math.round(100 * arc.distance)} cm`, (x0 + x1) / 2, (y0 + y1) / 2]);
    }
  }

  drawLengths(context) {
    context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const [text, x, y] of this.lengths ?? []) {
      const wide = context.measureText(text).width / 2 + 3;
      context.fillStyle = shade("floor");
      context.globalAlpha = 0.85;
      context.fillRect(x - wide, y - 8, 2 * wide, 16);
      context.globalAlpha = 1;
      context.fillStyle = shade("ink");
      context.fillText(text, x, y);
    }
  }

  drawNodes(context) {
    const { app } = this;
    const belief = app.run.beliefAt(app.moment);
    const radius = this.radius();
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.font = `600 ${Math.round(radius * 1.1)}px system-ui, "DejaVu Sans", sans-serif`;
    for (const node of this.visibleNodes()) {
      const [x, y] = this.camera.toScreen(node.pose[0], node.pose[1]);
      const weight = belief[node.node] ?? 0;
      if (weight > 0.005) {
        context.beginPath();
        context.arc(x, y, radius + 24 * Math.sqrt(weight), 0, 7);
        context.fillStyle = shade("accent");
        context.globalAlpha = 0.3;
        context.fill();
        context.globalAlpha = 1;
      }
      const heading = node.pose[2];
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(x + 1.8 * radius * Math.cos(heading), y - 1.8 * radius * Math.sin(heading));
      context.strokeStyle = shade("node");
      context.lineWidth = 2;
      context.stroke();
      context.beginPath();
      if (node.corner === "convex") context.rect(x - radius, y - radius, 2 * radius, 2 * radius);
      else context.arc(x, y, radius, 0, 7);
      const chosen = node.node === app.node;
      context.fillStyle = chosen ? shade("accent") : shade("node");
      context.fill();
      context.lineWidth = chosen ? 3 : 1;
      context.strokeStyle = chosen ? shade("ink") : shade("floor");
      context.stroke();
      context.fillStyle = shade("back");
      context.fillText(String(node.node), x, y + 0.5);
    }
  }

  // --- the paths: what is new since the last picture is added to it

  drawTrail(width, height) {
    const { app, camera } = this;
    const key = [camera.key, app.theme, this.shown.true, this.shown.believed, app.run.hasTruth].join();
    const anew = key !== this.trailKey || app.moment < this.trailTo;
    const context = fitted(this.trail, width, height);
    if (anew) context.clearRect(0, 0, width, height);
    const from = anew ? -1 : this.trailTo;
    if (this.shown.true && app.run.hasTruth) this.drawPath(context, this.paths.true, from, () => shade("true"), 3.2, 0.55);
    if (this.shown.believed) this.drawPath(context, this.paths.believed, from, (d) => colorOf(app.run.names[d]), 1.5, 1);
    this.trailKey = key;
    this.trailTo = app.moment;
  }

  drawPath(context, path, from, colorAt, width, alpha) {
    const { run, moment } = this.app;
    path.extend(run.count);
    const [xs, ys] = [path.columns[0].data, path.columns[1].data];
    let index = Math.max(1, firstAfter(path.moments, from));
    context.lineWidth = width;
    context.globalAlpha = alpha;
    context.lineJoin = "round";
    let open = "";
    let previous = null;
    for (; index < path.moments.length && path.moments[index] <= moment; index++) {
      const [a, b] = [path.moments[index - 1], path.moments[index]];
      const color = colorAt(path.drivers ? path.drivers.data[a] : 0);
      const [x, y] = this.camera.toScreen(xs[b], ys[b]);
      if (color !== open) {
        if (open) context.stroke();
        open = context.strokeStyle = color;
        context.beginPath();
        previous = this.camera.toScreen(xs[a], ys[a]);
        context.moveTo(...previous);
      }
      context.lineTo(x, y);
    }
    if (open) context.stroke();
    context.globalAlpha = 1;
  }

  // --- the robot

  drawRobots(context) {
    const { run, moment } = this.app;
    if (run.hasTruth && this.shown.believed) this.drawGhost(context, run.poseAt(moment, run.believed));
    const [x, y, heading] = run.poseAt(moment);
    if (this.shown.rays) this.drawRays(context, x, y, heading);
    const [px, py] = this.camera.toScreen(x, y);
    const radius = Math.max(5, run.robot.radius * this.camera.scale);
    const color = colorOf(run.driverAt(moment));
    context.beginPath();
    context.arc(px, py, radius, 0, 7);
    context.fillStyle = shade("robot");
    context.fill();
    context.lineWidth = 3;
    context.strokeStyle = color;
    context.stroke();
    context.beginPath();
    for (const turn of [0, 2.5, -2.5]) {
      const length = turn ? 0.62 * radius : 0.85 * radius;
      context.lineTo(px + length * Math.cos(heading + turn), py - length * Math.sin(heading + turn));
    }
    context.closePath();
    context.fillStyle = color;
    context.fill();
  }

  drawGhost(context, [x, y, heading]) {
    const [px, py] = this.camera.toScreen(x, y);
    const radius = Math.max(5, this.app.run.robot.radius * this.camera.scale);
    context.beginPath();
    context.arc(px, py, radius, 0, 7);
    context.moveTo(px, py);
    context.lineTo(px + radius * Math.cos(heading), py - radius * Math.sin(heading));
    context.setLineDash([3, 3]);
    context.lineWidth = 1.5;
    context.strokeStyle = shade("ink");
    context.stroke();
    context.setLineDash([]);
  }

  drawRays(context, x, y, heading) {
    const { robot, infrared } = this.app.run;
    context.lineWidth = 1.3;
    robot.angles.forEach((angle, sensor) => {
      const value = infrared.data[8 * this.app.moment + sensor];
      const near = value < 255;
      const length = robot.radius + robot.range * (near ? value / 254 : 1);
      const [cos, sin] = [Math.cos(heading + angle), Math.sin(heading + angle)];
      const from = this.camera.toScreen(x + robot.radius * cos, y + robot.radius * sin);
      const to = this.camera.toScreen(x + length * cos, y + length * sin);
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.strokeStyle = near ? shade("ray") : shade("soft");
      context.globalAlpha = near ? 1 : 0.35;
      context.stroke();
      if (near) {
        context.beginPath();
        context.arc(to[0], to[1], 2.2, 0, 7);
        context.fillStyle = shade("ray");
        context.fill();
      }
    });
    context.globalAlpha = 1;
  }

  drawScale(context, width, height) {
    const wanted = 90 / this.camera.scale;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map((n) => n * power).find((n) => n <= wanted) ?? power;
    const pixels = length * this.camera.scale;
    const [x, y] = [width - pixels - 14, 18];
    context.strokeStyle = context.fillStyle = shade("ink");
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, y - 4);
    context.lineTo(x, y);
    context.lineTo(x + pixels, y);
    context.lineTo(x + pixels, y - 4);
    context.stroke();
    context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.textBaseline = "top";
    context.fillText(length >= 1 ? `${length} m` : `${Math.round(100 * length * 10) / 10} cm`, x + pixels / 2, y + 3);
  }
}

function firstAfter(sorted, value) {
  let low = 0;
  let high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
}

function mixed(one, other, share) {
  const parts = (color) => [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
  const [a, b] = [parts(one), parts(other)];
  return `rgb(${a.map((value, i) => Math.round(share * value + (1 - share) * b[i])).join(" ")})`;
}
