// Strip charts around a moment: pointing reads values, a click jumps there, the wheel zooms, any signal can be added.
"use strict";

const LEFT = 36, RIGHT = 6, PHASE_HEIGHT = 16, SCALE_HEIGHT = 18; // pixels
const TEXT_HEIGHT = 11; // pixels
const AHEAD_SHARE = 0.3; // share of the window after the moment, in a replay
const MAX_GAP = 0.3; // s between two rows from which on a curve ends
const ADDED_COLOURS = ["#339af0", "#ff922b", "#40c057", "#cc5de8"];

class Charts {
  constructor(player) {
    this.player = player;
    this.span = 10;
    this.pointed = null;
    this.list = [];
    $("add").addEventListener("change", () => {
      if ($("add").value) this.toggle($("add").value);
      $("add").value = "";
    });
  }

  // New runs: their own charts, and the added ones.
  begin() {
    const { header } = this.player.runs[0], added = this.list.filter((chart) => chart.added);
    const known = (chart) => chart.lines.every((line) => line.signal in this.player.runs[0].signal);
    this.list = [...header.charts.filter((chart) => header.live || chart.lines[0].signal !== "cycle late"), ...added.filter(known)];
    const option = (name) => Object.assign(document.createElement("option"), { value: name, textContent: name });
    const groups = { "whole robot": [], angle: [], command: [], current: [], temperature: [] };
    for (const [name] of header.signals) (groups[name.split(" ")[0]] ?? groups["whole robot"]).push(option(name));
    const make = (label, options) => {
      const group = Object.assign(document.createElement("optgroup"), { label });
      group.append(...options);
      return group;
    };
    $("add").replaceChildren($("add").options[0], ...Object.entries(groups).map(([label, options]) => make(label, options)));
    this.build();
  }

  // Add a chart of a signal, or take it away.
  toggle(...signals) {
    const title = signals.join(", "), { header } = this.player.runs[0];
    if (this.list.some((chart) => chart.title === title)) this.list = this.list.filter((chart) => chart.title !== title);
    else {
      const unit = header.signals.find(([name]) => name === signals[0])[1];
      const lines = signals.map((signal, i) => ({ signal, name: signals.length > 1 ? signal.split(" ")[0] : unit, colour: ADDED_COLOURS[i] }));
      this.list.push({ title, lines, least: null, most: [null, null], height: 70, added: true });
    }
    this.build();
  }

  build() {
    const boxes = this.list.map((chart) => {
      const box = document.createElement("div"), head = document.createElement("div"), title = document.createElement("b");
      box.className = "chart";
      title.textContent = chart.title;
      chart.labels = chart.lines.map((line) => Object.assign(document.createElement("span"), { style: `color: ${line.colour}` }));
      head.append(title, ...chart.labels);
      const close = Object.assign(document.createElement("button"), { className: "close", textContent: "×", title: "close this chart" });
      close.addEventListener("click", () => ((this.list = this.list.filter((each) => each !== chart)), this.build()));
      head.append(close);
      chart.canvas = this.listen(document.createElement("canvas"));
      box.append(head, chart.canvas);
      box.classList.toggle("two", this.player.runs.length > 1);
      if (this.player.difference) {
        chart.differences = chart.lines.map((line) => Object.assign(document.createElement("span"), { style: `color: ${line.colour}` }));
        const less = Object.assign(document.createElement("div"), { className: "less", textContent: "second less first" });
        less.append(...chart.differences);
        chart.differenceCanvas = this.listen(document.createElement("canvas"));
        box.append(less, chart.differenceCanvas);
      }
      return box;
    });
    const phases = document.createElement("div"), head = document.createElement("div"), title = document.createElement("b");
    phases.className = "chart";
    title.textContent = "phase of the walk";
    this.phaseWord = document.createElement("span");
    head.append(title, this.phaseWord);
    this.phaseCanvas = this.listen(document.createElement("canvas"));
    phases.append(head, this.phaseCanvas);
    $("charts").replaceChildren(...boxes, phases);
  }

  listen(canvas) {
    const time = (event) => {
      const box = canvas.getBoundingClientRect();
      return this.start + ((event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT)) * this.span;
    };
    canvas.addEventListener("pointermove", (event) => {
      this.pointed = time(event);
      if (event.buttons) this.player.goTo(this.pointed);
    });
    canvas.addEventListener("pointerdown", (event) => this.player.goTo(time(event)));
    canvas.addEventListener("pointerleave", () => (this.pointed = null));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const longest = Math.max(this.player.last - this.player.first, 2);
      this.span = Math.min(Math.max(this.span * Math.exp(0.002 * event.deltaY), 1), longest);
    }, { passive: false });
    return canvas;
  }

  window(now) {
    this.start = now - (this.player.following ? 1 : 1 - AHEAD_SHARE) * this.span;
    this.now = now;
    this.read = this.pointed ?? now;
  }

  draw(now, colours) {
    if (!$("charts").offsetParent) return;
    this.window(now);
    const { software } = this.player.scene;
    for (const chart of this.list) {
      const labels = this.paint(fit(chart.canvas, chart.height, software), chart, chart.canvas.clientWidth, chart.height, colours);
      labels.forEach((word, i) => (chart.labels[i].textContent = word));
      const { difference } = this.player;
      if (!difference) continue;
      const less = this.paint(fit(chart.differenceCanvas, DIFFERENCE_HEIGHT, software), { ...chart, least: null, most: [null, null] }, chart.canvas.clientWidth, DIFFERENCE_HEIGHT, colours, [difference]);
      less.forEach((word, i) => (chart.differences[i].textContent = word));
    }
    const height = PHASE_HEIGHT * this.player.runs.length + SCALE_HEIGHT;
    this.phaseWord.textContent = this.paintPhases(fit(this.phaseCanvas, height, software), this.phaseCanvas.clientWidth, colours) ?? "";
  }

  // One chart at the origin of a canvas; returns its values at the moment that is read.
  paint(c, chart, width, height, colours, runs = this.player.runs) {
    const right = width - RIGHT, x = (time) => LEFT + ((time - this.start) / this.span) * (right - LEFT);
    this.x = x;
    const [low, high] = this.range(chart, runs);
    const y = (value) => ((high - Math.min(Math.max(value, low), high)) / (high - low)) * height;
    c.fillStyle = colours.field;
    c.fillRect(LEFT, 0, right - LEFT, height);
    Object.assign(c, { font: "11px system-ui, sans-serif", textAlign: "right", textBaseline: "middle", fillStyle: colours.faint });
    for (const value of new Set([low, high, low < 0 && high > 0 ? 0 : low])) {
      const at = Math.min(Math.max(y(value), 6), height - 6), apart = Math.min(at - 6, height - 6 - at);
      if (value === low || value === high || apart > TEXT_HEIGHT) c.fillText(short(value), LEFT - 5, at);
      if (value === 0) c.fillRect(LEFT, y(0), right - LEFT, 0.7);
    }
    c.save();
    c.beginPath();
    c.rect(LEFT, 0, right - LEFT, height);
    c.clip();
    const labels = chart.lines.map((line) => `${line.name}`);
    runs.forEach((run, number) => {
      const from = run.row(this.start), to = run.row(this.start + this.span);
      c.setLineDash(number ? [5, 3] : []);
      chart.lines.forEach((line, i) => {
        const column = run.signal[line.signal];
        Object.assign(c, { strokeStyle: line.colour, lineWidth: 1.4, globalAlpha: number ? 0.8 : 1 });
        c.beginPath();
        let down = false;
        for (let k = from; k <= to && run.count; k++) {
          const value = run.value(k, column), time = run.time(k);
          if (!Number.isNaN(value)) c[down ? "lineTo" : "moveTo"](x(time), y(value));
          down = !Number.isNaN(value) && (k === to || run.time(k + 1) - time < MAX_GAP);
        }
        c.stroke();
        const value = run.count ? run.value(run.row(this.read), column) : NaN;
        if (!Number.isNaN(value)) labels[i] += ` ${number ? "/ " : ""}${short(value)}`;
      });
    });
    Object.assign(c, { globalAlpha: 1 });
    this.rules(c, height, colours);
    c.restore();
    return labels;
  }

  range(chart, runs) {
    const automatic = chart.least === null;
    let [low, high] = automatic ? [Infinity, -Infinity] : chart.least;
    const step = automatic ? 0 : 0.5 * (high - low); // the range grows by this
    for (const run of runs) {
      const from = run.row(this.start), to = run.row(this.start + this.span);
      for (const line of chart.lines)
        for (let i = from, column = run.signal[line.signal]; i <= to && run.count; i++) {
          const value = run.value(i, column);
          if (value < low) low = automatic ? value : low - step * Math.ceil((low - value) / step);
          if (value > high) high = automatic ? value : high + step * Math.ceil((value - high) / step);
        }
    }
    if (automatic) {
      if (!(low <= high)) return [0, 1];
      const pad = Math.max(0.08 * (high - low), 0.05);
      return [low - pad, high + pad];
    }
    return [Math.max(low, chart.most[0] ?? low), Math.min(high, chart.most[1] ?? high)];
  }

  paintPhases(c, width, colours) {
    const right = width - RIGHT, { runs } = this.player;
    Object.assign(c, { font: "11px system-ui, sans-serif", textBaseline: "middle" });
    runs.forEach((run, number) => this.phaseBar(c, run, number * PHASE_HEIGHT, right));
    const height = PHASE_HEIGHT * runs.length;
    this.rules(c, height, colours);
    Object.assign(c, { fillStyle: colours.faint, textAlign: "center" });
    const step = [0.2, 0.5, 1, 2, 5, 10, 20, 60].find((s) => (s / this.span) * width > 44) ?? 120;
    for (let t = Math.max(0, Math.ceil(this.start / step) * step); t <= this.start + this.span; t += step)
      c.fillText(`${+t.toFixed(1)} s`, Math.min(Math.max(this.x(t), 14), width - 18), height + 10);
    const run = runs[0];
    return run.count ? run.phase(run.row(this.read))?.name : "";
  }

  phaseBar(c, run, top, right) {
    const to = run.row(this.start + this.span);
    for (let i = run.row(this.start), from = i; i <= to && run.count; i++) {
      if (i < to && run.phase(i + 1) === run.phase(from)) continue;
      const here = run.phase(from), x0 = Math.max(this.x(run.time(from)), LEFT), x1 = Math.min(this.x(run.time(Math.min(i + 1, to))), right);
      if (here) {
        c.fillStyle = here.colour;
        c.fillRect(x0, top, Math.max(x1 - x0, 0.5), PHASE_HEIGHT - 2);
        Object.assign(c, { fillStyle: "#f8f9fa", textAlign: "center" });
        if (x1 - x0 > c.measureText(here.name).width + 3) c.fillText(here.name, 0.5 * (x0 + x1), top + 7.5);
      }
      from = i + 1;
    }
  }

  // Vertical lines: events, the moment shown, the moment pointed at.
  rules(c, height, colours) {
    const rule = (time, colour, wide, dash = []) => {
      const x = this.x(time);
      if (x < LEFT || time > this.start + this.span) return;
      c.setLineDash(dash);
      Object.assign(c, { strokeStyle: colour, lineWidth: wide });
      c.beginPath();
      c.moveTo(x, 0);
      c.lineTo(x, height);
      c.stroke();
    };
    for (const { header } of this.player.runs)
      for (const event of header.events) {
        const first = isFirst(event, header.fall);
        rule(event.time, colours.event(event, first), first ? 2 : 1, first ? [] : [3, 3]);
      }
    if (!this.player.following) rule(this.now, colours.text, 1);
    if (this.pointed !== null) rule(this.pointed, colours.faint, 1);
    c.setLineDash([]);
  }
}

function isFirst(event, fall) {
  return Boolean(fall) && event.time === fall.first;
}

// The context of a canvas as sharp as the screen, `height` pixels high. Without a graphics card `software` keeps the
// canvas out of WebGL's emulation, in which a chart takes as long as the robot.
function fit(canvas, height, software) {
  const scale = devicePixelRatio, [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(height * scale)];
  canvas.style.height = `${height}px`;
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
  const c = canvas.getContext("2d", { willReadFrequently: software });
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.clearRect(0, 0, canvas.clientWidth, height);
  return c;
}

function short(value) {
  return value.toFixed(Math.abs(value) < 9.95 && !Number.isInteger(value) ? 1 : 0);
}
