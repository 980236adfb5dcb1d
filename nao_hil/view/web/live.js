// A live run: rows arrive over a WebSocket, orders return.
"use strict";

const DRAG_INTERVAL = 150; // ms between two orders of a knob that is dragged
const RETRY_INTERVAL = 700; // ms from a lost connection to the next try
const ANSWER_TIME = 6000; // ms for which an answer is shown
// Numbers of the pads; `most` at the edge.
const PADS = {
  velocity: [{ label: "forward", unit: "m/s", initial: "0.00", most: 0.4 }, { label: "to the left", unit: "m/s", initial: "0.00", most: 0.2 }, { label: "turn", unit: "rad/s", initial: "0.00", most: 1.5 }],
  push: [{ label: "forward", unit: "N s", initial: "0.00", most: 3 }, { label: "to the left", unit: "N s", initial: "1.00", most: 3 }],
};
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)$/;
const DRIVE_KEYS = { w: "faster", s: "slower", a: "turn left", d: "turn right", q: "left", e: "right", x: "stop", " ": "stop", g: "next gait", t: "next torso control", m: "admittance on, off" };
const LOST = "no connection; the robot may still move";
const SILENCE = 2500; // ms without a word of the server after which the connection counts as lost
const STOP_TIME = 2500; // ms in which an emergency stop is answered
const ALL = "Emergency stop all";
const DEAD_ZONE = 0.15; // of a gamepad's stick
const PAD_INTERVAL = 50; // ms between two looks at a gamepad

// An element: el("button", {properties}, ...children).
function el(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

class Live {
  constructor(player) {
    this.player = player;
    this.connect();
    let late = false; // at the last look too: a page that was busy has messages waiting
    setInterval(() => {
      const silent = this.socket.readyState === WebSocket.OPEN && performance.now() - this.heard > SILENCE;
      if (silent && late) this.socket.onclose();
      late = silent;
    }, RETRY_INTERVAL);
  }

  connect() {
    this.socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/#.*/, ""));
    this.socket.binaryType = "arraybuffer";
    let chain = Promise.resolve(); // messages are taken one after the other: a packed run takes its time
    this.heard = performance.now();
    this.socket.onmessage = ({ data }) => {
      this.heard = performance.now();
      chain = chain.then(() => this.take(data)).catch(reportError); // the messages after a faulty one are taken
    };
    this.socket.onopen = () => this.connected(true);
    const { socket } = this;
    socket.onclose = async () => {
      socket.onclose = socket.onmessage = null; // also a connection that is only silent
      socket.close();
      this.connected(false);
      this.why = this.ended ?? (await this.refusal());
      if (this.why) this.notify(this.why, false, true);
      setTimeout(() => this.connect(), RETRY_INTERVAL);
    };
  }

  // Chip, picture and buttons show a lost connection.
  connected(on) {
    this.lost = !on;
    document.body.classList.toggle("lost", !on);
    for (const each of document.querySelectorAll("#robot, #orders button:not(.stop), .tab.live :is(button, input, select)")) each.disabled = !on;
    if (on) {
      [this.ended, this.runEnded] = [undefined, false];
      if (this.why) this.notify("");
      this.why = "";
      if (this.velocity && this.everywhere === false) this.velocity.straight();
    } else this.chip();
  }

  chip() {
    Object.assign($("state"), { textContent: this.runEnded ? "the run has ended" : LOST });
    $("state").classList.add("alarm");
    $("live").setAttribute("aria-pressed", false);
  }

  // Why the server refuses this page; empty: it does not answer, or it does not refuse.
  async refusal() {
    try {
      const response = await fetch("host", { cache: "no-store", signal: AbortSignal.timeout(SILENCE) }), text = (await response.text()).trim();
      if (!response.ok) return text;
      if (text !== location.host) return `The page's server refuses the connection: a proxy changed the header Host from ${location.host} to ${text}. It must pass Host and the WebSocket on (docs/security.md, "The page").`;
    } catch {} // no answer at all
    return "";
  }

  async take(data) {
    if (typeof data === "string") return this.update(JSON.parse(data));
    const start = new Uint8Array(data, 0, 2), [run] = this.player.runs;
    if (start[0] === 0x1f && start[1] === 0x8b) return this.show(await unpack(data));
    if (!run || data.byteLength !== 4 * run.width) return;
    run.append(new Float32Array(data));
    if (run.count === 1 && this.player.following) this.player.time = run.last;
  }

  show(run) {
    const { player } = this, followed = !player.runs.length || player.following;
    player.show([run]);
    if (followed) player.follow();
    this.holds = null; // the table of the joints is a new one
    $("live").hidden = false;
    document.body.classList.add("live");
    this.build(run.header.live);
    this.update({ state: run.header.live.state });
    document.body.dataset.ready = "yes";
  }

  update(message) {
    const run = this.player.runs[0], header = run?.header;
    if (message.ended !== undefined) {
      [this.ended, this.runEnded] = [message.ended, message.run];
      this.socket.close();
    }
    if (message.urgent) clearTimeout(this.unanswered);
    if (message.answer) this.notify(message.answer, message.done);
    if (message.done !== undefined && header) this.updateSelections(); // the order of one may have been refused, or has no effect yet
    if (message.caption) Object.assign($("caption"), { hidden: false, textContent: message.caption });
    if (!header) return;
    if (message.prints) message.prints.forEach((print) => run.print(print));
    if (message.events) Object.assign(header, { events: message.events, fall: message.fall }), this.player.events();
    if (message.world) {
      const before = new Map(header.objects.map((object) => [object.name, objectPose(object)])), since = performance.now();
      for (const object of message.world.objects) Object.assign(object, { before: before.get(object.name), since });
      Object.assign(header, message.world);
    }
    if (message.state) (header.live.state = message.state), this.state(message.state);
  }

  notify(text, done = true, stays = false) {
    const toast = $("toast");
    Object.assign(toast, { textContent: text, className: done ? "card" : "card refused" });
    clearTimeout(this.silence);
    if (!stays) this.silence = setTimeout(() => (toast.textContent = ""), done ? ANSWER_TIME : 2 * ANSWER_TIME);
  }

  // To the robot that is shown now, whichever the server shows when it arrives.
  order(doing, fields = {}) {
    const robot = this.player.runs[0]?.header.name ?? "", stops = doing.startsWith("stop");
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ do: doing, robot, ...fields }));
    else this.notify(stops ? "The EMERGENCY STOP DID NOT GO OUT: no connection. Stop the robot at the robot, or by `nao-hil stop`." : "No connection; the order was not sent.", false, stops);
  }

  choose(robot) {
    this.order("choose", { robot });
  }

  emergency(all = false) {
    if (all) this.order("stop-all");
    else this.order("stop", { how: "crouch" });
    clearTimeout(this.unanswered);
    if (!this.lost) this.unanswered = setTimeout(() => this.notify("No answer to the EMERGENCY STOP: it may not have gone out. Stop the robot at the robot, or by `nao-hil stop`.", false, true), STOP_TIME);
  }

  walk(command) {
    this.order("walk", { command });
  }

  // Order a walk, unless a field of it holds no valid number.
  startWalk() {
    if ([...this.velocity.pad.values(), this.steps.value].every((value) => value !== null)) this.walk(this.settings("walk"));
    else this.notify("A field of the walk (tab Walk) holds no valid number; the order was not sent.", false);
  }

  world(command) {
    this.order("world", { command });
  }

  push([x, y]) {
    this.player.push = [x, y];
    this.world({ op: "push", impulse: [x, y, 0] });
    clearTimeout(this.aimed);
    this.aimed = setTimeout(() => (this.player.push = null), 2500);
  }

  drives(key) {
    return Boolean(this.driving?.checked && key in DRIVE_KEYS);
  }

  // A key of the keyboard; whether it is an order.
  key(key) {
    if (!this.drives(key)) return false;
    this.order("key", { key });
    return true;
  }

  // The selections show what is in force: the robot that gets the orders, and the slow motion.
  updateSelections() {
    const { header } = this.player.runs[0];
    this.player.chooser(header);
    if (this.slow) this.slow.value = header.live.state.time_scale ?? 1;
  }

  // What is in force: buttons, pad and fields.
  state(state) {
    const { live } = this.player.runs[0].header;
    Object.assign($("notice"), { hidden: !state.notice, textContent: state.notice ?? "" });
    if (!this.orders) return;
    const { names } = this.player.runs[0].header;
    for (const [name, button] of Object.entries(this.orders)) button.hidden = name === ALL ? names.length < 2 : name === "Arm" ? state.armed !== false : name !== "Emergency stop" && state.armed === false;
    const everywhere = live.gaits[state.gait] ?? true;
    this.everywhere = everywhere;
    if (state.gait && ![...this.gait.options].some(({ value }) => value === state.gait)) this.gait.add(new Option(state.gait));
    this.velocity.show(state.velocity, everywhere);
    if (this.paused) this.paused.textContent = state.paused ? "Resume" : "Pause"; // a real robot has no world
    this.missed.textContent = `cycles missed: ${state.missed} · controller: ${state.holder || "none"}`;
    this.updateSelections();
    this.player.chip();
    if (this.holds !== state.holds) this.sliders((this.holds = state.holds));
  }

  build(live) {
    const key = JSON.stringify({ ...live, state: null, joints: this.player.runs[0].header.joints });
    if (this.built === key) return;
    this.built = key;
    for (const tab of document.querySelectorAll(".tab.live")) tab.remove();
    const button = (label, act, properties = {}) => {
      const made = el("button", { textContent: label, ...properties });
      made.addEventListener("click", act);
      return made;
    };
    this.button = button;
    this.orders = {
      "Emergency stop": button("Emergency stop", () => this.emergency(), { className: "stop", title: "Esc: the robot crouches, lets go, and takes no command until it is armed again" }),
      [ALL]: button(ALL, () => this.emergency(true), { className: "stop", title: "all robots of this world crouch, let go, and take no command until each is armed again" }),
      Walk: button("Walk", () => this.startWalk(), { className: "go" }),
      Stop: button("Stop", () => this.order("key", { key: "x" })),
      Sit: button("Sit", () => this.walk({ op: "motion", motion: "sit-down" })),
      Arm: button("Arm", () => this.order("arm"), { className: "go", title: "take commands again", hidden: true }),
    };
    $("orders").replaceChildren(...Object.values(this.orders));
    $("orders").hidden = false;
    this.tab("Walk", this.walkTab(live));
    if (live.emulated) this.tab("World", this.worldTab(live));
    this.tab("Run", this.runTab(live));
    this.holds = null;
    const hold = button("Take the joints", () => this.order("hold", { on: !this.holds }), { title: "of a robot that no controller holds: nao-hil emulate --start hang" });
    $("hold").replaceChildren(...(live.emulated ? [el("div", { className: "row" }, (this.hold = hold))] : []));
    this.player.tabs();
  }

  tab(name, children) {
    const tab = el("section", { className: "tab live", hidden: true }, ...children);
    tab.dataset.name = name;
    document.querySelector("aside").append(tab);
  }

  row(...children) {
    return el("div", { className: "row" }, ...children);
  }

  select(label, options, hint = "") {
    const select = el("select", {}, ...options.map((text) => new Option(text)));
    select.setAttribute("aria-label", label);
    return [el("label", { className: "field", title: hint }, el("span", { textContent: label }), select), select];
  }

  // A field for a number; `value` is null while its text is none.
  number(label, unit, initial, low, high, changed) {
    const input = el("input", { type: "text", inputMode: "decimal", value: initial }), refusal = el("span", { className: "refusal", role: "status" });
    input.setAttribute("aria-label", `${label}, ${unit}`);
    const field = { box: el("label", { className: "field" }, el("span", { textContent: `${label}, ${unit}` }), input, refusal), input, value: Number(initial) };
    const check = () => {
      const text = input.value.trim().replace(",", "."), number = Number(text);
      const bad = !NUMBER.test(text) ? "not a number" : number < low || number > high ? `${low} to ${high}` : "";
      refusal.textContent = bad;
      input.classList.toggle("bad", Boolean(bad));
      field.value = bad ? null : number;
      return !bad;
    };
    input.addEventListener("input", check);
    input.addEventListener("change", () => check() && changed?.());
    field.set = (number) => {
      if (document.activeElement === input || input.classList.contains("bad")) return;
      field.value = number;
      input.value = number.toFixed(2);
    };
    return field;
  }

  // A pad to drag forward and to the left, with a strip for a turn if there are three numbers, and their fields.
  pad(numbers, act) {
    const square = el("div", { className: "pad" }, el("em", { textContent: "forward" }), el("b")), strip = el("div", { className: "pad strip" }, el("em", {}, el("span", { textContent: "turn left" }), el("span", { textContent: "turn right" })), el("b"));
    const fields = numbers.map(({ label, unit, initial, most }) => Object.assign(this.number(label, unit, initial, -10, 10, () => send(true)), { most }));
    const [forward, left, turn] = fields;
    const values = () => fields.map((field) => field.value);
    const place = () => {
      const percent = (field) => (field ? 50 - 50 * Math.max(-1, Math.min(1, (field.value ?? 0) / field.most)) : 50);
      Object.assign(square.lastChild.style, { top: `${percent(forward)}%`, left: `${percent(left)}%` });
      Object.assign(strip.lastChild.style, { top: "50%", left: `${percent(turn)}%` });
    };
    let sent = 0;
    const send = (typed = false) => {
      place();
      if (values().every((value) => value !== null)) act(values(), typed);
    };
    const drag = (event) => {
      if (event.type === "pointerdown") event.currentTarget.setPointerCapture(event.pointerId);
      if (event.type === "pointermove" && !event.buttons) return;
      const part = event.currentTarget, bounds = part.getBoundingClientRect();
      const share = (way) => (Math.abs(way) < 0.08 ? 0 : Math.max(-1, Math.min(1, way)));
      const toLeft = share(1 - (2 * (event.clientX - bounds.left)) / bounds.width), ahead = share(1 - (2 * (event.clientY - bounds.top)) / bounds.height);
      const set = (field, deflection) => ((field.value = deflection * field.most), (field.input.value = field.value.toFixed(2)), field.input.classList.remove("bad"));
      if (part === strip) set(turn, toLeft);
      else set(forward, ahead), set(left, toLeft);
      pad.dragging = event.type !== "pointerup";
      place();
      if (event.type !== "pointerup" && performance.now() - sent < DRAG_INTERVAL) return;
      sent = performance.now();
      send();
    };
    for (const part of [square, strip]) part.setAttribute("aria-hidden", "true"); // the fields are for keys and screen readers
    for (const part of [square, strip]) for (const kind of ["pointerdown", "pointermove", "pointerup"]) part.addEventListener(kind, drag);
    for (const part of [square, strip]) part.addEventListener("pointercancel", () => (pad.dragging = false));
    const box = el("div", { className: "pads" }, el("div", {}, square, ...(turn ? [el("div", { style: "height: 6px" }), strip] : [])), el("div", {}, ...fields.map((field) => field.box)));
    const pad = { box, values, place, fields };
    place();
    return pad;
  }

  settings(op) {
    const chosen = (select) => (select.selectedIndex ? select.value : undefined), command = { op };
    const [x, y, turn] = this.velocity.pad.values();
    if (op === "walk" && (x || y || turn)) command.velocity = [x, y, turn];
    if (op === "walk") command.steps = this.steps.value;
    command.gait = chosen(this.gait);
    command.torso = chosen(this.torso);
    command.admittance = { on: true, off: false }[chosen(this.admittance)];
    return command;
  }

  walkTab(live) {
    const walking = () => this.player.runs[0].header.live.state.walking;
    let pending = false; // numbers that are typed at a stand take effect with the button Walk
    const pad = this.pad(PADS.velocity, (velocity, typed) => {
      pending = typed && !walking();
      if (!pending) this.order("steer", { velocity });
    });
    this.velocity = {
      pad,
      show: (velocity, everywhere) => {
        pending &&= !walking();
        if (!pad.dragging && !pending) velocity.forEach((value, i) => pad.fields[i].set(value)), pad.place();
        if (!this.lost) pad.fields.slice(1).forEach((field) => (field.input.disabled = !everywhere));
      },
      straight: () => pad.fields.slice(1).forEach((field) => (field.input.disabled = true)),
    };
    const [gaitBox, gait] = this.select("gait", ["as it is", ...Object.keys(live.gaits)], "another one begins at a stand");
    const [torsoBox, torso] = this.select("torso control", ["as it is", "none", "thesis", "robust"], "keeps the torso upright");
    const [admittanceBox, admittance] = this.select("admittance", ["as it is", "on", "off"], "legs and ankles that give way to the ground");
    this.steps = this.number("steps", "0: no end", "0", 0, 1e6);
    Object.assign(this, { gait, torso, admittance });
    this.driving = el("input", { type: "checkbox" });
    const keys = el("p", { className: "faint", hidden: true }, Object.entries(DRIVE_KEYS).map(([key, does]) => `${key === " " ? "Space" : key} ${does}`).join(" · ") + " · gamepad: left stick walks, right stick turns, released they stop");
    this.driving.addEventListener("change", () => {
      keys.hidden = !this.driving.checked;
      if (this.driving.checked) $("scene").focus(); // Space is the stop from here on, not the box's
      this.pads();
    });
    this.missed = el("p", { className: "faint" });
    return [
      el("h2", { textContent: "Velocity in force" }), pad.box,
      el("label", { className: "row" }, this.driving, "drive by keys and gamepad"), keys,
      el("h2", { textContent: "Next walk" }), gaitBox, torsoBox, admittanceBox, this.steps.box,
      this.row(this.button("Set without walking", () => this.walk(this.settings("set")), { title: "a walk that is under way goes on, changed as far as that is possible in stride" })),
      el("h2", { textContent: "Motors" }), this.row(this.button("Let go", () => this.order("stop", { how: "limp" }), { title: "stiffness off at once: a standing robot falls" })),
      this.missed,
    ];
  }

  worldTab(live) {
    const world = (op, fields = {}) => () => this.world({ op, ...fields }), { button } = this;
    const pad = this.pad(PADS.push, (values) => (this.player.push = values));
    const push = () => pad.values().every((value) => value !== null) && this.push(pad.values());
    const angle = (label) => this.number(label, "deg", "0", -15, 15), roll = angle("roll"), pitch = angle("pitch");
    const friction = this.number("friction", "0.02 to 1.2", "0.8", 0.02, 1.2), height = this.number("height", "mm", "10", 1, 40);
    const whole = (...fields) => fields.every((field) => field.value !== null);
    const radians = (field) => (field.value * Math.PI) / 180;
    const tilt = () => whole(roll, pitch) && this.world({ op: "tilt", roll: radians(roll), pitch: radians(pitch), duration: 1 + 0.12 * (15 + Math.max(Math.abs(roll.value), Math.abs(pitch.value))) });
    const plate = (command) => () => whole(height) && this.world(command(0.001 * height.value));
    this.paused = button("Pause", () => this.world({ op: this.player.runs[0].header.live.state.paused ? "resume" : "pause" }));
    const [slowBox, slow] = this.select("slow motion", ["1", "0.5", "0.25", "0.1", "0.05"], "robot time per time of the clock");
    this.slow = slow;
    slow.addEventListener("change", () => this.order("slow", { speed: Number(slow.value) }));
    const press = (name) => {
      const made = button(name.replace(/_/g, " "), () => {});
      const send = (pressed) => this.world({ op: "press", button: name, pressed });
      made.addEventListener("pointerdown", (event) => (made.setPointerCapture(event.pointerId), send(true)));
      for (const end of ["pointerup", "pointercancel"]) made.addEventListener(end, () => send(false));
      const held = (event, pressed) => [" ", "Enter"].includes(event.key) && !event.repeat && (event.preventDefault(), (made.down = pressed), send(pressed));
      made.addEventListener("keydown", (event) => held(event, true));
      made.addEventListener("keyup", (event) => held(event, false));
      made.addEventListener("blur", () => made.down && ((made.down = false), send(false)));
      return made;
    };
    return [
      el("h2", { textContent: "Robot and time" }),
      this.row(button("Stand up", world("stand-up"), { title: "put it back on its feet" }), button("Reset", world("reset"), { title: "everything begins again" })),
      this.row(this.paused, button("Step", world("step"), { title: "one cycle, then it is paused" })), slowBox,
      el("h2", { textContent: "Push" }), pad.box, this.row(button("Push", push, { title: "or hold Shift and drag the robot" })),
      el("h2", { textContent: "Touch (pressed while held)" }), Object.assign(this.row(...live.buttons.map(press)), { className: "row three" }),
      el("h2", { textContent: "Floor" }), roll.box, pitch.box, this.row(button("Tilt the floor", tilt)), friction.box,
      this.row(button("Set friction", () => whole(friction) && this.world({ op: "friction", friction: friction.value }))),
      height.box,
      this.row(
        button("Plate under the swing foot", plate((z) => ({ op: "plate-under-foot", size: [0.16, 0.08, z] }))),
        button("Plate ahead", plate((z) => ({ op: "place", name: "ahead", size: [0.2, 0.4, z], at: [0.25, 0], frame: "robot" }))),
      ),
      ...this.faults(live),
    ];
  }

  faults(live) {
    const [kindBox, kind] = this.select("fault", Object.keys(live.faults));
    const [jointBox, joint] = this.select("joint", this.player.runs[0].header.joints.map(([name]) => name));
    const [sensorBox, sensor] = this.select("sensor", live.sensors), amount = this.number("amount", "0 to 1", "0.5", 0, 1);
    joint.value = "LKneePitch";
    const targets = { joint: [jointBox, joint], sensor: [sensorBox, sensor] };
    const choose = () => {
      const [target, number] = live.faults[kind.value];
      for (const [name, [box]] of Object.entries(targets)) box.hidden = name !== target;
      amount.box.hidden = !number;
      amount.box.firstChild.textContent = `${number}, 0 to 1`;
    };
    kind.addEventListener("change", choose);
    choose();
    const start = () => {
      const [target, number] = live.faults[kind.value], fault = { kind: kind.value };
      if (target) fault[target] = targets[target][1].value;
      if (number && amount.value === null) return;
      if (number) fault[number] = amount.value;
      this.world({ op: "fault-on", fault });
    };
    return [
      el("h2", { textContent: "Faults" }), kindBox, jointBox, sensorBox, amount.box,
      this.row(this.button("Begin the fault", start), this.button("End all faults", () => this.world({ op: "fault-off" }))),
    ];
  }

  runTab(live) {
    const parts = [];
    if (live.saves) {
      const list = el("div");
      const listRecordings = async () => {
        const sizes = await fetch("recordings").then((response) => response.json());
        const link = (name, kind) => el("a", { href: `${name}.${kind}`, textContent: kind === "mcap" ? "recording" : "page", download: "" });
        list.replaceChildren(...Object.entries(sizes).map(([name, size]) => el("div", { className: "field" }, `${name}, ${(1e-6 * size).toFixed(1)} MB`, el("span", {}, link(name, "mcap"), " · ", link(name, "html")))));
      };
      parts.push(el("h2", { textContent: "Save" }), el("p", { className: "faint", textContent: "Every recording of this run; a reset begins another one. The page plays in any browser." }), list, this.row(this.button("Look for recordings", listRecordings)));
      this.listRecordings = listRecordings;
      listRecordings();
    }
    if (live.supervised) {
      const [robotBox, robot] = this.select("robot", ["as it is", ...live.robots]), [wearBox, wear] = this.select("wear", ["as it is", ...live.wears]);
      const [scenarioBox, scenario] = this.select("scenario", ["as it is", ...live.scenarios]), chosen = { robot, wear, scenario };
      const restart = () => this.order("restart", { settings: Object.fromEntries(Object.entries(chosen).filter(([, select]) => select.selectedIndex).map(([name, select]) => [name, select.value])) });
      parts.push(el("h2", { textContent: "Another run" }), robotBox, wearBox, scenarioBox, this.row(this.button("Restart", restart, { title: "ends this run and begins another one" })));
    }
    return parts.length ? parts : [el("p", { className: "faint", textContent: "This page did not begin the run: nothing to save or to restart here." })];
  }

  // Sliders in the table of the joints while the page holds them.
  sliders(on) {
    if (!this.hold) return;
    this.hold.textContent = on ? "Give the joints back" : "Take the joints";
    const { player } = this, run = player.runs[0], [{ moment }] = run.count ? player.actors() : [{}];
    for (const row of $("joints").querySelectorAll("tr[data-joint]")) {
      const [name, low, high] = run.header.joints.find(([joint]) => joint === row.dataset.joint);
      const slider = el("input", { type: "range", min: low, max: high, step: 0.5 });
      slider.setAttribute("aria-label", name);
      slider.value = moment ? run.value(moment.row, run.signal[`angle ${name}`]) : 0;
      slider.addEventListener("input", () => this.order("joints", { angles: { [name]: (Number(slider.value) * Math.PI) / 180 } }));
      row.querySelector(".command").replaceChildren(...(on ? [slider] : []));
    }
  }

  // A gamepad: the left stick walks ahead and sideways, the right one turns, released they stop; buttons 0 to 3 stop, and change gait, torso control and admittance.
  pads() {
    if (this.polling || !this.driving.checked) return;
    const down = new Set(), buttons = ["x", "g", "t", "m"];
    let steered = [0, 0, 0], sent = 0, steeredRobot = "";
    const steer = (velocity) => {
      const { name } = this.player.runs[0].header;
      if (this.socket.readyState !== WebSocket.OPEN) return; // it is sent once there is a connection
      if (name !== steeredRobot && steered.some(Boolean)) this.order("steer", { velocity: (steered = [0, 0, 0]), robot: steeredRobot });
      steeredRobot = name;
      const moves = velocity.some(Boolean), change = Math.max(...velocity.map((x, i) => Math.abs(x - steered[i])));
      if (!change || (moves && (change < 0.02 || performance.now() - sent < DRAG_INTERVAL))) return;
      [steered, sent] = [velocity, performance.now()];
      this.order("steer", { velocity });
    };
    this.polling = setInterval(() => {
      const on = this.driving.checked, pad = on && !document.hidden && [...(navigator.getGamepads?.() ?? [])].find((each) => each?.connected);
      if (!pad) steer([0, 0, 0]);
      if (!on && !steered.some(Boolean)) this.polling = clearInterval(this.polling);
      if (!pad) return;
      const axes = [1, 0, 2].map((i) => -(pad.axes[i] ?? 0)).map((x) => (Math.abs(x) < DEAD_ZONE ? 0 : Math.max(-1, Math.min(1, x))));
      const velocity = axes.map((x, i) => Number((x * PADS.velocity[i].most).toFixed(3)) || 0);
      steer(this.everywhere === false ? [velocity[0], 0, 0] : velocity);
      buttons.forEach((key, i) => {
        const pressed = Boolean(pad.buttons[i]?.pressed);
        if (pressed && !down.has(i)) this.key(key);
        down[pressed ? "add" : "delete"](i);
      });
    }, PAD_INTERVAL);
  }
}
