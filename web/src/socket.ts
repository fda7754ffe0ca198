/** The WebSocket: reconnects by itself, notices a dead line, hands out parsed messages. */

import type { ClientMessage, ServerMessage } from "./protocol.gen";

type LinkState = "connecting" | "open" | "closed";

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 8000;
const PING_MS = 5000;
/** A line on which nothing, not even a pong, came for so long is dead. */
const SILENCE_MS = 13000;

export class Link {
  state: LinkState = "connecting";
  /** When the line was opened, or lost: an outage goes on while it is tried again [ms]. */
  since_ms = performance.now();
  private socket: WebSocket | null = null;
  private wait_ms = FIRST_WAIT_MS;
  private heard_ms = 0;
  private timer = 0;
  private ended = false;

  constructor(
    private readonly url: string,
    private readonly onMessage: (message: ServerMessage) => void,
    private readonly onState: () => void,
  ) {}

  start(): void {
    this.connect();
    this.timer = window.setInterval(() => this.watch(), PING_MS);
  }

  stop(): void {
    this.ended = true;
    window.clearInterval(this.timer);
    this.socket?.close();
  }

  /** Whether it could be sent. */
  send(message: ClientMessage): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private connect(): void {
    if (this.ended) return;
    this.become("connecting");
    const socket = new WebSocket(this.url);
    this.socket = socket;
    this.heard_ms = performance.now();
    socket.onopen = () => {
      this.heard_ms = performance.now();
      this.become("open");
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (this.socket !== socket) return;
      this.heard_ms = performance.now();
      this.wait_ms = FIRST_WAIT_MS;
      const message = parsed(event.data);
      if (message) this.onMessage(message);
    };
    socket.onclose = () => {
      if (this.socket === socket) this.lose();
    };
  }

  /** The line is gone: say so at once and try again, ever less often. */
  private lose(): void {
    this.socket = null;
    this.become("closed");
    window.setTimeout(() => this.connect(), this.wait_ms);
    this.wait_ms = Math.min(this.wait_ms * 2, LONGEST_WAIT_MS);
  }

  private watch(): void {
    const socket = this.socket;
    if (!socket) return;
    if (performance.now() - this.heard_ms > SILENCE_MS) {
      socket.close();
      this.lose();
    } else this.send({ type: "ping" });
  }

  private become(state: LinkState): void {
    if (state === this.state) return;
    if (state === "open" || this.state === "open") this.since_ms = performance.now();
    this.state = state;
    this.onState();
  }
}

/** What the server sent, if it is one of its messages. */
export function parsed(data: unknown): ServerMessage | null {
  if (typeof data !== "string") return null;
  try {
    const message: unknown = JSON.parse(data);
    const known = typeof message === "object" && message !== null && "type" in message;
    return known ? (message as ServerMessage) : null;
  } catch {
    return null;
  }
}

/** The socket beside this page; a token in the page's address goes with it. */
export function socketUrl(page: string): string {
  const url = new URL("ws", page);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  const token = new URL(page).searchParams.get("token");
  url.search = token ? `?token=${encodeURIComponent(token)}` : "";
  url.hash = "";
  return url.href;
}
