import { readTheme } from "./colors.js";
import { Lanes } from "./lanes.js";
import { listen } from "./live.js";
import { Machine } from "./machine.js";
import { Run } from "./model.js";
import { Belief, CameraImage, Detail, Events, Now, Settings } from "./panels.js";
import { Player } from "./player.js";
import { Timeline } from "./timeline.js";
import { fromBase64, unpack, unzip } from "./unpack.js";
import { World } from "./world.js";

/** What the page shows now, and who draws it. */
class App {
  constructor(content, live) {
    this.live = live;
    this.run = new Run(content);
    this.time = this.run.begin;
    this.moment = 0;
    this.node = undefined;
    this.behavior = "";
    this.theme = document.documentElement.dataset.theme;
    this.world = new World(this);
    this.player = new Player(this);
    this.still = !this.run.count && !live;
    document.body.classList.toggle("still", this.still);
    const parts = [this.world, new Detail(this), new Settings(this)];
    if (!this.still)
      parts.push(new Now(this), new Lanes(this), new Machine(this), new Belief(this), new CameraImage(this), new Events(this),
        new Timeline(this), this.player);
    this.parts = parts;
    this.latest = document.getElementById("latest");
    this.atEnd = live;
    this.latest.addEventListener("click", () => {
      this.atEnd = true;
      this.move(this.run.end);
    });
    this.tell(content.about);
    new ResizeObserver(() => this.redraw()).observe(document.getElementById("plan"));
    this.player.fromAddress();
  }

  tell({ title, kind, facts, complete, placed }) {
    document.getElementById("title").textContent = title;
    const words = Object.entries(facts).map(([name, value]) => `${name} ${value}`);
    if (complete === false) words.push("cut off");
    if (placed === "map" && !this.live) words.push("laid out by the map's own arcs");
    document.getElementById("facts").textContent = [kind, ...words].join(" \u00b7 ");
  }

  /** Goes to a time by the user's wish: what is live is followed no more, and the address says it. */
  seek(time) {
    this.atEnd = false;
    this.move(time);
    this.player.toAddress();
  }
  move(time) {
    this.time = Math.max(this.run.begin, Math.min(this.run.end, time));
    this.moment = this.run.momentAt(this.time);
    this.redraw();
  }
  select(node) {
    this.node = this.run.nodes.has(node) ? node : undefined;
    const chosen = this.run.nodes.get(this.node);
    if (chosen && chosen.at > this.moment && chosen.at < this.run.count) this.move(this.run.time(chosen.at));
    this.player.toAddress();
    this.redraw();
  }
  step(by) {
    const there = [...this.run.nodes.values()].filter((node) => node.at <= this.moment).map((node) => node.node);
    there.sort((a, b) => a - b);
    if (there.length) this.select(there[(there.indexOf(this.node) + by + there.length) % there.length] ?? there[0]);
  }
  showBehavior(name) {
    this.behavior = name;
    this.redraw();
  }

  // --- a run that is under way

  take(chunk) {
    const first = this.run.count === 0;
    this.run.append(chunk);
    if (first) this.world.fit();
    if (this.atEnd) this.move(this.run.end);
    else this.redraw();
    this.latest.hidden = this.atEnd;
  }
  takeMap({ nodes, arcs }) {
    for (const node of nodes) this.run.putNode(node, this.run.count);
    for (const arc of arcs) this.run.putArc(arc, this.run.count);
    this.redraw();
  }
  ended() {
    this.live = false;
    this.latest.hidden = true;
  }

  /** Draws once before the next frame, however often it is asked. */
  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      if (this.atEnd && this.latest) this.latest.hidden = true;
      for (const part of this.parts) part.draw();
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
    });
  }
}

function stored(value) {
  try {
    if (value !== undefined) localStorage.setItem("tolman-theme", value);
    return localStorage.getItem("tolman-theme");
  } catch {
    return null; // a page opened from a file may have no storage
  }
}

function useTheme(name) {
  document.documentElement.dataset.theme = name;
  document.getElementById("theme").textContent = name === "dark" ? "Light" : "Dark";
  readTheme();
}

async function open() {
  const asked = /(?:^#|&)theme=(light|dark)/.exec(location.hash)?.[1];
  const wanted = asked ?? stored() ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  useTheme(wanted);
  const keys = document.getElementById("keys");
  const help = document.getElementById("help");
  help.addEventListener("click", () => {
    keys.hidden = !keys.hidden;
    help.setAttribute("aria-expanded", String(!keys.hidden));
  });
  let app;
  document.getElementById("theme").addEventListener("click", () => {
    const other = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    stored(other);
    useTheme(other);
    if (app) {
      app.theme = other;
      app.redraw();
    }
  });
  const { mode } = JSON.parse(document.getElementById("page-settings").textContent);
  if (mode === "live") listen(() => app, (content) => (app = window.tolman = new App(content, true)));
  else {
    const data = document.getElementById("page-data").textContent.trim();
    app = window.tolman = new App(unpack(await unzip(fromBase64(data))), false);
  }
  document.body.dataset.ready = "yes";
}

open();
