"""What a picture errs, proved for a page, against what `render --error certified` says of the same picture."""
import json, os, subprocess, time

import viewer_client as vc
from server_case import expect, is_alive, told


def ask(client, number, width, height, **state):
    client.send({"type": "errors", "id": number, "width": width, "height": height, "state": state})


def errors(options, server):
    client = server.client()
    expect(client.hello["errors"], "the page is not told that errors can be asked for")
    ask(client, 3, 40, 30, shading="none", camera={"azimuth": 25, "elevation": 35})
    said = client.text("errors")
    map = client.receive_until(lambda m: isinstance(m, vc.Picture) and m.number == 3)
    expect(map.kind == 1 and map.file.startswith(b"\x89PNG") and (map.width, map.height) == (40, 30), map)
    stats = os.path.join(options.scratch, "errors.json")
    subprocess.run([options.program, "render", options.volume, "--stats", stats, "--size", "40x30", "--shading", "none", "--azimuth", "25",
                    "--elevation", "35", "--fit", "sphere", "--error", "certified", "--error-pixels", "1200"], check=True, capture_output=True)
    with open(stats, encoding="utf-8") as file:
        proved = json.load(file)[0]["error"]
    expect(f"No pixel of 40 x 30 errs more than {proved['largest']:.3g}/255, {100 * proved['proved'][1]:.3g} % at most 1." in said["words"],
           (said, proved))
    expect(said["colours"]["colours"][-1][0] > 0, "no scale")
    # A newer question takes the place of one that lasts long.
    ask(client, 4, 1500, 1200)
    time.sleep(0.5)
    ask(client, 5, 8, 6)
    expect("no longer wanted" in told(client, 4), "another answer")
    client.receive_until(lambda m: isinstance(m, vc.Picture) and m.number == 5)
    # Nor does the end wait for one, or one whose page is gone.
    other = server.client()
    ask(other, 6, 1500, 1200)
    time.sleep(0.5)
    other.close()
    is_alive(server)
    ask(client, 7, 1500, 1200)
    time.sleep(0.5)
    begun = time.monotonic()
    expect(server.stop() == 0 and time.monotonic() < begun + 5 * vc.PATIENCE, f"{time.monotonic() - begun} s until the end")
