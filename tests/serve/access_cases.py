"""Tests of what a running `ringsplat serve` shows to whom."""
import base64, gzip, hashlib, os, stat

import viewer_client as vc
from server_case import expect, is_alive, refused, until


def page(options, server):
    answer = vc.get(server.port)
    head = answer.split(b"\r\n\r\n")[0].decode().lower()
    expect(answer.startswith(b"HTTP/1.1 200"), answer[:80])
    for line in ("content-type: text/html; charset=utf-8", "x-content-type-options: nosniff",
                 "referrer-policy: no-referrer", "cache-control: no-cache",
                 "cross-origin-resource-policy: same-origin"):
        expect(line in head, line + " is missing")
    policy = next(l for l in head.split("\r\n") if l.startswith("content-security-policy"))
    expect("unsafe" not in policy and "script-src 'self'" in policy, policy)
    expect(server.token not in answer.decode(), "the page has the token")
    for target in ("/no", "/../etc/passwd", "/page/index.html", "//index.html", "/%2e%2e/x", "/app.js", "/style.css"):
        expect(vc.get(server.port, target).startswith(b"HTTP/1.1 404"), target)


def packed_page(options, server):
    """One file has all of the page, is sent compressed, and once."""
    def ask(*headers):
        head, body = vc.get(server.port, headers=headers).split(b"\r\n\r\n", 1)
        status, *lines = head.decode().lower().split("\r\n")
        return int(status.split()[1]), dict(line.split(": ", 1) for line in lines), body

    status, plain, html = ask()
    expect(status == 200 and "content-encoding" not in plain, plain)
    expect(b" src=" not in html and b"stylesheet" not in html and b"\nimport " not in html and b"\nexport " not in html,
           "the page asks for more")
    status, packed, body = ask("Accept-Encoding: gzip, deflate, br")
    expect(packed["content-encoding"] == "gzip" and gzip.decompress(body) == html, packed)
    expect(len(body) < len(html) / 3 and body[4:8] == bytes(4), "large, or has a time")
    for part, tag in ((b"script", b'<script type="module">'), (b"style", b"<style>")):
        inside = html.split(tag, 1)[1].split(b"</" + part + b">", 1)[0]
        digest = base64.b64encode(hashlib.sha256(inside).digest()).decode()
        expect(f"'sha256-{digest}'".lower() in packed["content-security-policy"], f"the policy forbids the {part}")
    status, head, body = ask(f"If-None-Match: {packed['etag']}")
    expect((status, body) == (304, b"") and head["etag"] == packed["etag"], head)
    expect(ask('If-None-Match: "other"')[0] == 200, "another page is taken for this one")


def strangers(options, server):
    port, host = server.port, f"127.0.0.1:{server.port}"
    refused(server, 403, protocols=[])
    for token, status in (("", 403), ("0" * 32, 403), (server.token[:-1], 403), (server.token, 204)):
        answer = vc.get(port, "/token", headers=[f"Ringsplat-Token: {token}"])
        expect(answer.startswith(f"HTTP/1.1 {status}".encode()), answer[:40])
    for offered in (["ringsplat.v1"], ["ringsplat.v1", "token." + server.token[:-1]], ["token." + server.token]):
        refused(server, 403, protocols=offered)
    for origin in (None, "http://evil.example", f"http://127.0.0.1:{port + 1}"):
        refused(server, 403, origin=origin)
    for foreign in ("evil.example", f"evil.example:{port}", f"127.0.0.1:{port + 1}"):
        refused(server, 421, host=foreign)
        expect(vc.get(port, host=foreign).startswith(b"HTTP/1.1 421"), foreign)
    two = f"GET / HTTP/1.1\r\nHost: {host}\r\nHost: evil.example\r\n\r\n".encode()
    expect(b" 4" in vc.http(port, two)[:13], "two hosts")
    vc.Client(port, server.token, host=f"localhost:{port}").close()
    is_alive(server)
    expect(server.token not in server.errors, "the token is in the log")


def allowed(options, server):
    for how in ({"host": "node7:9999", "origin": "http://node7:9999"}, {"origin": "https://hub.example.org"}):
        vc.Client(server.port, server.token, **how).close()
    refused(server, 403, origin="https://hub.example.org.evil")
    is_alive(server)


def fake_browser(options):
    """An xdg-open that writes down what it is started with."""
    program = os.path.join(options.scratch, "bin", "xdg-open")
    os.makedirs(os.path.dirname(program), exist_ok=True)
    os.makedirs(os.path.join(options.scratch, "own"), exist_ok=True)
    with open(program, "w") as f:
        f.write(f"""#!/bin/sh
echo "$*" > {options.scratch}/arguments.part
mv {options.scratch}/arguments.part {options.scratch}/arguments
""")
    os.chmod(program, 0o755)


def opens(options, server):
    """The browser's command line, which every user of the machine can read, does not have the token."""
    arguments = os.path.join(options.scratch, "arguments")
    until("xdg-open is not started", lambda: os.path.exists(arguments))
    with open(arguments) as f:
        page = f.read().strip()
    expect(server.token not in page and page.startswith(os.path.join(options.scratch, "own")), page)
    expect(stat.S_IMODE(os.stat(page).st_mode) == 0o600, "others may read the file")
    expect(stat.S_IMODE(os.stat(os.path.dirname(page)).st_mode) == 0o700, "others may look into the folder")
    with open(page) as f:
        expect(f'content="0; url={server.url}"' in f.read(), "the file does not lead to the page")
    expect(server.stop() == 0, "the job failed: " + server.errors)
    expect(not os.path.exists(os.path.dirname(page)), "the file is left behind")
