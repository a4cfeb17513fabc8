"""Slices that a page asks for, against those that the program draws and the file's own voxels."""
import gzip, math

from server_case import check_rendered, expect, told


def voxels(path):
    """The bytes of a gzipped NRRD, and its sizes."""
    with open(path, "rb") as file:
        head, data = file.read().split(b"\n\n", 1)
    sizes = next(line for line in head.decode().splitlines() if line.startswith("sizes:"))
    return gzip.decompress(data), [int(word) for word in sizes.split()[1:]]


def across_view(options, client):
    """Through a voxel, against the program's picture of what two planes leave there."""
    at, (azimuth, elevation), volume = (50, 77, 62), (25, 35), client.hello["volume"]
    got = client.snapshot(30, 200, 160, slice=at, state={
        "transfer_function": client.hello["modes"]["mip"], "mode": "mean",
        "camera": {"azimuth": azimuth, "elevation": elevation, "zoom": 3, "pan": [0.2, 0.1]}})
    a, e = math.radians(azimuth), math.radians(elevation)
    viewer = (math.cos(e) * math.sin(a), -math.cos(e) * math.cos(a), math.sin(e))
    place = [(at[k] - (volume["dims"][k] - 1) / 2) * volume["spacing"][k] for k in range(3)]
    world = [sum(volume["direction"][3 * k + row] * place[k] for k in range(3)) for row in range(3)]
    far, half = sum(v * w for v, w in zip(viewer, world)), 1e-3 * min(volume["spacing"])
    planes = [(*viewer, far - half), (*(-v for v in viewer), -far - half)]
    check_rendered(options, got, "across.png", 1, options.volume, "--size", "200x160", "--azimuth", str(azimuth), "--elevation",
                   str(elevation), "--fit", "sphere", "--mode", "mip", "--clip-plane",
                   ":".join(",".join(map(repr, plane)) for plane in planes))


def cut_open(options, client):
    """Along an axis' slices, from both sides, and across the view: as the program draws it, and of the cut a probe's value."""
    grey, at, volume = client.hello["modes"]["mip"], (50, 77, 62), client.hello["volume"]
    for number, (cut, elevation) in enumerate((((2, *at), 35), ((2, *at), -35), ((0, *at), 20))):
        state = {"transfer_function": grey, "mode": "mip", "cut": cut,
                 "camera": {"azimuth": 60, "elevation": elevation, "zoom": 1, "pan": [0, 0]}}
        got = client.snapshot(40 + number, 120, 100, state=state)
        check_rendered(options, got, "cut.png", 0, options.volume, "--mode", "mip", "--size", "120x100", "--azimuth", "60",
                       "--elevation", str(elevation), "--fit", "sphere", "--cut", f"{'xyz'[cut[0]]}={at[cut[0]]}")
    client.picture(seq=client.view(width=120, height=100, **{**state, "cut": [3, *at]}), at_rest=1)
    found = client.probe(50, 60, 50)
    a, e = math.radians(60), math.radians(20)
    viewer = (math.cos(e) * math.sin(a), -math.cos(e) * math.cos(a), math.sin(e))
    apart = [(found["voxel"][k] - at[k]) * volume["spacing"][k] for k in range(3)]
    world = [sum(volume["direction"][3 * k + row] * apart[k] for k in range(3)) for row in range(3)]
    expect(found["hit"] and abs(sum(v * w for v, w in zip(viewer, world))) < 1e-6, found)


def slices(options, server):
    client = server.client()
    data, dims = voxels(options.volume)
    grey = client.hello["modes"]["mip"]
    for axis, index in ((0, 61), (1, 40), (2, 70)):
        lies = client.hello["volume"]["slices"][axis]
        along = [abs(lies[way]) - 1 for way in ("right", "up")]
        extents = [dims[k] * client.hello["volume"]["spacing"][k] for k in along]
        size = [300, round(300 * extents[1] / extents[0])]
        got = client.snapshot(10 + axis, *size, slice=[axis, index],
                              state={"transfer_function": grey, "clip": [[0, 9], [0, 9], [0, 9]], "mode": "mean"})
        check_rendered(options, got, "slice.png", 0, options.volume, "--slice", f"{'xyz'[axis]}={index}", "--size",
                       f"{size[0]}x{size[1]}")
    across_view(options, client)
    cut_open(options, client)
    for number, wrong in enumerate(([3, 0], [0, 128], [0, -1], [0], [1, 2, "x"], "x", 7)):
        client.send({"type": "snapshot", "id": 100 + number, "width": 8, "height": 8, "format": "png", "slice": wrong})
        expect("slice" in told(client, 100 + number), "the error names no slice")
    for at in ((50, 77, 62), (64, 30, 90), (81, 99, 40), (0, 0, 0), (127, 127, 123)):
        client.send({"type": "probe", "id": 20, "voxel": at, "state": {"transfer_function": grey}})
        value, found = data[(at[2] * dims[1] + at[1]) * dims[0] + at[0]], client.text("probe")
        expect(abs(found["value"] - value) < 1e-4, (at, value, found))
        expect(value < 9 or found["hit"] and all(abs(a - b) < 1e-5 for a, b in zip(found["voxel"][:2], at)), (at, found))
    client.close()
