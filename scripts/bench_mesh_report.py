#!/usr/bin/env python3
"""Tables of scripts/bench_mesh.sh: bench_mesh_report.py FOLDER reads the --stats lines it wrote."""
import json
import statistics
import sys
from pathlib import Path

folder = Path(sys.argv[1])


def frames(name):
    with open(folder / f"{name}.jsonl", encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def period(name):
    """Median seconds from frame to frame, without each run's first ones, which fill the pipe."""
    return statistics.median(frame["period"] for frame in frames(name) if frame["frame"] >= 2)


def median(name, count):
    return statistics.median(count(frame) for frame in frames(name))


print("| mesh | ranks | ring | mesh, direct | mesh, manhattan | messages a frame | over links | MiB a frame | over links |")
print("|---|---|---|---|---|---|---|---|---|")
for shape in ["2x2+4", "3x3+3", "4x4+4", "4x4+8"]:
    mesh = f"frame-{shape}-manhattan"
    times = [f"{1e3 * period(f'frame-{shape}-{way}'):.1f} ms" for way in ["ring", "direct", "manhattan"]]
    # A payload is answered with an accept; besides there are tokens, frame ends, tiles and reports.
    sent = median(mesh, lambda f: 2 * f["total"]["payloads_sent"] + f["total"]["tokens_passed"] + f["total"]["tokens_retired"]
                  + f["total"]["tiles"] + len(f["nodes"]))
    carried = median(mesh, lambda f: f["links_total"]["messages"])
    payload = median(mesh, lambda f: f["total"]["payload_bytes_sent"]) / 2**20
    over = median(mesh, lambda f: f["links_total"]["payload_bytes"]) / 2**20
    ranks = frames(mesh)[0]["layout"]["ranks"]
    print(f"| {shape} | {ranks} | {' | '.join(times)} | {sent:.0f} | {carried:.0f} | {payload:.1f} | {over:.1f} |")

print("\n| mesh, 2048 empty slices | direct | manhattan | tokens | messages over links | one more hop costs |")
print("|---|---|---|---|---|---|")
for mesh in ["2x2", "3x3", "4x4"]:
    direct, manhattan = period(f"hop-{mesh}-direct"), period(f"hop-{mesh}-manhattan")
    tokens = median(f"hop-{mesh}-manhattan", lambda f: f["total"]["tokens_passed"])
    messages = median(f"hop-{mesh}-manhattan", lambda f: f["links_total"]["messages"])
    hop = 1e6 * (manhattan - direct) / (messages - tokens)
    print(f"| {mesh} | {1e3 * direct:.1f} ms | {1e3 * manhattan:.1f} ms | {tokens:.0f} | {messages:.0f} | {hop:.1f} µs |")

print("\n| mesh | slots a link | tokens move | messages over links | met another | waited for a slot | in sum |")
print("|---|---|---|---|---|---|---|")
for shape in ["2x2+4", "3x3+6", "4x4+4", "4x4+8"]:
    for slots in [1, 4]:
        for way, words in [("step", "in step"), ("loopback", "freely, one process"), ("mpi", "freely, MPI")]:
            links = frames(f"queue-{shape}-{slots}-{way}")[0]["links_total"]
            share = [f"{100 * links[key] / links['messages']:.1f} %" for key in ["shared", "waited"]]
            print(f"| {shape} | {slots} | {words} | {links['messages']} | {share[0]} | {share[1]} | {1e3 * links['wait_seconds']:.1f} ms |")
