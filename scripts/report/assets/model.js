// The run as the page knows it. Times are s, lengths m, angles rad; a moment is an index of a tick.

/** Numbers that grow at their end. */
class Column {
  constructor(Type) {
    this.data = new Type(1024);
    this.length = 0;
  }
  append(values) {
    const needed = this.length + values.length;
    if (needed > this.data.length) {
      const larger = new this.data.constructor(Math.max(needed, 2 * this.data.length));
      larger.set(this.data.subarray(0, this.length));
      this.data = larger;
    }
    this.data.set(values, this.length);
    this.length = needed;
  }
  fill(length) {
    if (length > this.length) this.append(new this.data.constructor(length - this.length));
  }
}

/** What changes seldom: `at` the moments, `value` what holds from then on. */
class Changes {
  constructor() {
    this.at = [];
    this.value = [];
  }
  append([at, value]) {
    for (let i = 0; i < at.length; i++) {
      this.at.push(at[i]);
      this.value.push(value[i]);
    }
  }
  get(moment) {
    const place = upper(this.at, moment) - 1;
    return place < 0 ? undefined : this.value[place];
  }
}

/** How many of the sorted numbers are at most `value`. */
export function upper(sorted, value, length = sorted.length) {
  let low = 0;
  let high = length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
}

const pose = () => [new Column(Float64Array), new Column(Float64Array), new Column(Float64Array)];

export class Run {
  constructor(content) {
    this.about = content.about;
    this.walls = content.walls;
    this.robot = content.robot;
    this.track = content.track ?? [];
    this.behaviors = new Map(content.behaviors.map((each) => [each.name, each]));
    this.count = 0;
    this.numbers = new Column(Float64Array);
    this.true = pose();
    this.believed = pose();
    this.hasTruth = false;
    this.infrared = new Column(Uint8Array);
    this.driver = new Column(Uint8Array);
    this.left = new Column(Float64Array);
    this.right = new Column(Float64Array);
    this.names = [""];
    this.texts = [];
    this.activations = new Map();
    this.reasons = new Map();
    this.states = new Map();
    this.events = [];
    this.rows = new Map();
    this.beliefs = [];
    this.beliefsAt = [];
    this.images = [];
    this.imagesAt = [];
    this.nodes = new Map();
    this.arcs = [];
    this.version = 0;
    this.fixed = content.map.nodes.length > 0 && !content.about.live;
    this.grown = Boolean(content.about.grown);
    this.places = content.places ?? {};
    const first = this.grown && !content.about.live ? Infinity : -1;
    for (const node of content.map.nodes) this.putNode(node, first);
    for (const arc of content.map.arcs) this.putArc(arc, first);
    if (content.ticks) this.append(content.ticks);
  }

  // --- what comes in

  append(chunk) {
    const before = this.count;
    this.names.push(...chunk.names);
    this.texts.push(...chunk.texts);
    this.numbers.append(chunk.numbers);
    this.count += chunk.count;
    this.hasTruth = chunk.true !== null && this.true[0].length === before;
    for (let i = 0; i < 3; i++) {
      if (this.hasTruth) this.true[i].append(chunk.true[i]);
      this.believed[i].append(chunk.believed[i]);
    }
    for (const name of ["infrared", "driver", "left", "right"]) this[name].append(chunk[name]);
    for (const [name, levels] of Object.entries(chunk.activations)) {
      const column = this.of(this.activations, name, () => new Column(Uint8Array));
      column.fill(before);
      column.append(levels);
    }
    for (const column of this.activations.values()) column.fill(this.count);
    for (const table of ["reasons", "states"])
      for (const [name, changes] of Object.entries(chunk[table]))
        this.of(this[table], name, () => new Changes()).append(changes);
    for (const [at, row, kind, text, facts] of chunk.events) this.hear({ at, row, kind, text, facts });
    for (const [at, weights] of chunk.beliefs) {
      this.beliefsAt.push(at);
      this.beliefs.push(weights);
    }
    for (const [at, height, width, tones, pixels] of chunk.images) {
      this.imagesAt.push(at);
      this.images.push({ height, width, tones, pixels });
    }
  }

  of(map, key, make) {
    if (!map.has(key)) map.set(key, make());
    return map.get(key);
  }

  hear(event) {
    const row = this.of(this.rows, event.row, () => []);
    row.push(event.at);
    this.events.push(event);
    if (this.grown) this.grow(event);
  }

  /** Nodes and arcs come into being when the run says so; a run without a map knows no more than that. */
  grow({ at, kind, facts }) {
    if (kind === "NodeCreated") {
      if (!this.nodes.has(facts.node)) {
        if (this.fixed) return;
        this.putNode({ node: facts.node, name: `n${facts.node}`, corner: facts.corner, pose: null, local: null }, at);
      }
      const node = this.nodes.get(facts.node);
      node.at = Math.min(node.at, at);
      node.pose ??= this.places[facts.node] ?? this.poseAt(at);
    } else if (kind === "ArcAdded") {
      let found = false;
      for (const arc of this.arcs)
        if (joins(arc, facts.source, facts.target)) {
          arc.at = Math.min(arc.at, at);
          found = true;
        }
      if (!found && !this.fixed) {
        const other = facts.side === "left" ? "right" : "left";
        this.putArc([facts.source, facts.target, facts.side, facts.distance, 0, 1, false], at);
        this.putArc([facts.target, facts.source, other, facts.distance, 0, 1, false], at);
      }
    } else if (kind === "LocalMapBuilt" && this.nodes.has(facts.node)) {
      this.nodes.get(facts.node).localAt = at;
    } else return;
    this.version++;
  }

  putNode(content, at) {
    const before = this.nodes.get(content.node);
    const localAt = before?.localAt ?? at;
    this.nodes.set(content.node, { ...content, at: before?.at ?? at, localAt });
    this.version++;
  }

  putArc([start, end, kind, distance, variance, traversals, blocked], at) {
    const before = this.arcs.findIndex((a) => a.start === start && a.end === end && a.kind === kind);
    const arc = { start, end, kind, distance, variance, traversals, blocked, at };
    if (before < 0) this.arcs.push(arc);
    else this.arcs[before] = { ...arc, at: this.arcs[before].at };
    this.version++;
  }

  // --- what is asked

  time(moment) {
    return moment < this.count ? this.numbers.data[moment] * this.about.period : 0;
  }
  get begin() {
    return this.time(0);
  }
  get end() {
    return this.count ? this.time(this.count - 1) : 0;
  }
  /** The moment in force at a time. */
  momentAt(time) {
    const number = time / this.about.period + 1e-6;
    return Math.max(0, upper(this.numbers.data, number, this.count) - 1);
  }
  poseAt(moment, which = this.hasTruth ? this.true : this.believed) {
    return which.map((column) => column.data[moment]);
  }
  driverAt(moment) {
    return this.names[this.driver.data[moment]] ?? "";
  }
  activation(name, moment) {
    return (this.activations.get(name)?.data[moment] ?? 0) / 255;
  }
  reasonAt(name, moment) {
    return this.texts[this.reasons.get(name)?.get(moment)] ?? "";
  }
  /** The state of a behavior, `parent/child` for one that another drives by; "" while it is not active. */
  stateAt(path, moment) {
    const text = this.states.get(path)?.get(moment);
    if (text !== undefined) return text < 0 ? "" : this.texts[text];
    const [name] = path.split("/");
    const said = this.activation(name, moment) ? this.reasonAt(name, moment).toUpperCase().replaceAll(" ", "_") : "";
    return this.behaviors.get(path)?.states.includes(said) ? said : "";
  }
  beliefAt(moment) {
    const place = upper(this.beliefsAt, moment) - 1;
    return place < 0 ? {} : this.beliefs[place];
  }
  imageAt(moment) {
    const place = upper(this.imagesAt, moment) - 1;
    return place < 0 ? null : { ...this.images[place], at: this.imagesAt[place] };
  }
  /** The moment of the next event in a row, the one before if `back`; undefined if there is none. */
  jump(row, moment, back) {
    const at = this.rows.get(row) ?? [];
    if (back) return at[upper(at, moment - 1) - 1];
    return at[upper(at, moment)];
  }
  /** The last event of a class at or before a moment. */
  last(kind, moment) {
    for (let i = upper(this.eventTimes(), moment) - 1; i >= 0; i--)
      if (this.events[i].kind === kind) return this.events[i];
    return undefined;
  }
  eventTimes() {
    if (this.times?.length !== this.events.length) this.times = this.events.map((event) => event.at);
    return this.times;
  }
  bounds() {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    const take = (x, y, margin = 0) => {
      box[0] = Math.min(box[0], x - margin);
      box[1] = Math.min(box[1], y - margin);
      box[2] = Math.max(box[2], x + margin);
      box[3] = Math.max(box[3], y + margin);
    };
    for (const outline of this.walls) for (const [x, y] of outline) take(x, y);
    for (const node of this.nodes.values()) if (node.pose) take(node.pose[0], node.pose[1], 0.1);
    if (!this.walls.length)
      for (let i = 0; i < this.count; i += 20) take(this.believed[0].data[i], this.believed[1].data[i], 0.1);
    return box[0] < box[2] ? box : [-1, -1, 1, 1];
  }
}

const joins = (arc, a, b) => (arc.start === a && arc.end === b) || (arc.start === b && arc.end === a);
