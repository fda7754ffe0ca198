"""Mangled messages to the bridge's socket: does it live, is each one counted, how fast?

    python benchmarks/bridge_fuzz.py [--count 100000] [--seed 0]

Starts a bridge in a process of its own. Good requests are mangled in three of four cases: bytes
changed, cut off, doubled, values of another type or size, names of files. Prints how many the
server counted, refused and failed to do, and its memory before and after. Exits with 1
if one is not counted, or if the server no longer answers.
"""

import argparse
import asyncio
import json
import random
import signal
import sys
import tempfile
import time
import urllib.request
from typing import Any

from bridge_load import resident_mb, start
from websockets.asyncio.client import connect

GOOD: tuple[dict[str, Any], ...] = (
    {"type": "ping"},
    {"type": "pause"},
    {"type": "rate", "rate": 2.0},
    {"type": "limits", "dcpa_m": 1852.0, "tcpa_s": 600.0},
    {"type": "acknowledge", "id": "cpa-1"},
)
#: Never to be reached from the page.
WORSE: tuple[dict[str, Any], ...] = (
    {"type": "open", "source": "/etc/passwd"},
    {"type": "open", "source": "imazu:1", "pilot": "../weights.safetensors"},
    {"type": "replay", "log": "../../etc/passwd"},
    {"type": "pilot", "name": "os:system"},
    {"type": "compare", "name": "weights.safetensors"},
    {"type": "seek", "time_s": "soon"},
)
#: Messages sent before it is asked whether they were counted.
BURST = 1000
VALUES = (None, True, -1, 1e308, 10**40, "", "é" * 50, [], {}, [[[]]], "\x00", "NaN")


def mangled(rng: random.Random) -> str | bytes:
    """A message, good in one case of four."""
    message = dict(rng.choice(GOOD + WORSE))
    if rng.random() < 0.25:
        return json.dumps(message)
    if rng.random() < 0.5:
        message[rng.choice([*message, "more"])] = rng.choice(VALUES)
        return json.dumps(message)
    data = bytearray(json.dumps(message).encode())
    for _ in range(rng.randint(1, 6)):
        data[rng.randrange(len(data))] = rng.randrange(256)
    if rng.random() < 0.3:
        data = data[: rng.randrange(len(data))]
    if rng.random() < 0.1:
        data *= rng.randint(2, 200)
    if rng.random() < 0.5:
        return bytes(data)
    return data.decode("utf-8", "replace")


async def send(url: str, count: int, seed: int) -> float:
    """Send so many and hear all that comes; in how long the server has counted them [s]."""
    rng = random.Random(seed)
    began, counted = time.monotonic(), health(url)["messages"]
    async with connect(f"ws://{url}/ws", max_size=None) as line:

        async def listen() -> None:
            async for _ in line:
                pass

        listener = asyncio.create_task(listen())
        for first in range(0, count, BURST):
            burst = min(BURST, count - first)
            for _ in range(burst):
                await line.send(mangled(rng))
            # More at once, and the socket's own pings would wait behind them for too long.
            counted += burst
            until = time.monotonic() + 60
            while health(url)["messages"] < counted and time.monotonic() < until:
                await asyncio.sleep(0.05)
        listener.cancel()
    return time.monotonic() - began


def health(url: str) -> dict[str, Any]:
    with urllib.request.urlopen(f"http://{url}/api/health", timeout=30) as answer:
        return json.load(answer)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as logs:
        server, url = start("imazu:5", "straight", logs, "off")
        try:
            asyncio.run(send(url, 1000, args.seed + 1))  # the first ones find their programs
            before, memory = health(url), resident_mb(server.pid)
            took = asyncio.run(send(url, args.count, args.seed))
            after = health(url)
            print(f"{args.count} sent in {took:.0f} s, {args.count / took:.0f} a second")
            for name in ("messages", "refused_messages", "failed_messages"):
                print(f"{name}: {after[name] - before[name]}")
            print(f"memory: {memory:.0f} MB before, {resident_mb(server.pid):.0f} MB after")
            if after["messages"] - before["messages"] != args.count or server.poll() is not None:
                sys.exit("not every message was counted")
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(timeout=60)


if __name__ == "__main__":
    main()
