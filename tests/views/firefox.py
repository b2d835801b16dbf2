"""Firefox without a window, told what to do by its own remote protocol (Marionette); offline."""

import json
import shutil
import socket
import subprocess
import time

PREFERENCES = {
    "marionette.port": 0,
    "network.proxy.type": 1,
    # Nothing listens there: what a page asks of a network fails.
    "network.proxy.http": "127.0.0.1",
    "network.proxy.http_port": 9,
    "network.proxy.ssl": "127.0.0.1",
    "network.proxy.ssl_port": 9,
}
STARTS_WITHIN, SCRIPT_MS = 60.0, 120_000

WAIT = """(selector) => new Promise((done) => {
  const look = () => (document.querySelector(selector) ? done() : setTimeout(look, 20));
  look();
})"""


def firefox_path():
    """The Firefox of this machine, or None."""
    return shutil.which("firefox") or shutil.which("firefox-esr")


class Firefox:
    """One window of a Firefox with a profile of its own in `folder`."""

    def __init__(self, folder):
        lines = [
            f"user_pref({json.dumps(key)}, {json.dumps(PREFERENCES[key])});" for key in PREFERENCES
        ]
        (folder / "user.js").write_text("\n".join(lines))
        self.process = subprocess.Popen(
            [firefox_path(), "--headless", "--marionette", "--no-remote", "--profile", str(folder)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        port = folder / "MarionetteActivePort"
        for _ in range(int(10 * STARTS_WITHIN)):
            if port.exists() and port.read_text():
                break
            time.sleep(0.1)
        self.connection = socket.create_connection(("127.0.0.1", int(port.read_text())))
        self.stream = self.connection.makefile("rwb")
        self._received()
        self.sent = 0
        self.ask("WebDriver:NewSession")
        self.ask("WebDriver:SetTimeouts", script=SCRIPT_MS)

    def ask(self, command, **parameters):
        """The value that a command of the protocol answers with."""
        self.sent += 1
        message = json.dumps([0, self.sent, command, parameters]).encode()
        self.stream.write(b"%d:%s" % (len(message), message))
        self.stream.flush()
        _, _, error, answer = self._received()
        assert error is None, error
        return answer.get("value")

    def _received(self):
        digits = b""
        while (digit := self.stream.read(1)) != b":":
            digits += digit
        return json.loads(self.stream.read(int(digits)))

    def open(self, address, width=1400, height=1000):
        self.ask("WebDriver:SetWindowRect", width=width, height=height)
        self.ask("WebDriver:Navigate", url=address)

    def evaluate(self, function, *arguments):
        """What a function of JavaScript returns, or the promise that it returns is kept with."""
        script = (
            f"const given = [...arguments], done = given.pop(); Promise.resolve(({function})(...given))"
            ".then(done, (fault) => done(String(fault)));"
        )
        return self.ask("WebDriver:ExecuteAsyncScript", script=script, args=list(arguments))

    def wait_for(self, selector):
        """Return once the page has such an element."""
        self.evaluate(WAIT, selector)

    def close(self):
        self.ask("Marionette:Quit", flags=["eForceQuit"])
        self.process.wait(timeout=30)
        self.stream.close()
        self.connection.close()
