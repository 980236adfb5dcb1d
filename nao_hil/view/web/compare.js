// Two runs against each other: what differs, and the second's signals less the first's on common time.
"use strict";

const SAME_TIME = 0.05; // s within which two events are one
const DIFFERENCE_HEIGHT = 44; // pixels

// The rows of the first run that the second has too, up to the first fall; a value is the second's less the first's.
class DifferenceRun {
  constructor(first, second) {
    const falls = [first, second].map((run) => run.header.fall?.time ?? Infinity), last = Math.min(first.last, second.last, ...falls);
    this.from = first.time(0) < second.first ? first.row(second.first) + 1 : 0;
    Object.assign(this, { one: first, other: second, signal: first.signal, count: last < second.first ? 0 : Math.max(first.row(last) + 1 - this.from, 0) });
  }

  row(t) {
    return Math.min(Math.max(this.one.row(t) - this.from, 0), Math.max(this.count - 1, 0));
  }

  time(i) {
    return this.one.time(i + this.from);
  }

  value(i, column) {
    const { other } = this, t = this.time(i), k = other.row(t), next = Math.min(k + 1, other.count - 1), gap = other.time(next) - other.time(k);
    const a = other.value(k, column), b = other.value(next, column), share = gap > 0 ? (t - other.time(k)) / gap : 0;
    return (share && !Number.isNaN(b) ? a + share * (b - a) : a) - this.one.value(i + this.from, column);
  }
}

// The tab "Differences": the configuration in force, and the events of one run only.
function differencesTab(player) {
  const [first, second] = player.runs, config = JSON.parse($("differences").textContent), rows = Object.entries(config);
  const words = (value) => (value === null || value?.length === 0 ? "none" : Array.isArray(value) ? value.join(" ") : String(value).split("/").pop()); // of a file its name
  const cells = (tag, ...texts) => el("tr", {}, ...texts.map((textContent) => el(tag, { textContent })));
  const names = player.runs.map((run) => run.header.title);
  const table = el("table", { className: "words" }, cells("th", "configuration in force", ...names), ...rows.map(([name, values]) => cells("td", name, ...values.map(words))));
  const alone = (run, other) => run.header.events.filter((event) => !other.header.events.some(({ time, text }) => text === event.text && Math.abs(time - event.time) <= SAME_TIME)).sort((a, b) => a.time - b.time);
  const list = (run, other) => {
    const items = alone(run, other).map((event) => player.eventRow(event, event.text));
    return [el("h2", { textContent: `Only in ${run.header.title}` }), items.length ? el("ul", { className: "events" }, ...items) : el("p", { className: "faint", textContent: "no event of its own" })];
  };
  const tab = el("section", { className: "tab" }, rows.length ? table : el("p", { textContent: "The configurations are the same." }), ...list(first, second), ...list(second, first));
  tab.dataset.name = "Differences";
  document.querySelector("aside").append(tab);
  player.tabs();
}
