import { colorOf, fitted, ROWS, shade } from "./colors.js";

const SHOWN = ["control", "fault", "node", "closure", "mission"];

/** The whole run from left to right: who drove, and the events as ticks; with the slider over it. */
export class Timeline {
  constructor(app) {
    this.app = app;
    this.canvas = document.getElementById("ticks");
    this.slider = document.getElementById("slider");
    this.picture = document.createElement("canvas");
    this.slider.addEventListener("input", () => app.seek(Number(this.slider.value)));
    this.slider.addEventListener("keydown", (event) => event.preventDefault());
  }
  draw() {
    const { app, canvas } = this;
    const { run } = app;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    this.slider.min = run.begin;
    this.slider.max = run.end;
    this.slider.value = app.time;
    this.slider.setAttribute("aria-valuetext", `${app.time.toFixed(2)} s of ${run.end.toFixed(2)} s`);
    const key = [width, height, run.count, run.events.length, app.theme].join();
    if (key !== this.key) this.paint(width, height);
    this.key = key;
    const context = fitted(canvas);
    context.clearRect(0, 0, width, height);
    context.drawImage(this.picture, 0, 0, width, height);
    const x = this.place(app.time, width);
    context.fillStyle = shade("ink");
    context.fillRect(x - 1, 0, 2, height);
    context.beginPath();
    context.moveTo(x - 6, 0);
    context.lineTo(x + 6, 0);
    context.lineTo(x, 7);
    context.fill();
  }
  place(time, width) {
    const { begin, end } = this.app.run;
    return 6 + ((time - begin) / Math.max(1e-9, end - begin)) * (width - 12);
  }
  paint(width, height) {
    const { run } = this.app;
    const context = fitted(this.picture, width, height);
    context.clearRect(0, 0, width, height);
    const scale = 14;
    const band = 9;
    this.paintDrivers(context, width, band);
    const rows = SHOWN.filter((row) => run.rows.get(row)?.length);
    const high = (height - band - scale - 2) / Math.max(1, rows.length);
    rows.forEach((row, index) => {
      context.fillStyle = ROWS[row].color;
      const wide = row === "control" ? 1 : 2.5;
      context.globalAlpha = row === "control" ? 0.55 : 1;
      for (const at of run.rows.get(row)) context.fillRect(this.place(run.time(at), width) - wide / 2, band + 2 + index * high, wide, high - 2);
    });
    context.globalAlpha = 1;
    this.paintScale(context, width, height);
  }
  paintDrivers(context, width, band) {
    const { run } = this.app;
    for (let px = 6; px < width - 6; px++) {
      const moment = run.momentAt(run.begin + ((px - 6) / (width - 12)) * (run.end - run.begin));
      const driver = run.driverAt(moment);
      if (!driver) continue;
      context.fillStyle = colorOf(driver);
      context.fillRect(px, 0, 1, band);
    }
  }
  paintScale(context, width, height) {
    const { run } = this.app;
    const span = Math.max(1e-9, run.end - run.begin);
    const wanted = (span * 90) / width;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= wanted);
    context.fillStyle = shade("soft");
    context.font = "10px system-ui, 'DejaVu Sans', sans-serif";
    context.textBaseline = "bottom";
    for (let time = Math.ceil(run.begin / step) * step; time <= run.end; time += step) {
      const x = this.place(time, width);
      context.fillRect(x, height - 14, 1, 3);
      context.textAlign = x < 20 ? "left" : x > width - 30 ? "right" : "center";
      context.fillText(`${Number(time.toFixed(3))} s`, x, height);
    }
  }
}
