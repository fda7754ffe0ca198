/**
 * The sound of an unacknowledged alarm, whether or not the picture is live. Browsers allow it
 * only after the user has clicked or pressed a key.
 */

import { store } from "./store";

const REPEAT_MS = 1500;

export function startAlarmSound(): void {
  let context: AudioContext | null = null;
  const allow = (): void => void (context ??= new AudioContext());
  window.addEventListener("pointerdown", allow, { once: true });
  window.addEventListener("keydown", allow, { once: true });
  window.setInterval(() => {
    if (context && store.hasOpenAlarm && store.settings.values.sound) beep(context);
  }, REPEAT_MS);
}

/** Two short tones. */
function beep(context: AudioContext): void {
  for (const delay_s of [0, 0.18]) {
    const tone = context.createOscillator();
    const gain = context.createGain();
    const at = context.currentTime + delay_s;
    tone.frequency.value = 880;
    gain.gain.setValueAtTime(0.0001, at);
    gain.gain.exponentialRampToValueAtTime(0.12, at + 0.02);
    gain.gain.exponentialRampToValueAtTime(0.0001, at + 0.14);
    tone.connect(gain).connect(context.destination);
    tone.start(at);
    tone.stop(at + 0.15);
  }
}
