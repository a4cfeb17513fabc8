"""What the viewer's page gets: measures `ringsplat serve` as its page would.

Two ranks on this machine and one process serve the repository's head at 512x512 and 1024x1024, and the head refined to 512x512x512
voxels at 512x512. The test's client (tests/serve/viewer_client.py) drags, lets go and rests as the page does, but decodes no picture.
For each volume, picture and number of ranks a server is started, and

  - dragged: a view each 16 ms, every picture acknowledged when it has come. The latency of a picture is from when its view
    was sent to when all of it has come. A drag of three seconds comes before, in which the server learns what its levels cost.
  - let go: from the last view to the best picture, after drags of a second each.
  - woken: after some seconds without a view, how much longer the first view takes to its picture than the next ones,
    which are sent one by one and drawn at the same level.
  - left alone: the processor time of each rank while a page is connected and nothing is asked for.

Takes about ten minutes.
"""
import collections
import math
import select
import shlex
import statistics
import sys
import tempfile
import time
from pathlib import Path

from .output import print_head, print_row
from .run import HEAD, PROGRAM, REPO, fail, on_ranks, parser, say
from .volumes import refined

sys.path.insert(0, str(REPO / "tests/serve"))
import viewer_client as vc  # noqa: E402

VIEW_SECONDS = 0.016  # between two of a screen's frames
LEARNING_SECONDS = 3
SETTLING_SECONDS = 2  # until nothing is under way any more
FOLLOWING_VIEWS = 9

# name: volume, what the table calls it, pixels along each side
CASES = {"head-512": ("head", "head, 128 × 128 × 124", 512), "head-1024": ("head", "head, 128 × 128 × 124", 1024),
         "fine-512": ("fine", "refined head, 512³", 512)}
COLUMNS = ("volume", "picture", "ranks", "pictures a second", "latency, ms: median", "p95", "levels while dragged",
           "MB a second", "let go to best, s: median", "longest", "wake, ms", "idle, % of a core: each rank")

Arrival = collections.namedtuple("Arrival", "time latency picture bytes")


class Hand:
    """Turns the volume with one client, through all three slice sets."""

    def __init__(self, client, size):
        self.client, self.size, self.step = client, size, 0

    def view(self, moving):
        """Sends the next view, or the last one again when the hand lets go; its number."""
        self.step += moving
        camera = {"azimuth": math.fmod(0.8 * self.step, 360), "elevation": 65 * math.sin(0.013 * self.step)}
        return self.client.view(moving=moving, width=self.size, height=self.size, camera=camera)

    def arrival(self):
        """The next message, acknowledged; None when it is no picture."""
        message = self.client.receive()
        now = time.monotonic()
        if not isinstance(message, vc.Picture):
            if message["type"] in ("error", "end"):
                raise RuntimeError(message)
            return None
        self.client.acknowledge(message)
        return Arrival(now, now - 1e-3 * message.time, message, len(message.file))

    def arrivals(self, until):
        """Those that come before a time of the monotonic clock."""
        while True:
            left = until - time.monotonic()
            if not self.client.buffer and not select.select([self.client.socket], [], [], max(0, left))[0]:
                return
            arrival = self.arrival()
            if arrival:
                yield arrival
            if left <= 0:
                return

    def drag(self, seconds):
        """The pictures that came, and the seconds that it took. A view that is late does not shift those after it."""
        start = time.monotonic()
        found = []
        for k in range(round(seconds / VIEW_SECONDS)):
            found += self.arrivals(start + k * VIEW_SECONDS)
            self.view(moving=True)
        found += self.arrivals(start + seconds)
        return found, time.monotonic() - start

    def picture_of(self, seq, at_rest=False):
        """When the view's first picture, or its last one, has come."""
        while True:
            arrival = self.arrival()
            if arrival and arrival.picture.seq == seq and (arrival.picture.at_rest or not at_rest):
                return arrival

    def let_go(self):
        start = time.monotonic()
        return self.picture_of(self.view(moving=False), at_rest=True).time - start

    def wake(self):
        """Seconds that the first view takes more than those after it at the same level, of which there must be some."""
        first, *others = [self.picture_of(self.view(moving=True)) for _ in range(1 + FOLLOWING_VIEWS)]
        same = [a.latency for a in others if a.picture.level == first.picture.level]
        return first.latency - statistics.median(same) if same else math.nan


def percentile(values, share):
    """The smallest value that this share of them does not exceed."""
    return sorted(values)[math.ceil(share * len(values)) - 1]


def level_shares(arrivals, names):
    counts = collections.Counter(a.picture.level for a in arrivals)
    return "; ".join(f"{names[level]} {100 * count / len(arrivals):.0f} %" for level, count in sorted(counts.items()))


def idle_shares(server, seconds):
    before = [(rank, vc.processor_seconds(rank)) for rank in server.ranks()]
    time.sleep(seconds)
    return [(vc.processor_seconds(rank) - then) / seconds for rank, then in before]


def measure(server, size, options):
    """A dictionary of what the table's columns need."""
    client = server.client()
    hand = Hand(client, size)
    names = client.hello["levels"]
    hand.let_go()
    hand.drag(LEARNING_SECONDS)
    arrivals, seconds = hand.drag(options.seconds)
    best = []
    for _ in range(options.times):
        hand.drag(1)
        best.append(hand.let_go())
    wakes = []
    for _ in range(options.wakes):
        time.sleep(options.idle)
        wakes.append(hand.wake())
        hand.let_go()
    time.sleep(SETTLING_SECONDS)
    idle = idle_shares(server, options.seconds)
    client.close()
    latencies = [a.latency for a in arrivals]
    return {"rate": len(arrivals) / seconds, "median": statistics.median(latencies), "p95": percentile(latencies, 0.95),
            "levels": level_shares(arrivals, names), "bytes": sum(a.bytes for a in arrivals) / seconds,
            "best": statistics.median(best), "longest": max(best), "idle": idle,
            "wake": statistics.median([w for w in wakes if not math.isnan(w)] or [math.nan])}


def print_measured(title, size, ranks, m):
    print_row(title, f"{size}²", "one process" if ranks == 1 else ranks, f"{m['rate']:.1f}", f"{1e3 * m['median']:.0f}", f"{1e3 * m['p95']:.0f}",
              m["levels"], f"{1e-6 * m['bytes']:.2f}", f"{m['best']:.2f}", f"{m['longest']:.2f}", f"{1e3 * m['wake']:+.1f}",
              ", ".join(f"{100 * share:.1f}" for share in m["idle"]))


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    arguments.add_argument("--ranks", nargs="+", type=int, default=[2, 1], help="1: one process, without a launcher")
    arguments.add_argument("--seconds", type=float, default=10, help="of the drag that is measured, and of idling")
    arguments.add_argument("--times", type=int, default=10, help="how often the hand lets go")
    arguments.add_argument("--wakes", type=int, default=5)
    arguments.add_argument("--idle", type=float, default=5, help="seconds without a view before each wake")
    arguments.add_argument("--serve", default="", metavar="'OPTION...'", help="more options of ringsplat serve")
    options = arguments.parse_args(words)
    print_head(*COLUMNS)
    with tempfile.TemporaryDirectory() as folder:
        volumes = {"head": HEAD, "fine": Path(folder, "fine.nrrd")}
        if any(CASES[case][0] == "fine" for case in options.cases):
            refined(HEAD, volumes["fine"])
        for case in options.cases:
            volume, title, size = CASES[case]
            for ranks in options.ranks:
                say(f"{case}, ranks: {ranks}")
                command = (PROGRAM, "serve", volumes[volume], *shlex.split(options.serve))
                server = vc.Server([str(word) for word in on_ranks(ranks if ranks > 1 else 0, *command)])
                try:
                    print_measured(title, size, ranks, measure(server, size, options))
                    if server.stop() != 0:
                        fail("the server failed: " + server.errors)
                finally:
                    server.kill()
