// Pictures of a node: its panorama, its self-organizing maps.

import { element, shade } from "./colors.js";

/** Draws luminances (height x width bytes) into a context at x, y, each pixel `scale` wide. */
function gray(context, pixels, offset, width, height, x, y, scale) {
  const image = new ImageData(width, height);
  for (let i = 0; i < width * height; i++) {
    image.data.fill(pixels[offset + i], 4 * i, 4 * i + 3);
    image.data[4 * i + 3] = 255;
  }
  const small = new OffscreenCanvas(width, height);
  small.getContext("2d").putImageData(image, 0, 0);
  context.imageSmoothingEnabled = false;
  context.drawImage(small, x, y, width * scale, height * scale);
}

const figure = (canvas, caption) => element("figure", {}, canvas, element("figcaption", { textContent: caption }));

/** The four views of a panorama side by side: left, ahead, right, behind. */
export function panorama(pixels, offset = 0, caption = "Views at the node: left, ahead, right, behind") {
  const scale = 4;
  const canvas = element("canvas", { width: 4 * 16 * scale + 6, height: 16 * scale });
  const context = canvas.getContext("2d");
  [1, 0, 3, 2].forEach((view, place) => gray(context, pixels, offset + 256 * view, 16, 16, place * (16 * scale + 2), 0, scale));
  return figure(canvas, caption);
}

/** The metric SOM in the node's own frame, its entry heading to the right. */
export function metric(local, chosen = -1) {
  const size = 220;
  const canvas = element("canvas", { width: 2 * size, height: 2 * size });
  canvas.style.width = canvas.style.height = `${size}px`;
  const context = canvas.getContext("2d");
  context.scale(2, 2);
  const { x, y, hits, edges, blocked } = local;
  const [x0, x1, y0, y1] = [Math.min(0, ...x), Math.max(0, ...x), Math.min(0, ...y), Math.max(0, ...y)];
  const scale = (size - 24) / Math.max(x1 - x0, y1 - y0, 0.01);
  const place = (px, py) => [size / 2 + (px - (x0 + x1) / 2) * scale, size / 2 - (py - (y0 + y1) / 2) * scale];
  const closed = new Set(blocked);
  for (const wanted of [false, true]) {
    context.beginPath();
    for (let i = 0; i < edges.length; i += 2)
      if (closed.has(i / 2) === wanted) {
        context.moveTo(...place(x[edges[i]], y[edges[i]]));
        context.lineTo(...place(x[edges[i + 1]], y[edges[i + 1]]));
      }
    context.strokeStyle = shade(wanted ? "blocked" : "lattice");
    context.lineWidth = wanted ? 2 : 1;
    context.stroke();
  }
  for (let unit = 0; unit < x.length; unit++) {
    context.beginPath();
    context.arc(...place(x[unit], y[unit]), hits[unit] ? 2.6 : 2, 0, 7);
    context.fillStyle = hits[unit] ? shade("lattice") : shade("panel");
    context.fill();
    context.lineWidth = 0.8;
    context.strokeStyle = shade("lattice");
    context.stroke();
  }
  if (chosen >= 0 && local.seen[chosen]) {
    context.beginPath();
    context.arc(...place(local.viewX[chosen], local.viewY[chosen]), 6, 0, 7);
    context.lineWidth = 2.5;
    context.strokeStyle = shade("blocked");
    context.stroke();
  }
  const [ox, oy] = place(0, 0);
  context.beginPath();
  context.moveTo(ox - 6, oy - 5);
  context.lineTo(ox + 8, oy);
  context.lineTo(ox - 6, oy + 5);
  context.closePath();
  context.fillStyle = shade("ink");
  context.fill();
  const bar = `${(100 * Math.max(x1 - x0, y1 - y0)).toFixed(0)} cm`;
  return figure(canvas, `Metric SOM, ${local.metric.join(" x ")} units over ${bar}; the arrow is the node and its entry heading`);
}

/** The perceptual SOM as a sheet: each unit shows its four views. `choose` is told the unit clicked on. */
export function perceptual(local, choose, chosen) {
  const [rows, cols, topology] = local.perceptual;
  const tile = Math.max(20, Math.min(36, Math.floor(320 / cols)));
  const pixel = (tile - 2) / 32;
  const shift = topology === "hexagonal" ? tile / 2 : 0;
  const ratio = 2;
  const [width, height] = [cols * tile + shift, rows * tile];
  const canvas = element("canvas", { width: width * ratio, height: height * ratio, tabIndex: 0 });
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  canvas.style.cursor = "pointer";
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  for (let unit = 0; unit < rows * cols; unit++) {
    const row = Math.floor(unit / cols);
    const [x, y] = [(unit % cols) * tile + (row % 2 ? shift : 0), row * tile];
    [1, 0, 3, 2].forEach((view, place) =>
      gray(context, local.views, 1024 * unit + 256 * view, 16, 16, x + (place % 2) * 16 * pixel, y + (place >> 1) * 16 * pixel, pixel));
    if (unit === chosen) {
      context.strokeStyle = shade("blocked");
      context.lineWidth = 2;
      context.strokeRect(x, y, tile - 2, tile - 2);
    }
  }
  canvas.addEventListener("click", (event) => {
    const row = Math.floor(event.offsetY / tile);
    const col = Math.floor((event.offsetX - (row % 2 ? shift : 0)) / tile);
    if (row >= 0 && row < rows && col >= 0 && col < cols) choose(row * cols + col);
  });
  canvas.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -cols, ArrowDown: cols }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    choose(Math.max(0, Math.min(rows * cols - 1, Math.max(0, chosen) + by)));
  });
  return figure(canvas, `Perceptual SOM, ${rows} x ${cols} units: left, ahead over right, behind. Click one to see it large`);
}

/** A camera image of the run. */
export function drawImage(canvas, { width, height, tones, pixels }) {
  canvas.width = width;
  canvas.height = height;
  canvas.style.width = `${Math.max(128, Math.min(320, width))}px`;
  const image = new ImageData(width, height);
  for (let i = 0; i < width * height; i++) {
    for (let tone = 0; tone < 3; tone++) image.data[4 * i + tone] = pixels[tones * i + (tones === 3 ? tone : 0)];
    image.data[4 * i + 3] = 255;
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
}
