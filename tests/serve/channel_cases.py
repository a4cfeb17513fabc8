"""The viewer with several channels: `serve VOLUME --channel ...`."""
import math, os, struct

from server_case import check_rendered, expect, is_alive, told

SHOWN = "2,0=#40ff80,1"
VIEW = {"azimuth": 30, "elevation": 20}


def make_channels(options):
    """Three channels of 16 bits; so large that the viewer has reduced levels of them."""
    path, side = os.path.join(options.scratch, "cells.nrrd"), 40
    with open(path, "wb") as file:
        file.write(f"NRRD0004\ntype: uint16\nendian: little\ndimension: 4\nsizes: 3 {side} {side} {side}\n"
                   "kinds: vector domain domain domain\nencoding: raw\n\n".encode())
        for z in range(side):
            for y in range(side):
                for x in range(side):
                    file.write(struct.pack("<3H", *(int(200 + 3000 * math.exp(-((x - 12 - 6 * c) ** 2 + (y - 20) ** 2 +
                                                                              (z - 28 + 8 * c) ** 2) / (60 + 50 * c)))
                                                    + (x * 7 + y * 13 + z * 5) % 17 for c in range(3))))
    return path


def check_drawn(options, client, shown, *more, **state):
    """A view as a file of floats has the bits of what `render` draws of these channels."""
    picture = client.snapshot(7, 160, 120, "exr", state={"camera": VIEW, **state})
    check_rendered(options, picture, "channels.exr", 0, options.volume, "--channel", shown, "--quality", "best", "--size",
                   "160x120", "--fit", "sphere", "--azimuth", "30", "--elevation", "20", *more)


def channels(options, server):
    client = server.client()
    told_of, looks = client.hello["channels"], client.hello["state"]["channels"]
    expect([one["name"] for one in told_of] == ["channel 2", "channel 0", "channel 1"], told_of)
    expect(all(look["visible"] and look["window"] == one["windows"]["mip"] for look, one in zip(looks, told_of)), looks)
    expect(client.hello["state"]["mode"] == "mip" and set(client.hello["modes"]) == set(told_of[0]["windows"]), told_of)
    for mode in ("mip", "composite", "sum"):
        own = [{**look, "window": one["windows"][mode]} for look, one in zip(looks, told_of)]
        alone = [{**look, "visible": k == 1} for k, look in enumerate(own)]
        recoloured = [{**look, "colour": colour} for look, colour in zip(own, ((1, 1, 1), (0, 0, 1), (1, 0.4, 0.2)))]
        check_drawn(options, client, SHOWN, "--mode", mode, mode=mode, channels=own)
        check_drawn(options, client, "0=#40ff80", "--mode", mode, mode=mode, channels=alone)
        check_drawn(options, client, "2=white,0=blue,1=#ff6633", "--mode", mode, mode=mode, channels=recoloured)
    windowed = [{**look, "window": [512, 2560]} for look in looks]
    check_drawn(options, client, SHOWN, "--range", "512:2560", channels=windowed)
    check_drawn(options, client, SHOWN, "--mode", "surface", "--isovalue", "512", mode="surface", channels=windowed)
    views(client, looks)
    probes(client, looks)
    for wrong in ([], looks[:2], [{**look, "window": [3, 2]} for look in looks], [{**look, "colour": [0, 0, 2]} for look in looks]):
        client.send({"type": "snapshot", "id": 9, "width": 16, "height": 16, "format": "png", "state": {"channels": wrong}})
        told(client, 9)
    client.close()
    is_alive(server)


def views(client, looks):
    """Hidden channels cost nothing, and a view without any is the background."""
    pictures = {}
    for shown in range(4):
        seq = client.view(camera=VIEW, channels=[{**look, "visible": k < shown} for k, look in enumerate(looks)])
        pictures[shown] = client.picture(seq=seq, at_rest=1)
    expect(len({picture.file for picture in pictures.values()}) == 4, "hidden channels are seen")
    expect(len(pictures[0].file) < 0.5 * len(pictures[3].file), "something is drawn of hidden channels")
    for k in range(12):
        client.view(moving=True, camera={"azimuth": 10 * k}, channels=looks)
    client.picture(seq=client.view(camera=VIEW, channels=looks), at_rest=1)


def probes(client, looks):
    """Of the first channel that is seen."""
    found = []
    for shown in range(3):
        client.picture(seq=client.view(camera=VIEW, channels=[{**look, "visible": k >= shown} for k, look in enumerate(looks)]), at_rest=1)
        found.append(client.probe(shown, 64, 64))
    expect(all(one["hit"] for one in found) and len({one["value"] for one in found}) == 3, found)
