/** The WebSocket to the server: it reconnects, notices a dead connection and parses messages. */

import type { Request, ServerMessage } from "./protocol.gen";

const MIN_RETRY_MS = 500;
const MAX_RETRY_MS = 8000;
const PING_MS = 5000;
/** A connection without any message for this long, not even a pong, is dead. */
const TIMEOUT_MS = 13000;

export class ReconnectingSocket {
  state: "connecting" | "open" | "closed" = "connecting";
  /** When the connection opened, or was lost; attempts to reconnect do not change it. */
  since_ms = performance.now();
  private socket: WebSocket | null = null;
  private retry_ms = MIN_RETRY_MS;
  private lastMessage_ms = 0;
  private timer = 0;
  private stopped = false;

  constructor(
    private readonly url: string,
    private readonly onMessage: (message: ServerMessage) => void,
    private readonly onState: () => void,
  ) {}

  start(): void {
    this.connect();
    this.timer = window.setInterval(() => this.checkAlive(), PING_MS);
  }

  stop(): void {
    this.stopped = true;
    window.clearInterval(this.timer);
    this.socket?.close();
  }

  /** Send a message; `false` if there is no connection. */
  send(message: Request): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private connect(): void {
    if (this.stopped) return;
    this.setState("connecting");
    const socket = new WebSocket(this.url);
    this.socket = socket;
    this.lastMessage_ms = performance.now();
    socket.onopen = () => {
      this.lastMessage_ms = performance.now();
      this.setState("open");
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (this.socket !== socket) return;
      this.lastMessage_ms = performance.now();
      this.retry_ms = MIN_RETRY_MS;
      const message = parseMessage(event.data);
      if (message) this.onMessage(message);
    };
    socket.onclose = () => {
      if (this.socket === socket) this.connectionLost();
    };
  }

  /** Report the loss at once, and reconnect after a growing delay. */
  private connectionLost(): void {
    this.socket = null;
    this.setState("closed");
    window.setTimeout(() => this.connect(), this.retry_ms);
    this.retry_ms = Math.min(this.retry_ms * 2, MAX_RETRY_MS);
  }

  private checkAlive(): void {
    const socket = this.socket;
    if (!socket) return;
    if (performance.now() - this.lastMessage_ms > TIMEOUT_MS) {
      socket.close();
      this.connectionLost();
    } else this.send({ type: "ping" });
  }

  private setState(state: typeof this.state): void {
    if (state === this.state) return;
    if (state === "open" || this.state === "open") this.since_ms = performance.now();
    this.state = state;
    this.onState();
  }
}

/** The message in what was received, `null` if it is none. */
export function parseMessage(data: unknown): ServerMessage | null {
  if (typeof data !== "string") return null;
  try {
    const message: unknown = JSON.parse(data);
    const typed = typeof message === "object" && message !== null && "type" in message;
    return typed ? (message as ServerMessage) : null;
  } catch {
    return null;
  }
}

/** The socket's address beside the page's, with the token of the page's address. */
export function socketUrl(page: string): string {
  const url = new URL("ws", page);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  const token = new URL(page).searchParams.get("token");
  url.search = token ? `?token=${encodeURIComponent(token)}` : "";
  url.hash = "";
  return url.href;
}
