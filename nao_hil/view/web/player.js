// The player of an exported run: unpacks it, keeps its time, and answers to the person.
"use strict";

const NOTHING = -(2 ** 31);
const EVENT_COLOURS = { world: "#fcc419", fall: "#fa5252" };
const KEPT = 32; // footprints
const FOLLOW = 0.12; // share of the way to the robot that the camera goes in a picture
const THEMES = {
  dark: { background: [0.1, 0.11, 0.125], grid: [0.55, 0.58, 0.63], shadow: 0.42, text: "#e9ecef", faint: "#868e96", field: "#141517", page: "#1a1b1e" },
  light: { background: [0.93, 0.945, 0.96], grid: [0.45, 0.49, 0.55], shadow: 0.22, text: "#212529", faint: "#868e96", field: "#f1f3f5", page: "#ffffff" },
};
for (const theme of Object.values(THEMES))
  theme.event = (event, first) => (first ? "#fa5252" : (EVENT_COLOURS[event.kind] ?? "#ff922b"));

// What Python packed: see nao_hil/view/export/packing.py.
async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = await new Response(stream).arrayBuffer();
  const length = new DataView(bytes).getUint32(0, true);
  const data = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  let offset = 4 + length;
  const tables = {};
  for (const { name, rows, columns, step } of data.tables) {
    const whole = new Int32Array(bytes.slice(offset, offset + 4 * rows * columns));
    const numbers = new Float32Array(rows * columns); // row by row
    for (let column = 0; column < columns; column++)
      for (let row = 0, sum = 0; row < rows; row++) {
        sum = (sum + whole[column * rows + row]) | 0;
        numbers[row * columns + column] = sum === NOTHING ? NaN : sum * step;
      }
    tables[name] = { rows, columns, at: (row, column) => numbers[row * columns + column], row: (i) => numbers.subarray(i * columns, (i + 1) * columns) };
    offset += 4 * rows * columns;
  }
  return { ...data, tables };
}

class Player {
  constructor(data) {
    this.data = data;
    const { time } = data.tables;
    this.first = time.at(0, 0);
    this.last = time.at(time.rows - 1, 0);
    data.duration = this.last - this.first;
    data.row = (t) => {
      let [low, high] = [0, time.rows - 1];
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (time.at(middle, 0) <= t + 1e-6) low = middle;
        else high = middle - 1;
      }
      return low;
    };
    this.prints = Array.from({ length: data.tables.footprints.rows }, (_, i) => {
      const [when, kind, ...numbers] = data.tables.footprints.row(i);
      return { when, kind, corners: triples(numbers) };
    });
    this.time = this.first;
    this.playing = false;
    this.camera = { azimuth: -0.93, elevation: 0.38, distance: 1.25, aim: null, shift: [0, 0, 0] };
  }

  // All that is drawn of a time, between two moments of the recording.
  moment(time) {
    const { tables } = this.data, i = this.data.row(time), k = Math.min(i + 1, tables.time.rows - 1);
    const gap = tables.time.at(k, 0) - tables.time.at(i, 0), share = gap > 0 ? Math.min((time - tables.time.at(i, 0)) / gap, 1) : 0;
    const between = (table) => {
      const a = table.row(i), b = table.row(k);
      return Array.from(a, (x, n) => (Number.isNaN(b[n]) ? x : x + share * (b[n] - x)));
    };
    const [tips, ...corners] = tables.support.row(i);
    return {
      position: between(tables.position),
      attitude: between(tables.attitude),
      points: between(tables.points),
      loads: between(tables.loads),
      support: { tips: tips > 0.5, corners: triples(corners) },
      footprints: this.prints.filter((print) => print.when <= time).slice(-KEPT),
      step: tables.steps.at(i, 0),
      phase: this.data.phases[tables.phase.at(i, 0)]?.name,
    };
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.first), this.last);
    this.jumped = true;
  }

  // Where the camera is; it follows the torso over the ground, smoothly unless the time jumped.
  view(moment) {
    const { camera } = this, torso = this.data.links.indexOf("Torso");
    const at = [moment.position[3 * torso], moment.position[3 * torso + 1], 0.24];
    const share = camera.aim && !this.jumped ? FOLLOW : 1;
    camera.aim = camera.aim ? camera.aim.map((x, i) => x + share * (at[i] - x)) : at;
    this.jumped = false;
    const { azimuth, elevation, distance, shift } = camera, flat = Math.cos(elevation);
    const aim = camera.aim.map((x, i) => x + shift[i]);
    const eye = aim.map((x, i) => x + distance * [flat * Math.cos(azimuth), flat * Math.sin(azimuth), Math.sin(elevation)][i]);
    return { eye, aim };
  }
}

function triples(numbers) {
  const out = [];
  for (let i = 0; i + 2 < numbers.length && !Number.isNaN(numbers[i]); i += 3) out.push(Array.from(numbers.slice(i, i + 3)));
  return out;
}

// One finger or button turns, two fingers or the other button move, wheel and pinch come nearer.
function orbit(canvas, camera) {
  const down = new Map();
  const turn = (dx, dy) => {
    camera.azimuth -= 0.008 * dx;
    camera.elevation = Math.min(Math.max(camera.elevation + 0.008 * dy, 0.02), 1.5);
  };
  const move = (dx, dy) => {
    const step = 0.0012 * camera.distance, { azimuth } = camera;
    camera.shift[0] += step * (dx * Math.sin(azimuth) - dy * Math.cos(azimuth));
    camera.shift[1] -= step * (dx * Math.cos(azimuth) + dy * Math.sin(azimuth));
  };
  const nearer = (factor) => (camera.distance = Math.min(Math.max(camera.distance * factor, 0.4), 8));
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => down.delete(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!down.has(event.pointerId)) return;
    const apart = () => {
      const [a, b] = [...down.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    const [x, y] = down.get(event.pointerId), before = down.size > 1 ? apart() : 0;
    down.set(event.pointerId, [event.clientX, event.clientY]);
    const way = [event.clientX - x, event.clientY - y];
    if (down.size > 1) {
      nearer(before / Math.max(apart(), 1));
      move(0.5 * way[0], 0.5 * way[1]);
    } else if (event.buttons === 1) turn(...way);
    else move(...way);
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    nearer(Math.exp(0.001 * event.deltaY));
  }, { passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
}

const $ = (id) => document.getElementById(id);

async function begin() {
  const player = new Player(await unpack($("run").textContent)), { data } = player;
  const scene = new Scene($("scene"), data), charts = new Charts($("charts"), data, (t) => (stop(), player.seek(t)));
  let theme = matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark", last = performance.now();

  const stop = () => play(false);
  const play = (on) => {
    if (on && player.time >= player.last) player.seek(player.first);
    player.playing = on;
    $("play").textContent = on ? "Pause" : "Play";
    if (!on) history.replaceState(null, "", `#t=${player.time.toFixed(2)}`);
  };
  const dress = () => {
    document.documentElement.dataset.theme = theme;
    $("theme").textContent = theme === "dark" ? "Light" : "Dark";
  };
  const step = (by) => (stop(), player.seek(player.time + by));
  const linked = () => {
    const found = /t=([\d.]+)/.exec(location.hash);
    if (found) stop(), player.seek(Number(found[1]));
    return found !== null;
  };

  $("title").textContent = data.title;
  $("subtitle").textContent = data.subtitle;
  Object.assign($("slider"), { min: player.first, max: player.last, step: 0.01 });
  $("slider").addEventListener("input", () => (stop(), player.seek(Number($("slider").value))));
  $("play").addEventListener("click", () => play(!player.playing));
  $("back").addEventListener("click", () => step(-0.03));
  $("forward").addEventListener("click", () => step(0.03));
  $("theme").addEventListener("click", () => ((theme = theme === "dark" ? "light" : "dark"), dress()));
  addEventListener("hashchange", linked);
  addEventListener("keydown", (event) => {
    const act = { " ": () => play(!player.playing), ArrowLeft: () => step(-0.03), ArrowRight: () => step(0.03) }[event.key];
    if (!act || event.ctrlKey || event.altKey || event.metaKey || event.target.matches("select")) return;
    event.preventDefault();
    act();
  });
  for (const event of data.events) {
    const mark = document.createElement("i"), row = document.createElement("li"), link = document.createElement("a");
    const first = data.fall && event.time === data.fall.first && event.kind !== "world";
    mark.style.left = `${(100 * (event.time - player.first)) / Math.max(data.duration, 1e-3)}%`;
    mark.style.background = link.style.color = THEMES.dark.event(event, first);
    link.href = `#t=${event.time.toFixed(2)}`;
    link.textContent = `${event.time.toFixed(2)} s`;
    row.append(link, ` ${event.text}${first ? ": what went wrong first" : ""}`);
    $("marks").append(mark);
    $("events").append(row);
  }
  if (!data.events.length) $("events").textContent = "nothing out of the ordinary";
  for (const point of data.points) {
    const row = document.createElement("li"), dot = document.createElement("b");
    dot.style.color = `rgb(${point.colour})`;
    dot.textContent = "● ";
    row.append(dot, `${point.label}: ${point.meaning}`);
    $("legend").append(row);
  }
  orbit($("scene"), player.camera);

  const draw = () => {
    const moment = player.moment(player.time), canvas = $("scene"), scale = Math.min(devicePixelRatio, 2);
    const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    scene.draw(moment, player.view(moment), THEMES[theme]);
    charts.draw(player.time, THEMES[theme]);
    $("slider").value = player.time;
    $("now").textContent = `${player.time.toFixed(2)} s`;
    $("state").textContent = words(moment);
    const fell = data.fall && player.time >= data.fall.time;
    $("fell").hidden = !fell;
    if (fell) $("fell").textContent = verdict(data.fall);
  };
  const tick = (now) => {
    if (player.playing) {
      player.time = Math.min(player.time + (0.001 * (now - last)) * Number($("speed").value), player.last);
      if (player.time >= player.last) stop();
    }
    last = now;
    if (player.filmed) return;
    draw();
    requestAnimationFrame(tick);
  };
  dress();
  if (!linked()) play(true);
  window.player = Object.assign(player, { scene, charts, theme: () => THEMES[theme] });
  document.body.dataset.ready = "yes";
  requestAnimationFrame(tick);
}

function words(moment) {
  return [moment.phase ?? "", Number.isNaN(moment.step) ? "" : `step ${moment.step}`].filter(Boolean).join(" · ");
}

function verdict(fall) {
  return `It fell at ${fall.time.toFixed(2)} s. What went wrong first: ${fall.text}. ${fall.meaning}`;
}

begin().catch((error) => {
  document.body.dataset.ready = "no";
  $("fell").hidden = false;
  $("fell").textContent = `The run cannot be shown: ${error.message}.`;
  throw error;
});
