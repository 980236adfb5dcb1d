// What the page's library does not have: keys and a gamepad that drive, and a word when the page has ended.
"use strict";

/** Write into a field of the page as a person does: its library hears of it by the event. */
const writeField = (input, text) => {
  Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, text);
  input.dispatchEvent(new Event("input", { bubbles: true }));
};

// Keys and a gamepad press the page's own buttons, as long as the box that allows it is ticked.
(() => {
  const KEYS = { w: "Faster", s: "Slower", a: "Turn left", d: "Turn right", q: "Left", e: "Right", " ": "Stop", x: "Stop", g: "Gait", t: "Torso control", m: "Admittance" };
  const PAD = ["Stop", "Gait", "Torso control", "Admittance"]; // its buttons 0 to 3
  const FORWARDS = 1; // axis of the left stick, up negative
  const PUSHED = 0.5; // of the stick's way
  const AGAIN = 400; // ms from one notch to the next while the stick is held
  const LOOK = 50; // ms

  const allowed = () => document.querySelector(".keys-drive") !== null;
  const typing = (at) => at instanceof HTMLElement && at.matches("input, textarea, select, [contenteditable]");
  const press = (name) =>
    [...document.querySelectorAll("button")].find((button) => button.textContent.trim() === name)?.click();

  // Before the page's own listeners: its camera moves by some of these keys too.
  for (const kind of ["keydown", "keyup"]) {
    window.addEventListener(
      kind,
      (event) => {
        const name = KEYS[event.key];
        if (!name || event.ctrlKey || event.altKey || event.metaKey || !allowed()) return;
        if (typing(event.target) && event.target.type !== "checkbox") return;
        event.preventDefault();
        event.stopImmediatePropagation();
        if (kind === "keydown" && !event.repeat) press(name);
      },
      { capture: true },
    );
  }

  const down = new Set();
  let notch = 0; // when the stick last made one
  setInterval(() => {
    const pad = allowed() && [...(navigator.getGamepads?.() ?? [])].find((each) => each);
    if (!pad) return;
    PAD.forEach((name, i) => {
      const pressed = Boolean(pad.buttons[i]?.pressed);
      if (pressed && !down.has(i)) press(name);
      down[pressed ? "add" : "delete"](i);
    });
    const way = -(pad.axes[FORWARDS] ?? 0);
    if (Math.abs(way) < PUSHED) notch = 0;
    else if (performance.now() - notch > AGAIN) {
      notch = performance.now();
      press(way > 0 ? "Faster" : "Slower");
    }
  }, LOOK);
})();

// With its server gone the library says little.
(() => {
  const WORDS =
    "<b>The page has ended, and the run with it, or its robot's process.</b><br>" +
    "To look at a run again: <code>nao-hil view --replay runs/&lt;time&gt;/frames.mcap</code><br>" +
    "For a robot that stays, to be walked and pushed: <code>nao-hil up --serve --view</code>";
  const STYLE =
    "position:fixed;left:1em;bottom:1em;max-width:32em;padding:1em;z-index:1000;background:#25262b;color:#f8f9fa;" +
    "border-left:4px solid #339af0;font:15px/1.6 Inter,sans-serif";
  const PATIENCE = 1000; // ms

  let missed = 0; // times in a row
  const tell = (ended) => {
    const word = document.getElementById("ended");
    if (!ended) word?.remove();
    else if (!word) {
      document.body.insertAdjacentHTML("beforeend", `<div id="ended" style="${STYLE}">${WORDS}</div>`);
    }
  };
  setInterval(async () => {
    missed = await fetch("alive").then(() => 0, () => missed + 1);
    tell(missed > 1);
  }, PATIENCE);
})();

// Over the picture: what to look at, and after a fall its sentence while the panel's own is scrolled away.
(() => {
  const PLACE = "position:fixed;left:1em;top:1em;max-width:min(28em, calc(100vw - 2em));z-index:900;pointer-events:none";
  const STYLE =
    "margin-bottom:0.5em;padding:0.6em 1em;background:#25262b;color:#f8f9fa;font:600 15px/1.5 Inter,sans-serif;" +
    "border-left:4px solid ";
  const LOOK = 300; // ms

  const inSight = (element) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    return element.contains(document.elementFromPoint(left + width / 2, top + height / 2));
  };
  const show = (id, colour, text) => {
    let word = document.getElementById(id);
    if (!text) return word?.remove();
    if (!document.getElementById("words")) document.body.insertAdjacentHTML("beforeend", `<div id="words" style="${PLACE}"></div>`);
    if (!word) {
      document.getElementById("words").insertAdjacentHTML("beforeend", `<div id="${id}" style="${STYLE}${colour}"></div>`);
      word = document.getElementById(id);
    }
    word.textContent = text;
  };
  setInterval(() => {
    show("caption", "#339af0", document.querySelector(".nao-caption")?.textContent);
    const title = [...document.querySelectorAll("h4")].find((each) => each.textContent.startsWith("It fell"));
    show("fell", "#fa5252", title && !inSight(title) ? title.textContent : "");
  }, LOOK);
})();

// The first rows of the panel and its tabs stay in sight while it is scrolled; on a phone held upright the picture is
// above the panel, not behind it. Charts: lines that mark a time are not in their legend.
(() => {
  const LOOK = 300; // ms
  const HIGH = "52dvh"; // of the picture on a phone
  const STYLE = `.uplot .nao-mark { display: none !important; }
  .uplot-container { contain: inline-size; }
  .uplot .u-title { padding: 0 !important; font-size: 12px !important; }
  @media (max-width: 720px) {
    .nao-picture { height: ${HIGH} !important; width: 100% !important; align-self: flex-start !important; }
    .nao-panel { inset: ${HIGH} 0 0 0 !important; width: 100% !important; height: auto !important; max-height: none !important; margin: 0 !important; border-radius: 0 !important; }
    .nao-panel .nao-wide { width: 100% !important; max-width: none !important; }
    .nao-panel .nao-high { height: 100% !important; max-height: none !important; }
    .nao-panel .nao-title { display: none !important; }
  }`;
  document.head.insertAdjacentHTML("beforeend", `<style>${STYLE}</style>`);

  const pin = (row, top) => {
    Object.assign(row.style, { position: "sticky", top: `${top}px`, zIndex: 50, background: "var(--mantine-color-body)" });
  };
  setInterval(() => {
    const tabs = document.querySelector("[role=tablist]"), canvas = document.querySelector("canvas");
    const panel = tabs?.closest(".mantine-Paper-root"), headline = document.querySelector(".nao-headline");
    if (!panel?.contains(headline) || !canvas) return;
    let picture = canvas;
    while (!picture.parentElement.contains(panel)) picture = picture.parentElement;
    picture.classList.add("nao-picture");
    panel.classList.add("nao-panel");
    let column = tabs.parentElement;
    for (let at = column; at !== panel; at = at.parentElement) {
      if (getComputedStyle(at).overflowY === "hidden") at.style.overflow = "clip"; // hidden would hold the rows
      if (!column.contains(headline)) column = at;
      if (!column.contains(headline)) continue;
      const inside = at.closest(".mantine-ScrollArea-content");
      at.classList.add(inside ? "nao-wide" : "nao-high");
      if (inside && at !== inside && at.parentElement !== inside && at.parentElement.parentElement === inside)
        for (let before = at.previousElementSibling; before; before = before.previousElementSibling) before.classList.add("nao-title");
    }
    const [first, second, ...others] = column.children;
    for (const row of others) row.style.position = ""; // one that was above before the buttons came
    pin(first, 0);
    pin(second, first.offsetHeight);
    pin(tabs, first.offsetHeight + second.offsetHeight);
  }, LOOK);
})();

// Pads: dragging one writes numbers into the field that follows it, and the field says where the knobs are.
(() => {
  const LOOK = 200; // ms
  const AGAIN = 150; // ms between two words of a knob that is dragged
  const REST = 0.08; // share of the way that counts as none

  const field = (pad) =>
    [...document.querySelectorAll("input")].find((i) => pad.compareDocumentPosition(i) & Node.DOCUMENT_POSITION_FOLLOWING);
  const numbers = (input) => input.value.trim().split(/[ ,]+/).map(Number);
  const write = (input, values) => {
    const text = values.map((value) => (Math.abs(value) < 0.005 ? 0 : value).toFixed(2)).join(" ");
    if (text !== input.value) writeField(input, text);
  };
  const place = (pad) => {
    const input = field(pad), most = pad.dataset.most.split(" ").map(Number);
    const [ahead, left, turn] = input ? numbers(input).map((value, i) => Math.max(-1, Math.min(1, value / most[i] || 0))) : [0, 0, 0];
    const knob = (part) => pad.querySelector(`${part} .nao-knob`)?.style;
    Object.assign(knob(".nao-square"), { top: `${50 - 50 * ahead}%`, left: `${50 - 50 * left}%` });
    if (knob(".nao-strip")) knob(".nao-strip").left = `${50 - 50 * turn}%`;
  };
  setInterval(() => document.querySelectorAll(".nao-pad").forEach(place), LOOK);

  let said = 0;
  const drag = (event, last) => {
    const part = event.target.closest?.(".nao-square, .nao-strip"), pad = part?.closest(".nao-pad");
    const input = pad && field(pad);
    if (!input || (!last && !event.buttons)) return;
    event.preventDefault();
    if (event.type === "pointerdown") part.setPointerCapture(event.pointerId);
    const { left, top, width, height } = part.getBoundingClientRect();
    const share = (way) => (Math.abs(way) < REST ? 0 : Math.max(-1, Math.min(1, way)));
    const toLeft = share(1 - (2 * (event.clientX - left)) / width), ahead = share(1 - (2 * (event.clientY - top)) / height);
    const most = pad.dataset.most.split(" ").map(Number), values = numbers(input);
    if (part.matches(".nao-strip")) values[2] = toLeft * most[2];
    else [values[0], values[1]] = [ahead * most[0], toLeft * most[1]];
    if (last || performance.now() - said > AGAIN) {
      said = performance.now();
      write(input, values);
      place(pad);
    }
  };
  for (const kind of ["pointerdown", "pointermove"]) document.addEventListener(kind, (event) => drag(event, false), { capture: true });
  document.addEventListener("pointerup", (event) => drag(event, true), { capture: true });
})();

// A moment of a recording: an address may name it (?t=12.3), and a button copies that address.
(() => {
  const LOOK = 500; // ms
  const SAID = 3000; // ms

  const field = () => {
    const label = [...document.querySelectorAll("label")].find((each) => each.textContent === "time, s");
    const follows = (input) => label.compareDocumentPosition(input) & Node.DOCUMENT_POSITION_FOLLOWING;
    return label && [...document.querySelectorAll("input[inputmode=decimal]")].find(follows);
  };
  const asked = Math.round(100 * parseFloat(new URLSearchParams(location.search).get("t"))) / 100;
  const paused = () => [...document.querySelectorAll("button")].some((button) => button.textContent.trim() === "Play");
  let tries = Number.isFinite(asked) ? 60 : 0;
  const wait = setInterval(() => {
    const input = field();
    // What plays may overwrite the field before it hears of it; once it is paused there, it stays there.
    if (tries === 0 || (input && paused() && parseFloat(input.value) === asked)) return clearInterval(wait);
    if (!input) return;
    tries = Math.min(tries, paused() ? 4 : 60) - 1; // paused elsewhere: no such moment
    writeField(input, asked.toFixed(2));
  }, LOOK);

  document.addEventListener("click", async (event) => {
    const button = event.target.closest?.(".nao-link"), input = button && field();
    if (!input) return;
    const query = new URLSearchParams(location.search), label = button.textContent;
    query.set("t", input.value);
    history.replaceState(null, "", `?${query}`);
    button.disabled = true; // until its label is back
    const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
    button.textContent = copied ? "Copied" : "The link is in the address bar";
    setTimeout(() => Object.assign(button, { textContent: label, disabled: false }), SAID);
  });
})();

// Under a path of a proxy: the library leaves out the slash at the end of its own address, which a proxy needs.
(() => {
  const own = location.href.replace(/^http/, "ws").split(/[?#]/)[0];
  if (location.pathname === "/" || !own.endsWith("/")) return;
  const post = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message, ...rest) {
    const slashed = message?.server === own.slice(0, -1) ? { ...message, server: own } : message;
    return post.call(this, slashed, ...rest);
  };
})();
