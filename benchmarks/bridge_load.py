"""How fast frames reach their viewers: 200 targets, a frame a second, 20 viewers, for ten minutes.

    python benchmarks/bridge_load.py [--minutes 10] [--viewers 20] [--targets 200] [--pilot NAME]
        [--rate 5] [--sensor-errors 10,0.5,0.1]

Starts a bridge in a process of its own, plays a random encounter at ×5 (a frame
of 5 s every second) and opens the viewers in this one. Latency is from the
frame's ``sent_utc`` to its last byte being here, on the same clock. Memory is
the server's resident set, read from /proc once in five seconds. With a sum pilot it is
told how long after their frames certified bands come, and with which share of the frames.
``--slow`` adds a viewer who reads nothing.
"""

import argparse
import asyncio
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from datetime import datetime

import numpy as np
from websockets.asyncio.client import connect

_SENT = re.compile(rb'"sent_utc":"([^"]+)"')


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--targets", type=int, default=200)
    parser.add_argument("--pilot", default="paper-attention")
    parser.add_argument("--rate", type=float, default=5.0)
    parser.add_argument(
        "--sensor-errors", default="10,0.5,0.1", help='of the certified bands; "off"'
    )
    parser.add_argument("--slow", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as logs:
        server, url = start(f"random:1:{args.targets}", args.pilot, logs, args.sensor_errors)
        try:
            asyncio.run(measure(server.pid, url, args))
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(timeout=60)


def start(source: str, pilot: str, logs: str, errors: str) -> tuple[subprocess.Popen[str], str]:
    """A bridge in a process of its own, and its address (host:port)."""
    options = ["--pilot", pilot, "--log-dir", logs, "--no-open", "--sensor-errors", errors]
    command = [sys.executable, "-m", "glasshelm", "bridge", source, *options]
    server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert server.stderr is not None
    for line in server.stderr:
        found = re.search(r"http://(\S+?)/", line)
        if found:
            return server, found[1]
    raise SystemExit("the bridge did not start")


async def measure(pid: int, address: str, args: argparse.Namespace) -> None:
    url = f"ws://{address}/ws"
    async with connect(url, max_size=None) as first:
        await heard(first, "frame")  # all programs are compiled by then
        await asyncio.sleep(10)
        if args.sensor_errors != "off" and "sum" in args.pilot:
            await first.send('{"type":"pause"}')
            await heard(first, "band")
            await first.send('{"type":"play"}')
        await first.send(json.dumps({"type": "rate", "rate": args.rate}))
    end = time.monotonic() + 60 * args.minutes
    latencies: list[list[float]] = [[] for _ in range(args.viewers)]
    sizes: list[int] = []
    waits: list[float] = []
    tasks = [asyncio.create_task(view(url, end, found, sizes, waits)) for found in latencies]
    if args.slow:
        tasks.append(asyncio.create_task(sleep_through(url, end)))
    memory = asyncio.create_task(watch_memory(pid, end))
    keep = asyncio.create_task(keep_playing(url, end))
    await asyncio.gather(*tasks, keep)
    rss = await memory
    with urllib.request.urlopen(f"http://{address}/api/health") as answer:
        health = json.load(answer)
    ms = 1000 * np.concatenate([np.asarray(found) for found in latencies])
    counts = [len(found) for found in latencies]
    third = max(len(rss) // 3, 1)
    print(f"machine   {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    print(
        f"frames    {min(counts)} to {max(counts)} a viewer, {np.median(sizes) / 1e3:.0f} kB each"
    )
    p50, p99, worst = np.percentile(ms, [50, 99, 100])
    print(f"latency   p50 {p50:.0f} ms, p99 {p99:.0f} ms, largest {worst:.0f} ms")
    if waits:
        p50, p99, worst = np.percentile(1000 * np.asarray(waits), [50, 99, 100])
        share = len(waits) / sum(counts)
        print(
            f"bands     with {share:.0%} of the frames, after p50 {p50:.0f} ms, p99 {p99:.0f} ms, "
            f"largest {worst:.0f} ms"
        )
    print(f"dropped   {health['dropped_frames']} frames")
    first_third, last_third = np.median(rss[:third]), np.median(rss[-third:])
    print(f"memory    {first_third:.0f} MB in the first third, {last_third:.0f} MB in the last")


async def heard(socket, kind: str) -> bytes:
    async for text in socket:
        if text.startswith(f'{{"type":"{kind}"'):
            return text.encode()
    raise SystemExit("the bridge closed the line")


async def view(
    url: str, end: float, latencies: list[float], sizes: list[int], waits: list[float]
) -> None:
    async with connect(url, max_size=None) as socket:
        await heard(socket, "frame")  # the present one was sent before she came
        told = None
        while time.monotonic() < end:
            try:
                text = await asyncio.wait_for(socket.recv(decode=False), 5)
            except TimeoutError:
                continue
            now = time.time()
            if text.startswith(b'{"type":"frame"'):
                sent = _SENT.search(text)
                assert sent is not None
                told = datetime.fromisoformat(sent[1].decode()).timestamp()
                latencies.append(now - told)
                sizes.append(len(text))
            elif told is not None and text.startswith(b'{"type":"band"') and b'"low_rad"' in text:
                waits.append(now - told)


async def keep_playing(url: str, end: float) -> None:
    """Begin again at the voyage's end."""
    async with connect(url, max_size=None) as socket:
        while time.monotonic() < end:
            try:
                text = await asyncio.wait_for(socket.recv(decode=False), 5)
            except TimeoutError:
                continue
            if text.startswith(b'{"type":"session"') and b'"playing":false' in text:
                await socket.send('{"type":"seek","time_s":0}')
                await socket.send('{"type":"play"}')


async def sleep_through(url: str, end: float) -> None:
    async with connect(url, max_size=None, max_queue=1, ping_interval=None):
        await asyncio.sleep(max(end - time.monotonic(), 0))


async def watch_memory(pid: int, end: float) -> list[float]:
    found = []
    while time.monotonic() < end - 1:
        found.append(resident_mb(pid))
        await asyncio.sleep(5)
    return found


def resident_mb(pid: int) -> float:
    """A process's resident set, from /proc."""
    with open(f"/proc/{pid}/statm") as statm:
        return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


if __name__ == "__main__":
    main()
