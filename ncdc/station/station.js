// Asks for the part of the page that changes once a second; without an answer nothing old is shown.
"use strict";
const PERIOD = 1000, TIMEOUT = 4000;    // milliseconds
const main = document.querySelector("main"), clock = document.getElementById("clock");
let shown = "";
async function update() {
  try {
    const answer = await fetch("state", { signal: AbortSignal.timeout(TIMEOUT) });
    if (!answer.ok) throw new Error(answer.status);
    const text = await answer.text();
    if (text !== shown) main.innerHTML = shown = text;
    document.body.classList.remove("lost");
    clock.textContent = new Date().toLocaleTimeString("en-GB");
  } catch {
    document.body.classList.add("lost");
  }
  setTimeout(update, PERIOD);
}
update();
