// One robot's run: a header, and rows of numbers that may grow. Packed by nao_hil/view/rows.py.
"use strict";

const NAN_INTEGER = -(2 ** 31);
const MAX_PRINTS = 32; // footprints drawn
const MAX_ROWS = 14000; // rows kept of a live run: seven minutes
const $ = (id) => document.getElementById(id);

async function unpack(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let offset = 4 + length;
  const tables = {};
  for (const { name, rows, columns, step } of header.tables) {
    const whole = new Int32Array(buffer.slice(offset, offset + 4 * rows * columns));
    const numbers = new Float32Array(rows * columns); // row by row
    for (let column = 0; column < columns; column++)
      for (let row = 0, sum = 0; row < rows; row++) {
        sum = (sum + whole[column * rows + row]) | 0;
        numbers[row * columns + column] = sum === NAN_INTEGER ? NaN : sum * step;
      }
    tables[name] = { rows, columns, at: (row, column) => numbers[row * columns + column], row: (i) => numbers.subarray(i * columns, (i + 1) * columns) };
    offset += 4 * rows * columns;
  }
  return new Run(header, tables);
}

class Run {
  constructor(header, tables) {
    this.header = header;
    this.shapes = { vertices: tables.vertices, faces: tables.faces };
    this.fields = {};
    this.width = 0;
    for (const [name, size] of header.fields) {
      this.fields[name] = [this.width, size];
      this.width += size;
    }
    this.signal = Object.fromEntries(header.signals.map(([name], i) => [name, this.fields.signals[0] + i]));
    this.count = 0;
    this.rows = new Float32Array(this.width * (tables.time.rows + 512));
    for (const [name, [at, size]] of Object.entries(this.fields))
      for (let i = 0; i < tables.time.rows; i++) this.rows.set(tables[name].row(i).subarray(0, size), i * this.width + at);
    this.count = tables.time.rows;
    [this.links, this.chain] = [header.bodies[0].links, header.bodies[0].chain];
    this.prints = [];
    for (let i = 0; i < tables.footprints.rows; i++) this.print(Array.from(tables.footprints.row(i)));
  }

  append(row) {
    const { width } = this;
    if (this.count > MAX_ROWS) {
      const oldest = MAX_ROWS >> 2;
      this.rows.copyWithin(0, width * oldest, width * this.count);
      this.count -= oldest;
    }
    if ((this.count + 1) * width > this.rows.length) {
      const larger = new Float32Array(2 * this.rows.length);
      larger.set(this.rows);
      this.rows = larger;
    }
    this.rows.set(row, this.count * width);
    this.count += 1;
  }

  print([when, kind, ...numbers]) {
    this.prints.push({ when, kind: this.header.prints[kind], corners: triples(numbers) });
  }

  time(i) {
    return this.rows[i * this.width];
  }

  get first() {
    return this.count ? this.time(0) : 0;
  }

  get last() {
    return this.count ? this.time(this.count - 1) : 0;
  }

  // Number of the newest row up to a time.
  row(t) {
    let [low, high] = [0, Math.max(this.count - 1, 0)];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time(middle) <= t + 1e-4) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  get(i, name) {
    const [at, size] = this.fields[name], start = i * this.width + at;
    return this.rows.subarray(start, start + size);
  }

  value(i, column) {
    return this.rows[i * this.width + column];
  }

  // The number of a field of one column.
  number(i, name) {
    return this.value(i, this.fields[name][0]);
  }

  phase(i) {
    return this.header.phases[this.number(i, "phase")];
  }

  // The league's game in words; empty: there is none.
  game(i) {
    const [state, own, other, left, ...penalties] = this.get(i, "game"), { header } = this, { states, penalties: words } = header.game;
    if (Number.isNaN(state)) return "";
    const names = [header.name || "penalty", ...header.others.map(({ name }) => name)], clock = Math.abs(left);
    const penalized = penalties.map((n, robot) => (n > 0 ? `${names[robot]}: ${words[n]}` : "")).filter(Boolean);
    const time = `${left < 0 ? "-" : ""}${Math.floor(clock / 60)}:${String(clock % 60).padStart(2, "0")}`;
    return [states[state], `${own} : ${other}`, time, ...penalized].join(" · ");
  }

  // Everything that is drawn of a time, between two rows.
  moment(t) {
    const i = this.row(t), k = Math.min(i + 1, this.count - 1);
    const gap = this.time(k) - this.time(i), share = gap > 0 && gap < 0.5 ? Math.min(Math.max((t - this.time(i)) / gap, 0), 1) : 0;
    const between = (name) => {
      const a = this.get(i, name), b = this.get(k, name);
      return Array.from(a, (x, n) => (Number.isNaN(b[n]) ? x : x + share * (b[n] - x)));
    };
    const { header } = this, position = between("position"), points = between("points"), torso = 3 * this.links.indexOf("Torso");
    return {
      row: i,
      others: header.others.map((other, n) => this.other(i, k, share, other, n)).filter(Boolean),
      objects: header.objects.filter((object) => object.moves).map((_, n) => this.pose(i, k, share, "objects", n, 7)),
      position,
      torso: position.slice(torso, torso + 3),
      attitude: between("attitude"),
      heading: this.number(i, "heading"),
      points: Object.fromEntries(header.points.map(({ name }, n) => [name, points.slice(3 * n, 3 * n + 3)])),
      loads: between("loads"),
      lights: this.get(i, "lights"),
      support: { tips: this.number(i, "tips") > 0.5, corners: triples(this.get(i, "support")) },
      footprints: this.prints.filter((print) => print.when <= t + 1e-3).slice(-MAX_PRINTS),
      step: this.number(i, "step"),
      phase: this.phase(i)?.name,
      game: this.game(i),
    };
  }

  // Position and attitude of the links as encoders and inertial unit have them, the torso at its true place.
  estimate(moment) {
    const radians = (name) => this.value(moment.row, this.signal[name]) * (Math.PI / 180);
    const yaw = moment.heading, roll = radians("torso roll"), pitch = radians("torso pitch");
    const turn = [[[0, 0, 1], yaw], [[0, 1, 0], pitch], [[1, 0, 0], roll]].map(([axis, angle]) => about(axis, angle)).reduce(times);
    return placed(this, moment.torso, turn, ({ joint }) => radians(`angle ${joint}`));
  }

  // Number n of the poses in a field, between two rows, and the numbers after it; null: it is not known.
  pose(i, k, share, name, n, width) {
    const [a, b] = [i, k].map((row) => this.get(row, name).subarray(n * width, (n + 1) * width));
    if (Number.isNaN(a[0])) return null;
    const flip = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1 : 1; // of two quaternions of an attitude the nearer one
    const pose = Array.from(a, (x, m) => (Number.isNaN(b[m]) ? x : x + share * ((m > 2 && m < 7 ? flip : 1) * b[m] - x)));
    const turn = pose.slice(3, 7), length = Math.hypot(...turn);
    return { position: pose.slice(0, 3), attitude: turn.map((x) => x / length), rest: pose.slice(7) };
  }

  // Another robot of the world between two rows; null: it is not known where it is.
  other(i, k, share, { name, body }, n) {
    const pose = this.pose(i, k, share, "others", n, this.fields.others[1] / this.header.others.length);
    return pose && { name, body, torso: pose.position, ...placed(this.header.bodies[body], pose.position, pose.attitude, ({ index }) => pose.rest[index]) };
  }
}

// Position and attitude of the links of a body from those of its torso and the angle (rad) of each joint.
function placed({ links, chain }, position, attitude, angle) {
  const poses = { Torso: { position, attitude } };
  for (const joint of chain) {
    const parent = poses[joint.parent], offset = turned(parent.attitude, joint.offset);
    poses[joint.link] = { position: parent.position.map((x, k) => x + offset[k]), attitude: times(parent.attitude, about(joint.axis, angle(joint))) };
  }
  return { position: links.flatMap((link) => poses[link].position), attitude: links.flatMap((link) => poses[link].attitude) };
}

function triples(numbers) {
  const out = [];
  for (let i = 0; i + 2 < numbers.length && !Number.isNaN(numbers[i]); i += 3) out.push([numbers[i], numbers[i + 1], numbers[i + 2]]);
  return out;
}

// Quaternions (w, x, y, z).
function about([x, y, z], angle) {
  const s = Math.sin(angle / 2);
  return [Math.cos(angle / 2), s * x, s * y, s * z];
}

function times([a, b, c, d], [e, f, g, h]) {
  return [a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e];
}

function turned(q, v) {
  return times(times(q, [0, ...v]), [q[0], -q[1], -q[2], -q[3]]).slice(1);
}
