/** A sound while an alarm shown is not acknowledged, though its picture be old; browsers allow it once the viewer has touched the page. */

import { store } from "./store";

const REPEAT_MS = 1500;

export function startAlarmSound(): void {
  let context: AudioContext | null = null;
  window.addEventListener("pointerdown", () => (context ??= new AudioContext()), { once: true });
  window.addEventListener("keydown", () => (context ??= new AudioContext()), { once: true });
  window.setInterval(() => {
    const open = store.alarms.some((a) => a.state === "unacknowledged");
    if (context && open && store.settings.values.sound) beep(context);
  }, REPEAT_MS);
}

/** Two short tones. */
function beep(context: AudioContext): void {
  [0, 0.18].forEach((after) => {
    const tone = context.createOscillator();
    const loudness = context.createGain();
    const at = context.currentTime + after;
    tone.frequency.value = 880;
    loudness.gain.setValueAtTime(0.0001, at);
    loudness.gain.exponentialRampToValueAtTime(0.12, at + 0.02);
    loudness.gain.exponentialRampToValueAtTime(0.0001, at + 0.14);
    tone.connect(loudness).connect(context.destination);
    tone.start(at);
    tone.stop(at + 0.15);
  });
}
