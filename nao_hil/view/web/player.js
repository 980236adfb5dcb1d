// The page: keeps its time, its camera and its overlays, and answers to the person. Live, replay and exported file alike.
"use strict";

const EVENTS = { world: "#fab005", order: "#4dabf7", fall: "#fa5252" };
const FOLLOW_TIME = 0.2; // s in which the camera makes up for most of its way to the robot
const LIVE_LAG = 0.08; // s of robot time by which a live picture follows the newest row, so that it moves evenly
const RUN_DISTANCE = 0.6; // m between two runs that are shown together
const CHART_EVERY = 50; // ms
const SOFTWARE_INTERVAL = 31; // ms from one picture to the next without a graphics card
const THEMES = {
  dark: { background: [0.078, 0.086, 0.102], floor: [0.155, 0.17, 0.195], carpet: [0.09, 0.24, 0.14], grid: [0.55, 0.6, 0.68], shadow: [0.62, 0.5], estimate: [1, 0.66, 0.2], text: "#eceff3", faint: "#8b95a1", field: "#14161a", page: "#1b1e23" },
  light: { background: [0.933, 0.945, 0.961], floor: [0.965, 0.972, 0.98], carpet: [0.42, 0.66, 0.46], grid: [0.5, 0.55, 0.62], shadow: [0.34, 0.4], estimate: [0.91, 0.35, 0.05], text: "#1c2127", faint: "#727d89", field: "#f3f5f8", page: "#ffffff" },
};
for (const theme of Object.values(THEMES)) theme.event = (event, first) => (first ? EVENTS.fall : (EVENTS[event.kind] ?? "#ff922b"));
const CAMERA = { azimuth: -0.8, elevation: 0.3, distance: 1.32, shift: [0, 0, 0] };
const FAR = 1.85; // distance of the camera from two robots, m
const OVERLAYS = {
  com: ["centre of mass", "and its projection on the ground", "com"],
  capture: ["capture point", "a foot there would bring the robot to rest", "capture"],
  zmp: ["ZMP", "zero moment point: planned (blue), by the foot sensors (orange), true (green); at the edge of the feet the robot tips", "zmp_true"],
  support: ["support polygon", "hull of the soles on the ground; red: the robot tips", "safe"],
  forces: ["forces", "bars over the force sensors, 6 mm per N", "safe"],
  footsteps: ["footsteps", "planned (blue) and made (grey)", "planned"],
  estimate: ["estimated pose", "outline: by encoders and inertial unit, placed at the true position of the torso", ""],
};
const KEYS = {
  "Space": "play, pause", "← →": "one picture back, on", "l": "back to the present (live)", "c": "camera back to its place", "?": "this sheet",
  "Esc": "emergency stop of the robot that is shown (live; closes an open sheet first)", "Shift + arrows, + −": "turn, nearer, farther (focus on the picture)", "drag": "turn; right button or two fingers: move; wheel or pinch: nearer", "Shift + drag": "push the robot (live)", "charts": "point to read, click to go there, wheel to zoom",
};

class Player {
  constructor() {
    this.runs = [];
    this.time = 0;
    this.playing = this.following = false;
    this.camera = { ...CAMERA, shift: [0, 0, 0], aim: null };
    this.overlays = Object.fromEntries(Object.keys(OVERLAYS).map((name) => [name, name !== "estimate"]));
    this.push = null; // shown as an arrow, N s
    this.theme = matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark";
    this.scene = new Scene($("scene"));
    this.charts = new Charts(this);
    this.tab = "Charts";
    this.adaptive = true; // the picture's resolution, to the time that it takes
  }

  get first() {
    return Math.min(...this.runs.map((run) => run.first));
  }

  get last() {
    return Math.max(...this.runs.map((run) => run.last));
  }

  get colours() {
    return THEMES[this.theme];
  }

  show(runs) {
    this.runs = runs;
    for (const run of runs) this.scene.load(run);
    const [{ header }] = runs;
    this.chooser(header);
    $("title").textContent = runs.map((run) => run.header.title).join(" and ");
    $("subtitle").textContent = runs.map((run) => run.header.subtitle).join(" · ");
    this.time = Math.min(Math.max(this.time, this.first), this.last);
    if (header.live) this.time = this.last;
    if (runs.length > 1) this.home();
    this.difference = runs.length === 2 ? new DifferenceRun(...runs) : null;
    this.charts.begin();
    this.events();
    if (this.difference) differencesTab(this);
    legend(this);
    jointTable(this);
  }

  // The robots of the world, one of them chosen.
  chooser({ name, names = [] }) {
    const select = $("robot");
    select.hidden = names.length < 2;
    if ([...select.options].map((option) => option.value).join() !== names.join()) select.replaceChildren(...names.map((each) => new Option(each)));
    select.value = name;
  }

  choose(name) {
    if (this.live) this.live.choose(name);
    else this.show(this.world.filter(({ header }) => header.name === name));
  }

  // The camera at its place.
  home() {
    Object.assign(this.camera, CAMERA, { shift: [0, 0, 0] }, this.runs.length > 1 ? { distance: FAR } : {});
  }

  goTo(time) {
    this.play(false);
    this.following = false;
    this.time = Math.min(Math.max(time, this.first), this.last);
    this.jumped = true;
    if (!this.runs[0].header.live) history.replaceState(null, "", `#t=${this.time.toFixed(2)}`);
  }

  play(on) {
    if (on && this.time >= this.last && !this.following) this.goTo(this.first);
    this.playing = on;
    this.following = this.following && !on;
    $("play").textContent = on ? "Pause" : "Play";
  }

  follow() {
    this.play(false);
    this.following = true;
  }

  advance(elapsed) {
    if (this.following) {
      const late = this.last - LIVE_LAG - this.time;
      this.time = Math.abs(late) > 0.6 ? this.last - LIVE_LAG : Math.min(this.time + elapsed + 0.1 * (late - elapsed), this.last);
    } else if (this.playing) {
      this.time = Math.min(this.time + elapsed * Number($("speed").value), this.last);
      if (this.time >= this.last) this.runs[0].header.live ? this.follow() : this.play(false);
    }
  }

  actors() {
    return this.runs.filter((run) => run.count).map((run, i) => ({ run, model: run.models[0], moment: run.moment(Math.min(this.time, run.last)), shift: [0, -RUN_DISTANCE * i, 0] }));
  }

  // Where the camera is; it follows the robot over the ground, smoothly unless the time jumped.
  view(actors, elapsed) {
    const { camera } = this, share = 1 - Math.exp(-elapsed / FOLLOW_TIME);
    const mean = (k) => actors.reduce((sum, { moment, shift }) => sum + moment.torso[k] + shift[k], 0) / actors.length;
    const at = [mean(0), mean(1), 0.25], far = !camera.aim || this.jumped || Math.hypot(...minus(at, camera.aim)) > 0.5;
    camera.aim = far ? at : camera.aim.map((x, i) => x + share * (at[i] - x));
    this.jumped = false;
    const { azimuth, elevation, distance, shift } = camera, flat = Math.cos(elevation), aim = camera.aim.map((x, i) => x + shift[i]);
    const eye = aim.map((x, i) => x + distance * [flat * Math.cos(azimuth), flat * Math.sin(azimuth), Math.sin(elevation)][i]);
    return { eye, aim, ground: [at[0], at[1], 0] };
  }

  draw(now) {
    const actors = this.actors(), { scene, colours } = this, canvas = scene.canvas;
    if (!actors.length || (scene.software && now - (this.drawn ?? 0) < SOFTWARE_INTERVAL)) return;
    const elapsed = now - (this.drawn ?? now);
    if (this.adaptive && elapsed) scene.adapt(elapsed);
    this.drawn = now;
    const scale = Math.min(devicePixelRatio, scene.sharpness);
    const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (Math.abs(canvas.width - w) > 0.04 * w || Math.abs(canvas.height - h) > 0.04 * h) Object.assign(canvas, { width: w, height: h });
    scene.draw(actors, { colours, camera: this.view(actors, 0.001 * elapsed), overlays: this.overlays, push: this.push });
    this.pictures = (this.pictures ?? 0) + 1;
    this.labels(actors);
    if (now - (this.charted ?? 0) < CHART_EVERY) return;
    this.charted = now;
    this.charts.draw(this.time, colours);
    if (this.tab === "Joints") jointValues(this, actors[0]);
    Object.assign($("slider"), { min: this.first, max: this.last });
    $("slider").value = this.time;
    this.marks();
    $("now").textContent = `${this.time.toFixed(2)} s`;
    this.chip();
  }

  // State of the robot, or of the walk at the moment shown, and the verdict on a fall.
  chip() {
    if (!this.runs.length) return;
    const moment = this.actors()[0]?.moment ?? { step: NaN, game: "" }, { live, fall } = this.runs[0].header, state = this.following && live ? live.state : null;
    const past = Boolean(live) && !this.following;
    document.body.classList.toggle("past", past);
    if (this.live?.lost) return this.live.chip();
    const parts = past ? [`the past, ${(this.last - this.time).toFixed(1)} s ago`, moment.phase ?? ""] : state?.words ? [state.words, state.walks && moment.step ? `step ${moment.step}` : ""] : [moment.phase ?? "", Number.isNaN(moment.step) ? "" : `step ${moment.step}`];
    $("state").textContent = parts.filter(Boolean).join(" · ");
    $("state").classList.toggle("alarm", Boolean(state?.alarm));
    const fell = fall && this.time >= fall.time && this.time < (fall.until ?? Infinity);
    $("fell").hidden = !fell;
    if (fell) $("fell").textContent = verdict(fall);
    Object.assign($("game"), { hidden: !moment.game, textContent: moment.game });
    $("live").setAttribute("aria-pressed", this.following);
  }

  labels(actors) {
    const shown = actors.length > 1 ? actors.map(({ run, moment, shift }) => [run.header.title, moment.torso.map((x, k) => x + shift[k]), 0.34]) : [];
    for (const { run, moment } of actors) if (moment.others.length) shown.push(...[{ name: run.header.name, torso: moment.torso }, ...moment.others].map(({ name, torso }) => [name, torso, 0.34]));
    if (this.overlays.estimate) shown.push(...actors.map(({ moment, shift }) => ["estimated pose", moment.torso.map((x, k) => x + shift[k]), 0.26]));
    const box = $("labels");
    while (box.children.length > shown.length) box.lastChild.remove();
    shown.forEach(([text, [x, y, z], over], i) => {
      const label = box.children[i] ?? box.appendChild(document.createElement("span")), at = this.scene.project([x, y, z + over]);
      label.hidden = !at;
      if (label.textContent !== text) label.textContent = text;
      if (at) Object.assign(label.style, { left: `${at[0]}px`, top: `${at[1]}px` });
    });
  }

  // Events of the runs: marks of the timeline, and the list.
  events() {
    const rows = this.runs.flatMap((run, number) => run.header.events.map((event) => ({ ...event, number, first: isFirst(event, run.header.fall) })));
    rows.sort((a, b) => a.time - b.time);
    $("marks").replaceChildren(...rows.map((event) => {
      const mark = document.createElement("i");
      mark.dataset.time = event.time;
      mark.style.background = this.colours.event(event, event.first);
      return mark;
    }));
    this.marks();
    $("events").replaceChildren(...rows.map((event) => {
      const run = this.runs.length > 1 ? `${this.runs[event.number].header.title}: ` : "";
      return this.eventRow(event, `${run}${event.text}${event.first ? ": what went wrong first" : ""}`);
    }));
    if (!rows.length) $("events").textContent = "Nothing out of the ordinary.";
  }

  // The marks on the timeline, which grows.
  marks() {
    const duration = Math.max(this.last - this.first, 1e-3);
    for (const mark of $("marks").children) mark.style.left = `${(100 * (mark.dataset.time - this.first)) / duration}%`;
  }

  eventRow(event, text) {
    const link = el("a", { href: `#t=${event.time.toFixed(2)}`, textContent: `${event.time.toFixed(2)} s`, style: `color: ${this.colours.event(event, event.first)}` });
    link.addEventListener("click", (click) => (click.preventDefault(), this.goTo(event.time)));
    return el("li", {}, link, el("span", { textContent: text }));
  }
}

// One finger or button turns, two fingers or the other button move, wheel and pinch zoom.
function orbit(player) {
  const { canvas } = player.scene, { camera } = player, down = new Map();
  const turn = (dx, dy) => {
    camera.azimuth -= 0.008 * dx;
    camera.elevation = Math.min(Math.max(camera.elevation + 0.008 * dy, 0.02), 1.5);
  };
  const move = (dx, dy) => {
    const step = 0.0012 * camera.distance, { azimuth, shift } = camera;
    camera.shift = [shift[0] + step * (dx * Math.sin(azimuth) - dy * Math.cos(azimuth)), shift[1] - step * (dx * Math.cos(azimuth) + dy * Math.sin(azimuth)), 0];
  };
  const nearer = (factor) => (camera.distance = Math.min(Math.max(camera.distance * factor, 0.35), 14));
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, [event.clientX, event.clientY]);
    if (event.shiftKey && player.live) player.drag = { from: [event.clientX, event.clientY] };
  });
  const up = (event) => {
    down.delete(event.pointerId);
    if (!player.drag) return;
    if (event.type === "pointerup" && player.push) player.live.push(player.push);
    else player.push = null;
    player.drag = null;
  };
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, up);
  canvas.addEventListener("pointermove", (event) => {
    if (!down.has(event.pointerId)) return;
    const apart = () => Math.hypot(...minus(...down.values()));
    const [x, y] = down.get(event.pointerId), before = down.size > 1 ? apart() : 0;
    down.set(event.pointerId, [event.clientX, event.clientY]);
    const way = [event.clientX - x, event.clientY - y];
    if (player.drag) return dragged(player, event);
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
  const keys = { ArrowLeft: () => turn(12, 0), ArrowRight: () => turn(-12, 0), ArrowUp: () => turn(0, 12), ArrowDown: () => turn(0, -12), "+": () => nearer(0.9), "-": () => nearer(1.1) };
  canvas.addEventListener("keydown", (event) => {
    const { key } = event;
    if (!keys[key] || event.ctrlKey || (key.startsWith("Arrow") && !event.shiftKey)) return;
    keys[key]();
    event.preventDefault();
    event.stopPropagation(); // arrows alone move in time
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
}

// The push of a drag over the picture: its level way, in the robot's heading, N s.
function dragged(player, event) {
  const { camera, drag } = player, scale = (0.62 * camera.distance) / player.scene.canvas.clientHeight / ARROW_SCALE;
  const right = scale * (event.clientX - drag.from[0]), ahead = -scale * (event.clientY - drag.from[1]);
  const [{ moment }] = player.actors(), angle = camera.azimuth + Math.PI - moment.heading;
  const limit = (x) => Math.min(Math.max(x, -3), 3);
  player.push = [limit(ahead * Math.cos(angle) + right * Math.sin(angle)), limit(ahead * Math.sin(angle) - right * Math.cos(angle))];
}

function legend(player) {
  const { colours, points } = player.runs[0].header;
  const rows = Object.entries(OVERLAYS).map(([name, [title, meaning, colour]]) => {
    const row = document.createElement("label"), box = document.createElement("input"), words = document.createElement("span"), small = document.createElement("small"), dot = document.createElement("i");
    Object.assign(box, { type: "checkbox", checked: player.overlays[name] });
    box.addEventListener("change", () => (player.overlays[name] = box.checked));
    const found = points.find((point) => point.name === colour)?.colour ?? colours[colour];
    dot.style.background = found ? `rgb(${found})` : `rgb(${player.colours.estimate.map((x) => 255 * x)})`;
    words.append(dot, title);
    small.textContent = meaning;
    row.append(box, words, small);
    return row;
  });
  $("legend").replaceChildren(Object.assign(document.createElement("h2"), { textContent: "Overlays" }), ...rows);
}

const DECIMALS = { command: 1, angle: 1, current: 2, temperature: 0 }; // of the columns of the joints

function jointTable(player) {
  const { header } = player.runs[0], cell = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });
  const head = document.createElement("tr");
  head.append(...["joint", "command, deg", "angle, deg", "A", "°C"].map((text) => cell("th", text)));
  const rows = header.joints.map(([name, low, high]) => {
    const row = document.createElement("tr");
    Object.assign(row, { title: `${name}: chart of command and angle; ${low.toFixed(0)} to ${high.toFixed(0)} deg` });
    row.dataset.joint = name;
    row.append(cell("td", name), ...Object.keys(DECIMALS).map((quantity) => Object.assign(cell("td", ""), { className: quantity })));
    const nameCell = row.firstChild, chart = (event) => {
      if (event.target.matches("input") || (event.type === "keydown" && event.key !== "Enter" && event.key !== " ")) return;
      if (event.type === "keydown" && event.target === nameCell) event.preventDefault();
      player.charts.toggle(`angle ${name}`, `command ${name}`);
      player.open("Charts");
      $("charts").parentElement.scrollTop = 1e6;
    };
    Object.assign(nameCell, { tabIndex: 0, role: "button" });
    nameCell.setAttribute("aria-label", `chart of ${name}`);
    for (const kind of ["click", "keydown"]) row.addEventListener(kind, chart);
    return row;
  });
  $("joints").replaceChildren(head, ...rows);
}

function jointValues(player, { run, moment }) {
  for (const row of $("joints").querySelectorAll("tr[data-joint]"))
    for (const [quantity, decimals] of Object.entries(DECIMALS)) {
      const value = run.value(moment.row, run.signal[`${quantity} ${row.dataset.joint}`]), cell = row.querySelector(`.${quantity}`);
      if (!cell.firstElementChild) cell.textContent = Number.isNaN(value) ? "" : value.toFixed(decimals);
    }
}

function verdict(fall) {
  return `It fell at ${fall.time.toFixed(2)} s. What went wrong first: ${fall.text}. ${fall.meaning}`;
}

// Whether a key is the focused control's own: text, arrows on a slider, Space on a button.
function ownKey(target, key) {
  if (target.matches("input[type=range]")) return key.startsWith("Arrow") || ["Home", "End", "PageUp", "PageDown"].includes(key);
  if (target.matches("button, a, input[type=checkbox], [role=button]")) return key === " " || key === "Enter";
  return target.matches("select, input");
}

// Buttons and keys that all three kinds of page have.
function controls(player) {
  player.open = (name) => {
    player.tab = name;
    for (const tab of document.querySelectorAll(".tab")) tab.hidden = tab.dataset.name !== name;
    for (const button of document.querySelector("nav").children) button.setAttribute("aria-selected", button.textContent === name);
    if (name === "Run") player.live?.listRecordings?.(); // the recordings have grown
  };
  player.tabs = () => {
    const names = [...document.querySelectorAll(".tab")].map((tab) => tab.dataset.name);
    document.querySelector("nav").replaceChildren(...names.map((name) => {
      const button = Object.assign(document.createElement("button"), { textContent: name });
      button.setAttribute("role", "tab");
      button.addEventListener("click", () => player.open(name));
      return button;
    }));
    player.open(names.includes(player.tab) ? player.tab : "Charts");
  };
  const step = (by) => player.goTo(player.time + by);
  const setTheme = (theme) => {
    player.theme = document.documentElement.dataset.theme = theme;
    if (player.runs.length) player.events();
  };
  const sheet = (name) => {
    for (const each of document.querySelectorAll(".sheet")) each.hidden = each.id !== name || !each.hidden;
  };
  const camera = () => player.home();
  const acts = { " ": () => player.play(!player.playing), ArrowLeft: () => step(-0.03), ArrowRight: () => step(0.03), c: camera, l: () => player.live && player.follow(), "?": () => sheet("help"), Escape: () => sheet("") };
  $("robot").addEventListener("change", () => player.choose($("robot").value));
  $("slider").addEventListener("input", () => player.goTo(Number($("slider").value)));
  $("play").addEventListener("click", acts[" "]);
  $("back").addEventListener("click", acts.ArrowLeft);
  $("forward").addEventListener("click", acts.ArrowRight);
  $("camera").addEventListener("click", camera);
  $("live").addEventListener("click", acts.l);
  $("theme").addEventListener("click", () => setTheme(player.theme === "dark" ? "light" : "dark"));
  for (const button of document.querySelectorAll("[data-sheet]")) button.addEventListener("click", () => sheet(button.dataset.sheet));
  addEventListener("keydown", (event) => {
    const { key, target } = event, open = [...document.querySelectorAll(".sheet")].some((each) => !each.hidden);
    if (!player.runs.length || event.ctrlKey || event.altKey || event.metaKey) return;
    if (key === "Escape" && player.live && !open && !target.matches("select:not(#robot)")) return player.live.emergency(), event.preventDefault();
    if (ownKey(target, key)) return;
    const drives = player.live?.drives(key);
    if (!drives && !acts[key]) return;
    event.preventDefault();
    if (drives) player.live.key(key);
    else acts[key]();
  });
  $("keys").replaceChildren(...Object.entries(KEYS).flatMap(([key, does]) => [Object.assign(document.createElement("dt"), { textContent: key }), Object.assign(document.createElement("dd"), { textContent: does })]));
  setTheme(player.theme);
  player.tabs();
  orbit(player);
}

function linked(player) {
  const found = /t=([\d.]+)/.exec(location.hash);
  if (found) player.goTo(Number(found[1]));
  return found !== null;
}

async function begin() {
  const player = (window.player = new Player()), packed = [...document.querySelectorAll('script[type="application/octet-stream"]')];
  controls(player);
  let last = performance.now();
  const tick = (now) => {
    if (player.filmed) return;
    if (player.runs.length) {
      player.advance(0.001 * (now - last));
      player.draw(now);
    }
    last = now;
    requestAnimationFrame(tick);
  };
  if (packed.length) {
    player.world = await Promise.all(packed.map((each) => unpack(Uint8Array.from(atob(each.textContent), (c) => c.charCodeAt(0)))));
    player.show(player.world[0].header.names ? [player.world[0]] : player.world);
    addEventListener("hashchange", () => linked(player));
    if (!linked(player)) player.play(true);
    document.body.dataset.ready = "yes";
  } else player.live = new Live(player);
  requestAnimationFrame(tick);
}

begin().catch((error) => {
  document.body.dataset.ready = "no";
  $("fell").hidden = false;
  $("fell").textContent = `The run cannot be shown: ${error.message}.`;
  throw error;
});
