import { describe, expect, it } from "vitest";

import { parsed, socketUrl } from "../src/link";

describe("the socket", () => {
  it("lies beside the page and takes the token along", () => {
    expect(socketUrl("http://127.0.0.1:8000/")).toBe("ws://127.0.0.1:8000/ws");
    expect(socketUrl("https://ship.example/bridge/index.html?token=a%26b#x")).toBe(
      "wss://ship.example/bridge/ws?token=a%26b",
    );
  });

  it("takes nothing that is not a message", () => {
    for (const bad of ["", "{", "null", "3", "[]", "{}", new ArrayBuffer(3), undefined])
      expect(parsed(bad)).toBeNull();
    expect(parsed('{"type":"pong"}')).toEqual({ type: "pong" });
  });
});
