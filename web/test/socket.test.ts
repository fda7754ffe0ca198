import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { parseMessage, ReconnectingSocket, socketUrl } from "../src/socket";

describe("the socket", () => {
  it("has its address beside the page, with the token", () => {
    expect(socketUrl("http://127.0.0.1:8000/")).toBe("ws://127.0.0.1:8000/ws");
    expect(socketUrl("https://ship.example/bridge/index.html?token=a%26b#x")).toBe(
      "wss://ship.example/bridge/ws?token=a%26b",
    );
  });

  it("ignores what is not a message", () => {
    for (const bad of ["", "{", "null", "3", "[]", "{}", new ArrayBuffer(3), undefined])
      expect(parseMessage(bad)).toBeNull();
    expect(parseMessage('{"type":"pong"}')).toEqual({ type: "pong" });
  });
});

describe("an outage", () => {
  class Socket {
    static readonly OPEN = 1;
    static last: Socket;
    readyState = 0;
    onopen = vi.fn();
    onclose = vi.fn();
    onmessage = vi.fn();
    constructor() {
      Socket.last = this;
    }
    close = vi.fn();
    send = vi.fn();
  }

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("WebSocket", Socket);
    vi.stubGlobal("window", globalThis);
  });

  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it("lasts from the loss of the connection until it is open again, through all attempts", () => {
    const connection = new ReconnectingSocket("ws://ship/ws", vi.fn(), vi.fn());
    connection.start();
    Socket.last.onopen();
    vi.advanceTimersByTime(1000);
    Socket.last.onclose();
    const lost_ms = performance.now();
    for (let n = 0; n < 6; n++) {
      const refused = Socket.last;
      while (Socket.last === refused) vi.advanceTimersByTime(100);
      Socket.last.onclose();
      expect(connection.since_ms).toBe(lost_ms);
    }
    vi.advanceTimersByTime(10_000);
    Socket.last.onopen();
    expect(connection.since_ms).toBe(performance.now());
    connection.stop();
  });
});
