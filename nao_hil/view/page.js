// What the page's library does not have: keys and a gamepad that drive, and a word when the page has ended.
"use strict";

// Keys and a gamepad press the page's own buttons, as long as the box that allows it is ticked.
(() => {
  const KEYS = { w: "Faster", s: "Slower", " ": "Stop", x: "Stop", g: "Gait", t: "Torso control", m: "Admittance" };
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
    missed = await fetch("/alive").then(() => 0, () => missed + 1);
    tell(missed > 1);
  }, PATIENCE);
})();

// After a fall its sentence stays in sight: over the picture, while the panel's own is scrolled away.
(() => {
  const STYLE =
    "position:fixed;left:1em;top:1em;max-width:28em;padding:0.6em 1em;z-index:900;background:#25262b;color:#f8f9fa;" +
    "border-left:4px solid #fa5252;font:600 15px/1.5 Inter,sans-serif;pointer-events:none";
  const LOOK = 300; // ms

  const inSight = (element) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    return element.contains(document.elementFromPoint(left + width / 2, top + height / 2));
  };
  setInterval(() => {
    const title = [...document.querySelectorAll("h4")].find((each) => each.textContent.startsWith("It fell"));
    let word = document.getElementById("fell");
    if (!title || inSight(title)) return word?.remove();
    if (!word) {
      document.body.insertAdjacentHTML("beforeend", `<div id="fell" style="${STYLE}"></div>`);
      word = document.getElementById("fell");
    }
    word.textContent = title.textContent;
  }, LOOK);
})();

// The first rows, Emergency stop and what is below it, stay in sight while the panel is scrolled.
(() => {
  const LOOK = 300; // ms

  const pin = (row, top) => {
    Object.assign(row.style, { position: "sticky", top: `${top}px`, zIndex: 50, background: "var(--mantine-color-body)" });
  };
  setInterval(() => {
    const stop = [...document.querySelectorAll("button")].find((each) => each.textContent === "Emergency stop");
    const row = stop?.parentElement;
    if (!row?.nextElementSibling) return;
    for (let at = row; at && !at.className.includes("ScrollArea-viewport"); at = at.parentElement) {
      if (getComputedStyle(at).overflowY === "hidden") at.style.overflow = "clip"; // hidden would hold them
    }
    pin(row, 0);
    pin(row.nextElementSibling, row.offsetHeight);
  }, LOOK);
})();
