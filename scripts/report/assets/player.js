import { element, ROWS } from "./colors.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
const JUMPS = ["control", "fault", "node", "closure"];

/** Plays, jumps, and listens to the keyboard and to the address. */
export class Player {
  constructor(app) {
    this.app = app;
    this.playing = false;
    this.frames = 0;
    this.button = document.getElementById("play");
    this.button.addEventListener("click", () => this.toggle());
    this.speed = document.getElementById("speed");
    for (const speed of SPEEDS) this.speed.append(element("option", { value: speed, textContent: `${speed}\u00d7` }));
    this.speed.value = app.run.end > 600 ? "10" : "1";
    this.jumps();
    document.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("hashchange", () => this.fromAddress());
    this.clock = document.getElementById("clock");
  }

  jumps() {
    const box = document.getElementById("jumps");
    this.jumpers = [];
    for (const row of JUMPS) {
      const dot = element("i");
      dot.style.background = ROWS[row].color;
      const back = element("button", { textContent: "\u2039", ariaLabel: `${row} before`, onclick: () => this.jump(row, true) });
      const next = element("button", { ariaLabel: `next ${row}`, onclick: () => this.jump(row, false) }, dot, `${ROWS[row].label} \u203a`);
      box.append(element("span", { className: "jump" }, back, next));
      this.jumpers.push([row, back, next]);
    }
  }

  jump(row, back) {
    const { run, moment } = this.app;
    const at = run.jump(row, moment, back);
    if (at !== undefined) this.app.seek(run.time(at));
  }

  toggle(on = !this.playing) {
    const { run } = this.app;
    if (on && this.app.time >= run.end && !this.app.live) this.app.seek(run.begin);
    this.playing = on && run.count > 0;
    this.button.innerHTML = this.playing ? "&#10074;&#10074;" : "&#9654;";
    this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.last = performance.now();
    cancelAnimationFrame(this.waited);
    if (this.playing) this.waited = requestAnimationFrame((now) => this.frame(now));
    else this.toAddress();
  }

  frame(now) {
    if (!this.playing) return;
    const passed = Math.max(0, Math.min(0.25, (now - this.last) / 1000));
    this.last = now;
    this.frames++;
    const { app } = this;
    const time = app.time + passed * Number(this.speed.value);
    if (time >= app.run.end && !app.live) {
      app.move(app.run.end);
      return this.toggle(false);
    }
    app.move(Math.min(time, app.run.end));
    this.waited = requestAnimationFrame((next) => this.frame(next));
  }

  draw() {
    const { run, time, moment } = this.app;
    this.clock.textContent = `${time.toFixed(2)} of ${run.end.toFixed(2)} s`;
    for (const [row, back, next] of this.jumpers) {
      back.disabled = run.jump(row, moment, true) === undefined;
      next.disabled = run.jump(row, moment, false) === undefined;
    }
  }

  // --- the address: #t=12.3

  fromAddress() {
    const found = /(?:^#|&)t=([\d.]+)/.exec(location.hash);
    const node = /(?:^#|&)node=(\d+)/.exec(location.hash);
    if (node) this.app.node = Number(node[1]);
    this.app.move(found ? Number(found[1]) : this.app.time);
  }
  toAddress() {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => {
      const node = this.app.node === undefined ? "" : `&node=${this.app.node}`;
      history.replaceState(null, "", `#t=${this.app.time.toFixed(2)}${node}`);
    }, 150);
  }

  // --- the keyboard

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const on = event.target;
    if (on.tagName === "SELECT" || (on.tagName === "INPUT" && on.type === "checkbox")) return;
    if (event.key === " " && on.tagName === "BUTTON") return;
    const act = this.keys(event)[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act();
    this.app.redraw();
  }

  keys({ shiftKey }) {
    const { app } = this;
    const { run, world } = app;
    const by = (ticks, seconds) => () =>
      app.seek(shiftKey ? app.time + seconds : run.time(Math.max(0, Math.min(run.count - 1, app.moment + ticks))));
    const row = (name) => () => this.jump(name, shiftKey);
    const speed = (step) => () => {
      this.speed.selectedIndex = Math.max(0, Math.min(SPEEDS.length - 1, this.speed.selectedIndex + step));
    };
    return {
      " ": () => this.toggle(),
      ArrowLeft: by(-1, -1),
      ArrowRight: by(1, 1),
      Home: () => app.seek(run.begin),
      End: () => app.seek(run.end),
      c: row("control"),
      f: row("fault"),
      n: row("node"),
      l: row("closure"),
      "<": speed(-1),
      ">": speed(1),
      "+": () => world.camera.zoom(1.3),
      "=": () => world.camera.zoom(1.3),
      "-": () => world.camera.zoom(1 / 1.3),
      0: () => world.fit(),
      w: () => world.camera.pan(0, 60),
      s: () => world.camera.pan(0, -60),
      a: () => world.camera.pan(60, 0),
      d: () => world.camera.pan(-60, 0),
      g: () => world.follow(!world.following),
      "[": () => app.step(-1),
      "]": () => app.step(1),
    };
  }
}
