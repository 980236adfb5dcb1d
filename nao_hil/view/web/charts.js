// Strip charts around a moment: what is pointed at is read out, a click goes there, the wheel zooms.
"use strict";

const LEFT = 34, RIGHT = 8, TITLE = 17, BELOW = 6, PHASE = 14, SECONDS = 18; // pixels
const AHEAD = 0.3; // share of what is shown that comes after the moment
const BREAK = 5; // multiple of the usual time between two moments from which on a curve ends

class Charts {
  constructor(canvas, data, seek) {
    this.canvas = canvas;
    this.data = data;
    this.span = Math.min(10, Math.max(2, data.duration));
    this.pointed = null;
    const time = (event) => {
      const box = canvas.getBoundingClientRect();
      return this.begin + ((event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT)) * this.span;
    };
    canvas.addEventListener("pointermove", (event) => {
      this.pointed = time(event);
      if (event.buttons) seek(this.pointed);
    });
    canvas.addEventListener("pointerdown", (event) => seek(time(event)));
    canvas.addEventListener("pointerleave", () => (this.pointed = null));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.span = Math.min(Math.max(this.span * Math.exp(0.002 * event.deltaY), 1), Math.max(data.duration, 2));
    }, { passive: false });
  }

  get height() {
    return this.data.charts.reduce((sum, chart) => sum + TITLE + 1.35 * chart.height + BELOW, 0) + TITLE + PHASE + SECONDS;
  }

  draw(now, colours) {
    const { canvas } = this, scale = devicePixelRatio, c = canvas.getContext("2d");
    const width = canvas.clientWidth;
    canvas.style.height = `${this.height}px`;
    const [w, h] = [Math.round(width * scale), Math.round(this.height * scale)];
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, width, this.height);
    this.paint(c, width, now, colours);
  }

  paint(c, width, now, colours) {
    this.begin = now - (1 - AHEAD) * this.span;
    this.x = (time) => LEFT + ((time - this.begin) / this.span) * (width - LEFT - RIGHT);
    c.font = "11px system-ui, sans-serif";
    const read = this.pointed ?? now;
    let top = 0, column = 0;
    for (const chart of this.data.charts) {
      this.chart(c, chart, column, top, width, read, colours);
      column += chart.lines.length;
      top += TITLE + 1.35 * chart.height + BELOW;
    }
    this.phases(c, top, width, read, colours);
    top += TITLE + PHASE;
    this.marks(c, top, colours);
    this.rule(c, now, top, colours.text, 1);
    if (this.pointed !== null) this.rule(c, this.pointed, top, colours.faint, 1);
    c.fillStyle = colours.faint;
    c.textAlign = "center";
    const step = [0.2, 0.5, 1, 2, 5, 10, 20, 60].find((s) => (s / this.span) * width > 44) ?? 120;
    for (let t = Math.max(0, Math.ceil(this.begin / step) * step); t <= this.begin + this.span; t += step)
      c.fillText(`${+t.toFixed(1)} s`, Math.min(this.x(t), width - 16), top + 13);
  }

  chart(c, chart, first, top, width, read, colours) {
    const { curves, time } = this.data.tables, height = 1.35 * chart.height, y0 = top + TITLE;
    const from = this.data.row(this.begin), to = this.data.row(this.begin + this.span);
    const columns = chart.lines.map((_, i) => first + i);
    let [low, high] = chart.least;
    const step = 0.5 * (high - low); // the range grows by this
    for (const column of columns)
      for (let i = from; i <= to; i++) {
        const value = curves.at(i, column);
        if (value < low) low -= step * Math.ceil((low - value) / step);
        if (value > high) high += step * Math.ceil((value - high) / step);
      }
    low = Math.max(low, chart.most[0] ?? low);
    high = Math.min(high, chart.most[1] ?? high);
    const y = (value) => y0 + ((high - Math.min(Math.max(value, low), high)) / (high - low)) * height;
    c.fillStyle = colours.field;
    c.fillRect(LEFT, y0, width - LEFT - RIGHT, height);
    c.fillStyle = colours.faint;
    c.textAlign = "right";
    for (const value of new Set([low, 0, high]))
      if (value >= low && value <= high) {
        c.fillText(value.toFixed(0), LEFT - 4, y(value) + 4);
        c.fillRect(LEFT, y(value), width - LEFT - RIGHT, value ? 0 : 0.6);
      }
    c.save();
    c.beginPath();
    c.rect(LEFT, y0, width - LEFT - RIGHT, height);
    c.clip();
    c.lineWidth = 1.3;
    let right = width - RIGHT;
    const at = this.data.row(read), words = [], far = BREAK * (time.at(1, 0) - time.at(0, 0));
    chart.lines.forEach((line, i) => {
      c.strokeStyle = line.colour;
      c.beginPath();
      let down = false;
      for (let k = from; k <= to; k++) {
        const value = curves.at(k, columns[i]);
        if (!Number.isNaN(value)) c[down ? "lineTo" : "moveTo"](this.x(time.at(k, 0)), y(value));
        down = !Number.isNaN(value) && (k === to || time.at(k + 1, 0) - time.at(k, 0) < far);
      }
      c.stroke();
      const value = curves.at(at, columns[i]);
      words.push([line.colour, Number.isNaN(value) ? line.name : `${line.name} ${value.toFixed(Math.abs(value) < 9.95 ? 1 : 0)}`]);
    });
    c.restore();
    for (const [colour, word] of words.reverse()) {
      c.fillStyle = colour;
      c.fillText(word, right, top + 13);
      right -= c.measureText(word).width + 9;
    }
    c.textAlign = "left";
    c.fillStyle = colours.text;
    c.fillText(chart.title, LEFT, top + 13);
  }

  phases(c, top, width, read, colours) {
    const { phase, time } = this.data.tables, { phases } = this.data;
    const name = (i) => phases[phase.at(i, 0)];
    c.textAlign = "left";
    c.fillStyle = colours.text;
    c.fillText(`phase  ${name(this.data.row(read))?.name ?? ""}`, LEFT, top + 13);
    const to = this.data.row(this.begin + this.span);
    for (let i = this.data.row(this.begin), start = i; i <= to; i++) {
      if (i < to && name(i + 1) === name(start)) continue;
      const here = name(start), x0 = Math.max(this.x(time.at(start, 0)), LEFT);
      const x1 = Math.min(this.x(time.at(Math.min(i + 1, to), 0)), width - RIGHT);
      if (here) {
        c.fillStyle = here.colour;
        c.fillRect(x0, top + TITLE, Math.max(x1 - x0, 0.5), PHASE);
        c.fillStyle = "#f8f9fa";
        c.textAlign = "center";
        if (x1 - x0 > c.measureText(here.name).width + 3) c.fillText(here.name, 0.5 * (x0 + x1), top + TITLE + 11);
      }
      start = i + 1;
    }
  }

  marks(c, bottom, colours) {
    for (const event of this.data.events) {
      const first = this.data.fall && event.time === this.data.fall.first && event.kind !== "world";
      c.setLineDash(first ? [] : [3, 3]);
      this.rule(c, event.time, bottom, colours.event(event, first), first ? 2 : 1);
    }
    c.setLineDash([]);
  }

  rule(c, time, bottom, colour, width) {
    const x = this.x(time);
    if (x < LEFT || time > this.begin + this.span) return;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.beginPath();
    c.moveTo(x, TITLE);
    c.lineTo(x, bottom);
    c.stroke();
  }
}
