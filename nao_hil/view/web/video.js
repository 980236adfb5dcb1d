// The run picture by picture, for a video: the 3-D picture with the charts at its side, encoded by the browser.
"use strict";

const CODEC = "vp09.00.40.08"; // VP9, level 4: up to 1920 x 1080 at 30 pictures a second
const CHART_SHARE = 0.3; // of the breadth, for the charts
const KEY_INTERVAL = 2; // s from one key picture to the next
const EVENT_TIME = 2.5; // s for which an event is shown

class Video {
  constructor(player, { width, height, rate, bits, theme }) {
    Object.assign(this, { player, rate, chunks: [], colours: THEMES[theme], count: 0 });
    player.filmed = true; // the page draws no longer
    player.theme = theme;
    player.following = player.playing = false;
    this.canvas = Object.assign(document.createElement("canvas"), { width, height });
    this.encoder = new VideoEncoder({ output: (chunk) => this.keep(chunk), error: (error) => (this.failed = error) });
    this.encoder.configure({ codec: CODEC, width, height, bitrate: bits, framerate: rate });
  }

  keep(chunk) {
    const bytes = new Uint8Array(chunk.byteLength);
    chunk.copyTo(bytes);
    const text = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
    this.chunks.push([chunk.timestamp, chunk.type === "key", btoa(text)]);
  }

  // Encodes the pictures of these times; gives (time in the video in us, whether it is a key picture, bytes in base64).
  async add(times) {
    for (const time of times) {
      this.paint(time);
      const frame = new VideoFrame(this.canvas, { timestamp: Math.round((1e6 * this.count) / this.rate) });
      this.encoder.encode(frame, { keyFrame: this.count % (KEY_INTERVAL * this.rate) === 0 });
      frame.close();
      this.count += 1;
    }
    await this.encoder.flush();
    if (this.failed) throw this.failed;
    return this.chunks.splice(0);
  }

  paint(time) {
    const { player, colours } = this, { scene, charts } = player, { width, height } = this.canvas;
    const c = this.canvas.getContext("2d"), unit = height / 720, side = Math.round(CHART_SHARE * width);
    player.time = time;
    const actors = player.actors(), [{ run, moment }] = actors;
    Object.assign(scene.canvas, { width: width - side, height });
    scene.draw(actors, { colours, camera: player.view(actors, 1 / this.rate), overlays: player.overlays });
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.fillStyle = colours.page;
    c.fillRect(0, 0, width, height);
    c.drawImage(scene.canvas, 0, 0);
    c.setTransform(unit, 0, 0, unit, 0, 0);
    const line = (text, y, font, colour) => {
      Object.assign(c, { font: `${font} system-ui, sans-serif`, fillStyle: colour, textAlign: "left", textBaseline: "alphabetic" });
      c.fillText(text, 18, y);
    };
    line(run.header.title, 32, "600 20px", colours.text);
    line(run.header.subtitle, 54, "15px", colours.faint);
    line(`${time.toFixed(2)} s  ${moment.phase ?? ""}${Number.isNaN(moment.step) ? "" : ` · step ${moment.step}`}`, 76, "15px", colours.text);
    this.tell(run.header, time, line);
    this.paintCharts(c, charts, side / unit, unit, width - side);
  }

  paintCharts(c, charts, width, unit, left) {
    const { player, colours } = this;
    charts.pointed = null;
    charts.window(player.time);
    let top = 16;
    for (const chart of charts.list) {
      c.setTransform(unit, 0, 0, unit, left, unit * (top + 16));
      const labels = charts.paint(c, chart, width - 8, chart.height, colours);
      Object.assign(c, { font: "600 11px system-ui, sans-serif", fillStyle: colours.text, textAlign: "left", textBaseline: "alphabetic" });
      c.fillText(chart.title, LEFT, -5);
      Object.assign(c, { font: "11px system-ui, sans-serif", textAlign: "right" });
      labels.reduceRight((right, word, i) => ((c.fillStyle = chart.lines[i].colour), c.fillText(word, right, chart.height + 12), right - c.measureText(word).width - 9), width - 8 - RIGHT);
      top += chart.height + 38;
    }
    c.setTransform(unit, 0, 0, unit, left, unit * top);
    charts.paintPhases(c, width - 8, colours);
  }

  // The last event, and after a fall its first symptom.
  tell({ events, fall }, time, line) {
    const happened = events.filter((event) => event.time <= time), last = happened[happened.length - 1];
    if (fall && time >= fall.time && time < (fall.until ?? Infinity)) {
      line(`It fell at ${fall.time.toFixed(2)} s. What went wrong first:`, 668, "600 18px", "#fa5252");
      line(fall.text, 692, "18px", this.colours.text);
    } else if (last && time - last.time < EVENT_TIME) line(last.text, 692, "18px", this.colours.event(last, false));
  }
}
