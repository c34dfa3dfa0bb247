// Which part of the world is seen: its center (m) and scale (pixels a meter).

export class Camera {
  constructor(bounds) {
    this.bounds = bounds;
    this.width = this.height = 1;
    this.x = this.y = 0;
    this.scale = 100;
    this.fit();
  }
  resize(width, height) {
    if (width === this.width && height === this.height) return;
    [this.width, this.height] = [width, height];
    if (this.whole) this.fit();
  }
  fit() {
    const [x0, y0, x1, y1] = this.bounds;
    this.x = (x0 + x1) / 2;
    this.y = (y0 + y1) / 2;
    this.scale = Math.min((this.width - 24) / (x1 - x0), (this.height - 84) / (y1 - y0));
    this.scale = Math.max(5, this.scale);
    this.whole = true;
  }
  /** Zooms so that the world stays where it is under a place on the screen. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toWorld(px, py);
    this.scale = Math.min(20000, Math.max(5, this.scale * factor));
    const [nx, ny] = this.toWorld(px, py);
    this.x += x - nx;
    this.y += y - ny;
    this.whole = false;
  }
  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.whole = false;
  }
  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }
  toWorld(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }
  get key() {
    return `${this.x} ${this.y} ${this.scale} ${this.width} ${this.height}`;
  }
}
