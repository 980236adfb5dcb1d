// The run picture by picture, for a video: the 3-D picture beside the charts, encoded by the browser.
"use strict";

const CODEC = "vp09.00.40.08"; // VP9, level 4: up to 1920 x 1080 at 30 pictures a second
const CHARTS = 0.3; // share of the breadth
const KEY = 2; // s from one key picture to the next
const TOLD = 2.5; // s for which an event is told

class Video {
  constructor(player, { width, height, rate, bits, theme }) {
    Object.assign(this, { player, rate, chunks: [], colours: THEMES[theme], count: 0 });
    player.filmed = true; // nobody else draws
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
      this.encoder.encode(frame, { keyFrame: this.count % (KEY * this.rate) === 0 });
      frame.close();
      this.count += 1;
    }
    await this.encoder.flush();
    if (this.failed) throw this.failed;
    return this.chunks.splice(0);
  }

  paint(time) {
    const { player, colours } = this, { data, scene, charts } = player, { width, height } = this.canvas;
    const c = this.canvas.getContext("2d"), unit = height / 720, side = Math.round(CHARTS * width);
    player.time = time;
    const moment = player.moment(time);
    Object.assign(scene.canvas, { width: width - side, height });
    scene.draw(moment, player.view(moment), colours);
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.fillStyle = colours.page;
    c.fillRect(0, 0, width, height);
    c.drawImage(scene.canvas, 0, 0);
    c.setTransform(unit, 0, 0, unit, 0, 0);
    c.textAlign = "left";
    const line = (text, y, font, colour) => {
      Object.assign(c, { font: `${font} system-ui, sans-serif`, fillStyle: colour });
      c.fillText(text, 18, y);
    };
    line(data.title, 32, "600 20px", colours.text);
    line(data.subtitle, 54, "15px", colours.faint);
    line(`${time.toFixed(2)} s  ${words(moment)}`, 76, "15px", colours.text);
    this.tell(time, line);
    c.setTransform(unit, 0, 0, unit, width - side, 0);
    charts.pointed = null;
    c.translate(0, Math.max(12, 0.5 * (720 - charts.height)));
    charts.paint(c, side / unit - 8, time, colours);
  }

  // The last event, and after a fall what went wrong first.
  tell(time, line) {
    const { data } = this.player, { fall } = data, happened = data.events.filter((event) => event.time <= time);
    const last = happened[happened.length - 1];
    if (fall && time >= fall.time) {
      line(`It fell at ${fall.time.toFixed(2)} s. What went wrong first:`, 668, "600 18px", "#fa5252");
      line(fall.text, 692, "18px", this.colours.text);
    } else if (last && time - last.time < TOLD) line(last.text, 692, "18px", this.colours.event(last, false));
  }
}
