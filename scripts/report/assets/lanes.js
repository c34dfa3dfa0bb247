import { colorOf, element, fitted, shade } from "./colors.js";

const SPANS = [4, 10, 30, 120, 600];

/** A lane for each behavior: when it proposed, when it won, and what for. */
export class Lanes {
  constructor(app) {
    this.app = app;
    this.box = document.getElementById("rows");
    this.span = 30;
    this.rows = new Map();
    const select = element("select", { ariaLabel: "Seconds shown" });
    for (const span of SPANS) select.append(element("option", { value: span, textContent: `${span} s` }));
    select.value = String(this.span);
    select.addEventListener("change", () => {
      this.span = Number(select.value);
      app.redraw();
    });
    document.getElementById("spans").append(select);
  }

  /** The behaviors with a say in this run, the strongest first. */
  names() {
    const { run } = this.app;
    const names = [...run.activations.keys()];
    const priority = (name) => run.behaviors.get(name)?.priority ?? 0;
    return names.sort((a, b) => priority(b) - priority(a) || (a < b ? -1 : 1));
  }

  rowOf(name) {
    if (this.rows.has(name)) return this.rows.get(name);
    const swatch = element("i", { className: "swatch" });
    swatch.style.background = colorOf(name);
    const button = element("button", { title: `${name}: what it is, its settings` }, swatch, name);
    button.addEventListener("click", () => this.app.showBehavior(name));
    const strip = element("canvas", { title: "shaded: it wanted to drive; full: it drove" });
    strip.addEventListener("click", (event) => {
      const share = event.offsetX / strip.clientWidth - 0.5;
      this.app.seek(this.app.time + share * this.span);
    });
    const said = element("div", { className: "said" });
    const row = { element: element("div", { className: "row" }, button, strip, said), strip, said, name };
    this.rows.set(name, row);
    return row;
  }

  draw() {
    const names = this.names();
    if (names.length !== this.box.childElementCount)
      this.box.replaceChildren(...names.map((name) => this.rowOf(name).element));
    for (const name of names) this.drawRow(this.rowOf(name));
  }

  drawRow({ element: box, strip, said, name }) {
    const { run, moment } = this.app;
    const won = run.driverAt(moment) === name;
    const active = run.activation(name, moment);
    const state = run.stateAt(name, moment).toLowerCase().replaceAll("_", " ");
    const reason = active ? run.reasonAt(name, moment) : "";
    box.classList.toggle("won", won);
    const words = [state, reason === state ? "" : reason].filter(Boolean).join(": ");
    said.textContent = active ? `${words}${active < 0.995 ? ` (${active.toFixed(2)})` : ""}` : state ? `${state}, no say` : "";
    said.title = said.textContent;
    this.drawStrip(strip, name);
  }

  drawStrip(strip, name) {
    const { run, time } = this.app;
    const context = fitted(strip);
    const [width, height] = [strip.clientWidth, strip.clientHeight];
    context.fillStyle = shade("unwanted");
    context.fillRect(0, 0, width, height);
    const levels = run.activations.get(name).data;
    const number = run.names.indexOf(name);
    const color = colorOf(name);
    context.fillStyle = color;
    const step = 1; // pixels
    let last = run.momentAt(time - this.span / 2);
    for (let px = 0; px < width; px += step) {
      const at = time + ((px + step) / width - 0.5) * this.span;
      if (at < run.begin) continue;
      if (at > run.end + this.span / width) break;
      const next = run.momentAt(at);
      let wanted = 0;
      let won = false;
      const stride = Math.max(1, (next - last) >> 3);
      for (let i = last; i <= next; i += stride) {
        wanted = Math.max(wanted, levels[i]);
        won ||= run.driver.data[i] === number && levels[i] > 0;
      }
      if (won) {
        context.globalAlpha = 1;
        context.fillRect(px, 0, step, height);
      } else if (wanted) {
        context.globalAlpha = 0.45;
        const high = 3 + (height - 8) * (wanted / 255);
        context.fillRect(px, height - high, step, high);
      }
      last = next;
    }
    context.globalAlpha = 1;
    context.fillStyle = shade("ink");
    context.fillRect(width / 2 - 0.5, 0, 1, height);
  }
}
