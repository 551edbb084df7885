"""A seeded monkey at the live viewer: random input over its WebSocket, right, wrong and absurd; it fails where the queue
of commands grows, memory grows, a client ends, or an exception is not a refusal. `benchmarks/viewer.py --monkey SECONDS` runs it."""

import asyncio
import os
import random
import re
import statistics
import time
from pathlib import Path

import aiohttp

VALUES = [
    0,
    1,
    -1,
    2,
    0.5,
    1e30,
    "x",
    None,
    True,
    False,
    [],
    {},
    -7,
    "paths.bounces",
    "gbuffer.depth",
    "image",
    "error",
    "traced",
    "none",
]
KEYS = {"orbit": "xy", "look": "xy", "pan": "xy", "fly": "xyz", "dolly": ["amount"], "zoom": ["factor"], "fov": ["yfov"], "focus": "xy",
        "pose": ["position", "target", "up", "yfov"], "home": "", "camera": ["number"], "play": ["on"], "step": "", "restart": "",
        "keep": ["on"], "exposure": ["stops"], "view": ["name", "left", "right"], "set": ["pane", "knob", "value"], "reset": ["pane"],
        "show": ["pane", "port"], "seed": ["value"], "time": ["seconds"], "speed": ["factor"], "reference": ["source"],
        "film": ["frames", "kind"], "inspect": "xy", "visible": ["on"], "shown": "", "nothing": "a"}  # fmt: skip
TAME = [
    {"do": "visible", "on": True},
    {"do": "shown"},
    {"do": "home"},
    {"do": "keep", "on": False},
    {"do": "reset", "pane": 0},
    {"do": "exposure", "stops": 0},
    {"do": "view", "name": "image"},
    {"do": "reference", "source": "none"},
    {"do": "film", "frames": 0, "kind": "png"},
    {"do": "show", "pane": 0, "port": None},
    {"do": "speed", "factor": 0},
    {"do": "time", "seconds": 0},
    {"do": "play", "on": True},
    {"do": "seed", "value": 0, "id": 12345},
]
BETWEEN = 0.02  # s from one message to the next
UNEXPECTED = re.compile(
    r"^[A-Z]\w*(Error|Exception|Exit|Warning): "
)  # how the viewer tells an exception that is no refusal
GROWTH = 1.1  # of memory and queue from the second quarter to the last, with which a run still passes
MEMORY, COMMANDS = 64, 10  # MB and commands, besides


def message(dice):
    """A random message of a page."""
    name = dice.choice(list(KEYS))
    return {"do": name, "id": 1, **{key: dice.choice(VALUES) for key in KEYS[name] if dice.random() < 0.95}}


def resident():
    """Memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


async def _read(socket, faults, seen):
    """Show what comes; note errors that are no refusals."""
    async for arrived in socket:
        if arrived.type == aiohttp.WSMsgType.BINARY:
            seen["pictures"] += 1
            await socket.send_json({"do": "shown"})
        elif arrived.type == aiohttp.WSMsgType.TEXT and (error := arrived.json().get("error")):
            seen["refusals"] += 1
            if UNEXPECTED.match(error):
                faults.append(f"an exception: {error}")


async def _watch_now_and_then(session, url, dice):
    """A second tab that comes, shows nothing, and goes."""
    while True:
        async with session.ws_connect(url + "live", max_msg_size=0) as socket:
            await asyncio.sleep(dice.random())
            await socket.receive()
        await asyncio.sleep(dice.random())


async def _play(viewer, seconds, seed):
    faults, memory, queues, seen = [], [], [], {"messages": 0, "pictures": 0, "refusals": 0}
    dice, start, noted = random.Random(seed), time.monotonic(), 0.0
    async with aiohttp.ClientSession() as session, session.ws_connect(viewer.url + "live", max_msg_size=0) as socket:
        tasks = [
            asyncio.ensure_future(_read(socket, faults, seen)),
            asyncio.ensure_future(_watch_now_and_then(session, viewer.url, random.Random(seed + 1))),
        ]
        while (passed := time.monotonic() - start) < seconds or not memory:
            await socket.send_json(message(dice))
            seen["messages"] += 1
            if passed - noted > 1:
                noted = passed
                for calm in TAME:  # now and then it renders as it does for a user
                    await socket.send_json(calm)
                memory.append(resident())
                queues.append(viewer.rendering.waiting())
            await asyncio.sleep(BETWEEN)
        for calm in TAME:
            await socket.send_json(calm)
        pictures, deadline = seen["pictures"], time.monotonic() + 60
        while seen["pictures"] < pictures + 3 and time.monotonic() < deadline:
            await asyncio.sleep(0.1)
        if seen["pictures"] < pictures + 3:
            faults.append("no more pictures come")
        for task in tasks:
            task.cancel()
        ends = await asyncio.gather(*tasks, return_exceptions=True)
        faults += [f"a client ended: {type(end).__name__}: {end}" for end in ends if isinstance(end, Exception)]
    return faults, memory, queues, seen


def early_and_late(values):
    """Medians of the second and of the last quarter of what was noted now and then."""
    quarter = max(1, len(values) // 4)
    return statistics.median(values[quarter : 2 * quarter] or values), statistics.median(values[-quarter:])


def growths(memory, queues):
    """What has grown, a sentence each. memory, MB, and queues, commands: at least one number each."""
    found = []
    for name, values, unit, allowance in (
        ("memory", memory, "MB", MEMORY),
        ("the queue", queues, "commands", COMMANDS),
    ):
        early, late = early_and_late(values)
        if late > GROWTH * early + allowance:
            found.append(f"{name} has grown from {early:.0f} to {late:.0f} {unit}")
    return found


def run(viewer, seconds, seed):
    """(faults: a list of sentences, a line of numbers) of a monkey at a running viewer."""
    faults, memory, queues, seen = asyncio.run(_play(viewer, seconds, seed))
    faults += growths(memory, queues)
    early, late = early_and_late(memory)
    if (left := viewer.rendering.waiting()) > COMMANDS:
        faults.append(f"{left} commands still wait")
    if not viewer.rendering.is_alive():
        faults.append("the render thread has ended")
    told = ", ".join(f"{count} {name}" for name, count in seen.items())
    return faults, (
        f"{seconds:.0f} s, seed {seed}: {told}; memory {early:.0f} MB in the second quarter, {late:.0f} MB in the last; "
        f"commands waiting: at most {max(queues, default=0)}, {left} at the end"
    )
