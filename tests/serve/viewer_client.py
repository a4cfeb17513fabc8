"""A page's side of the viewer's protocol (docs/viewer.md), by Python's standard library alone: for tests."""
import base64, json, os, re, signal, socket, struct, subprocess, threading, time

PATIENCE = float(os.environ.get("RINGSPLAT_PATIENCE", "1"))  # sanitizers are slow


def deadline(seconds):
    return time.monotonic() + seconds * PATIENCE


class Refused(Exception):
    """The server answered an upgrade with another status."""

    def __init__(self, status):
        super().__init__(f"status {status}")
        self.status = status


def http(port, request, timeout=10):
    """Sends raw bytes, returns all that comes until the server closes."""
    with socket.create_connection(("127.0.0.1", port), timeout * PATIENCE) as s:
        s.sendall(request)
        answer = b""
        while True:
            try:
                part = s.recv(65536)
            except ConnectionResetError:
                return answer
            if not part:
                return answer
            answer += part


def get(port, target="/", host=None, headers=()):
    lines = [f"GET {target} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}", "Connection: close", *headers]
    return http(port, ("\r\n".join(lines) + "\r\n\r\n").encode())


class Closed(Exception):
    pass


class Client:
    """A WebSocket connection. Received messages: dictionaries of texts, Pictures of binary ones."""

    def __init__(self, port, token, host=None, origin="", protocols=None, receive_buffer=0):
        host = host or f"127.0.0.1:{port}"
        origin = f"http://{host}" if origin == "" else origin
        self.socket = socket.socket()
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        # As browsers do: small messages would wait up to 40 ms for the kernel's acknowledgement of the last one.
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.settimeout(20 * PATIENCE)
        self.socket.connect(("127.0.0.1", port))
        lines = [f"GET /ws HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade",
                 "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
        if origin is not None:
            lines.append(f"Origin: {origin}")
        protocols = ["ringsplat.v1", f"token.{token}"] if protocols is None else protocols
        if protocols:
            lines.append("Sec-WebSocket-Protocol: " + ", ".join(protocols))
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            part = self.socket.recv(65536)
            if not part:
                raise Refused(0)
            self.buffer += part
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        status = int(head.split()[1])
        if status != 101:
            raise Refused(status)
        assert b"ringsplat.v1" in head
        self.seq = 0

    def close(self):
        self.socket.close()

    def send_frame(self, opcode, payload):
        mask = os.urandom(4)
        n = len(payload)
        head = bytes([0x80 | opcode])
        head += bytes([0x80 | n]) if n < 126 else bytes([0xFE]) + struct.pack(">H", n) if n < 65536 else \
            bytes([0xFF]) + struct.pack(">Q", n)
        body = bytes(b ^ mask[k % 4] for k, b in enumerate(payload)) if n < 1 << 20 else payload
        self.socket.sendall(head + mask + body)

    def send(self, message):
        text = message if isinstance(message, str) else json.dumps(message)
        self.send_frame(1, text.encode())

    def take(self, count):
        while len(self.buffer) < count:
            part = self.socket.recv(1 << 16)
            if not part:
                raise Closed()
            self.buffer += part
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def receive(self, timeout=20):
        return self.receive_by(deadline(timeout))

    def receive_by(self, until):
        message = b""
        while True:
            try:
                self.socket.settimeout(max(0.01, until - time.monotonic()))  # pings do not prolong it
                first, second = self.take(2)
                n = second & 127
                if n == 126:
                    n = struct.unpack(">H", self.take(2))[0]
                elif n == 127:
                    n = struct.unpack(">Q", self.take(8))[0]
                payload = self.take(n)
            except (ConnectionResetError, BrokenPipeError):
                raise Closed()
            opcode = first & 15
            if opcode == 9:
                self.send_frame(10, payload)
                continue
            if opcode == 8:
                raise Closed()
            if opcode == 10:
                continue
            message += payload
            if opcode:
                kind = opcode
            if first & 0x80:
                return json.loads(message) if kind == 1 else Picture(message)

    def receive_until(self, wanted, timeout=20, acknowledge=True):
        """The first message for which wanted(message) is true; pictures before it are acknowledged."""
        until = deadline(timeout)
        while True:
            message = self.receive_by(until)
            if isinstance(message, Picture) and message.kind == 0 and acknowledge:
                self.acknowledge(message)
            if wanted(message):
                return message

    def text(self, kind, timeout=20):
        return self.receive_until(lambda m: isinstance(m, dict) and m["type"] == kind, timeout)

    def picture(self, timeout=20, **wanted):
        """The first picture with these values of its head."""
        return self.receive_until(
            lambda m: isinstance(m, Picture) and all(getattr(m, k) == v for k, v in wanted.items()), timeout)

    def snapshot(self, number, width, height, format="png", **more):
        """A file of a view, or of what `slice` and `state` say."""
        self.send({"type": "snapshot", "id": number, "width": width, "height": height, "format": format, **more})
        return self.receive_until(lambda m: isinstance(m, Picture) and m.kind == 1 and m.number == number)

    def probe(self, number, x, y):
        self.send({"type": "probe", "id": number, "x": x, "y": y})
        found = self.text("probe")
        assert found["id"] == number, found
        return found

    def rest(self):
        """Receives until the connection is closed."""
        try:
            while True:
                self.receive()
        except (Closed, ConnectionError):
            pass

    def acknowledge(self, picture):
        self.send({"type": "ack", "picture": picture.number})

    def view(self, moving=False, width=128, height=128, **state):
        self.seq += 1
        self.send({"type": "view", "seq": self.seq, "moving": moving, "width": width, "height": height,
                   "time": 1e3 * time.monotonic(), "state": state})
        return self.seq


class Picture:
    def __init__(self, message):
        (magic, self.kind, self.number, self.seq, self.width, self.height, self.level, self.levels, self.at_rest,
         self.format, self.seconds, self.rate, self.time, self.rmse,
         self.pictures) = struct.unpack("<4sIIIHHBBBBffdfI", message[:48])
        assert magic == b"RSP1"
        self.file = message[48:]


class Server:
    """A running `ringsplat serve`."""

    def __init__(self, command, environment=None):
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        env={**os.environ, **(environment or {})}, start_new_session=True)
        self.lines = []
        self.url = None
        while True:
            line = self.process.stdout.readline()
            if not line:
                raise RuntimeError("the server did not start: " + self.process.stderr.read())
            found = re.match(r"http://([^/]*):(\d+)/#([0-9a-f]{32})$", line.strip())
            if found:
                self.url, self.port, self.token = line.strip(), int(found[2]), found[3]
                break
        self.errors = ""
        self.reader = threading.Thread(target=self.read_errors, daemon=True)
        self.reader.start()

    def read_errors(self):
        for line in self.process.stderr:
            self.errors += line

    def client(self, **how):
        client = Client(self.port, self.token, **how)
        client.hello = client.text("hello")
        return client

    def ranks(self):
        return ranks_of(self.process.pid)

    def stop(self, number=signal.SIGTERM, timeout=30):
        """Its exit code."""
        os.kill(self.ranks()[0], number)
        return self.wait(timeout)

    def wait(self, timeout=30):
        try:
            return self.process.wait(timeout * PATIENCE)
        finally:
            self.kill()

    def kill(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()


def ranks_of(job, program="ringsplat"):
    """Process ids of a job's ranks: the launcher's descendants of that name, or the server itself."""
    children = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat") as f:
                name, rest = f.read().rsplit(")", 1)
            children.setdefault(int(rest.split()[1]), []).append((int(pid), name.split("(", 1)[1]))
        except OSError:
            pass
    found, todo = [], [job]
    while todo:
        for pid, name in children.get(todo.pop(), []):
            todo.append(pid)
            if name.startswith(program):
                found.append(pid)
    return sorted(found) or [job]


def memory_of(pid):
    """Resident bytes."""
    with open(f"/proc/{pid}/statm") as f:
        return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def processor_seconds(pid):
    with open(f"/proc/{pid}/stat") as f:
        fields = f.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
