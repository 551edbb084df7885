#!/usr/bin/python3
"""How fast the live viewer is: frames a second, time from an input to the picture that shows it, and what a frame costs
beyond rendering.

    benchmarks/viewer.py --scene FILE [--graph FILE ...] [--size WxH ...] [--seconds 20]
    benchmarks/viewer.py --scene FILE [--graph FILE ...] [--size WxH] --monkey 600 [--seed 1]

A tab over the loopback network that shows each picture at once, as a browser does but for decoding and drawing, turns
the camera now and then. Printed is one row of a table for each graph and size. With --monkey the graphs are looked at
together under random input (viewer_monkey.py) for so many seconds; the exit code is 1 where it found a fault.
"""

import argparse
import asyncio
import json
import statistics
import struct
import sys
import time
from pathlib import Path

import aiohttp
import viewer_monkey
from clone import ROOT

import restirpg
from restirpg.harness import program, render

BETWEEN = 5  # frames from one move to the next


async def measure(url, seconds):
    """(latencies, headers, frames a second)."""
    latencies, headers, sent, number = [], [], {}, 0
    async with aiohttp.ClientSession() as session, session.ws_connect(url + "live", max_msg_size=0) as socket:
        start = None
        async for message in socket:
            if message.type != aiohttp.WSMsgType.BINARY:
                continue
            now = time.perf_counter()
            (length,) = struct.unpack("<I", message.data[:4])
            header = json.loads(message.data[4 : 4 + length])
            await socket.send_json({"do": "shown"})
            if start is None and number < 2 * BETWEEN:  # the first frames compile kernels
                number += 1
                start = now if number == 2 * BETWEEN else None
                continue
            headers.append(header)
            for seen in header["seen"].values():
                if seen in sent:
                    latencies.append(now - sent.pop(seen))
            if len(headers) % BETWEEN == 0:
                number += 1
                sent[number] = time.perf_counter()
                await socket.send_json({"do": "orbit", "x": 0.02, "y": 0.0, "id": number})
            if now - start > seconds and len(latencies) > 2:
                return latencies, headers, len(headers) / (now - start)


def cpu_of(session):
    """CPU time of a picture for the page, ms: that of the one thread that makes it, whatever else the machine does."""
    times = []
    for _ in range(20):
        start = time.thread_time()
        session.frame()
        times.append(1000 * (time.thread_time() - start))
    return statistics.median(times)


def row(graph, size, scene, seconds):
    """A line of the table."""
    with restirpg.view(graph, scene, size) as viewer:
        latencies, headers, rate = asyncio.run(measure(viewer.url, seconds))
        cpu = viewer.rendering.submit(cpu_of, viewer.session).result()
    rendering = statistics.median(header["panes"][0]["milliseconds"] for header in headers)
    showing = statistics.median(header["view_milliseconds"] for header in headers)
    bytes_a_frame = statistics.median(header["sizes"][0] for header in headers)
    latency = statistics.median(latencies) * 1000
    return (
        f"| {Path(graph).stem} | {size[0]}x{size[1]} | {rate:.1f} | {latency:.0f} | {rendering:.1f} | {showing:.1f} | "
        f"{cpu:.1f} | {bytes_a_frame / 1000:.0f} |"
    )


def play(graphs, size, scene, seconds, seed):
    """A monkey at these graphs together. Returns the exit code."""
    with restirpg.view(graphs, scene, size, captures=None) as viewer:
        faults, numbers = viewer_monkey.run(viewer, seconds, seed)
    print(numbers)
    for fault in faults:
        print(f"fault: {fault}")
    return 1 if faults else 0


def parse():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--graph", action="append")
    parser.add_argument("--size", type=program.size, action="append")
    parser.add_argument("--seconds", type=program.positive, help="of a row of the table (20)")
    parser.add_argument("--monkey", type=program.positive, metavar="SECONDS")
    parser.add_argument("--seed", type=program.whole(0), help="of the monkey (1)")
    options = parser.parse_args()
    if options.monkey and options.seconds:
        parser.error("--seconds changes nothing with --monkey, which has seconds of its own; leave it out")
    if options.monkey and len(options.size or ()) > 1:
        parser.error("--monkey looks at one size; give --size once")
    if options.seed is not None and not options.monkey:
        parser.error("--seed is that of --monkey, and changes nothing without it; leave it out")
    return options


def look(arguments):
    """Print the table, or what a monkey has found. Returns the exit code."""
    scene = restirpg.load_scene(arguments.scene)
    graphs = arguments.graph or [str(ROOT / "graphs" / "path_tracer.py"), str(ROOT / "graphs" / "restir_pg.py")]
    if arguments.monkey:
        return play(
            graphs,
            (arguments.size or [(64, 36)])[0],
            scene,
            arguments.monkey,
            1 if arguments.seed is None else arguments.seed,
        )
    print(
        "| graph | size | frames/s | input to picture, ms | rendering, ms | picture and JPEG, ms | of it CPU, ms | kB a frame |"
    )
    print("| --- " * 8 + "|")
    for graph in graphs:
        for size in arguments.size or [(320, 180), (640, 360)]:
            print(row(graph, size, scene, arguments.seconds or 20), flush=True)
    return 0


def main():
    """The command line. Returns the exit code."""
    arguments = parse()

    def body(_):
        render.find_package()
        with render.refusals():
            return look(arguments)

    return program.run("viewer.py", body)


if __name__ == "__main__":
    sys.exit(main())
