"""The operator's page with the test as its server: files from the package, messages by hand.

Nothing listens on a port: the browser's requests end here. For tests of what the page says and shows; what
the server makes of it, and when, is tested with the server.
"""

import importlib.resources
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, Route, WebSocketRoute

from forest_station.operator.hands_message import Hands, decode_hands

WEB = Path(str(importlib.resources.files("forest_station") / "web"))
ADDRESS = "http://station.test"
POLICY = {"Content-Security-Policy": "default-src 'self'; connect-src 'self' ws://station.test"}
YOU = "operator 1"
NO_HANDS = """
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (data) { if (typeof data === "string") send.call(this, data); };
navigator.getGamepads = () => [];
"""
Js = Callable[..., Any]  # a module of the page, an arrow function of it and of an argument; gives its value


def serve_file(route: Route) -> bool:
    """Serve a file of the page's folder, and tell whether it is there; without an answer a page hangs."""
    path = WEB.parent / route.request.url.removeprefix(f"{ADDRESS}/").split("?")[0]
    if path.is_file():
        route.fulfill(path=path)
        return True
    route.fulfill(status=404)
    return False


class PageStandIn:
    """What one page meets.

    Args:
        page: that is to be opened.
        signals: names and units of the frames' values.
        dropped: further files of the page's folder, text by path, as somebody dropped them in.
        hands: whether its hands are heard: 50 messages a second, which cost more than most tests.
    """

    def __init__(
        self,
        page: Page,
        signals: tuple[tuple[str, str], ...] = (),
        dropped: dict[str, str] | None = None,
        hands: bool = True,
    ) -> None:
        self.page, self.signals, self.dropped = page, signals, dropped or {}
        self.heard: list[Hands] = []  # every hands message, oldest first
        self.asked: list[dict[str, Any]] = []  # every request, oldest first
        self.silent: set[str] = set()  # what is asked for and gets no answer
        self.refusals: dict[str, str] = {}  # why a request is refused, by what it asks for
        self.pages: dict[str, Any] = {}  # what the server's own pages tell, by their paths
        self._socket: WebSocketRoute | None = None
        self._driver: str | None = None
        page.set_default_timeout(60_000)  # [ms] at which a test fails rather than hangs
        page.route(f"{ADDRESS}/**", self._serve)
        page.route_web_socket("ws://station.test/socket", self._connect)
        if not hands:
            page.add_init_script(NO_HANDS)

    def open(self) -> None:
        """Open the page, and wait for its hands."""
        self.page.goto(ADDRESS)
        self.page.wait_for_selector(".driver[data-drives=true]")

    def rest(self) -> None:
        """Come to rest between two tests: nothing pressed, stopped, refused or remembered."""
        self.page.mouse.up()
        for key in ("Shift", "w"):
            self.page.keyboard.up(key)
        self.silent.clear()
        self.refusals.clear()
        self.tell("emergency_stop", active=False, sources=[])
        self.tell_seat()
        self.page.clock.run_for(500)
        self.heard.clear()
        self.asked.clear()

    def tell(self, kind: str, **content: Any) -> None:
        """Send a message."""
        assert self._socket is not None
        self._socket.send(json.dumps({"kind": kind, **content}))

    def send_frame(self, number: int, seconds: float, values: list[float]) -> None:
        """Send the values of all signals at a time [s]."""
        assert self._socket is not None
        self._socket.send(struct.pack(f"<B3xId{len(values)}f", 2, number, seconds, *values))

    def tell_seat(
        self,
        driver: str | None = YOU,
        asking: tuple[str, ...] = (),
        deadman: tuple[str, str] = ("waiting", "Release the deadman and centre the sticks."),
        why_not: str = "",
        cause: str = "",
    ) -> None:
        """Tell who drives, and how the deadman is."""
        self._driver = driver
        state = dict(zip(("state", "text"), deadman, strict=True)) | {"cause": cause}
        self.tell(
            "seat", driver=driver, you_drive=driver == YOU, asking=asking, deadman=state, why_not=why_not
        )

    def drop_connection(self) -> None:
        """End the connection; the page makes a new one."""
        assert self._socket is not None
        self._socket.close()

    def _serve(self, route: Route) -> None:
        path = route.request.url.removeprefix(ADDRESS).split("?")[0]
        if path == "/":
            route.fulfill(path=WEB / "index.html", headers=POLICY | {"Content-Type": "text/html"})
        elif path == "/panels.json":
            route.fulfill(json=self._panels())
        elif path in self.pages:
            route.fulfill(json=self.pages[path])
        elif path.removeprefix("/web/") in self.dropped:
            text = self.dropped[path.removeprefix("/web/")]
            route.fulfill(body=text, content_type="text/javascript")
        else:
            serve_file(route)

    def _panels(self) -> dict[str, list[str]]:
        """Return the page's own panels, and those that were dropped in."""
        names = [*(WEB / "panels").iterdir(), *map(Path, self.dropped)]
        return {
            "modules": sorted(path.stem for path in names if path.suffix == ".js"),
            "styles": sorted(path.stem for path in names if path.suffix == ".css"),
        }

    def _connect(self, socket: WebSocketRoute) -> None:
        self._socket = socket
        socket.on_message(self._hear)
        self.tell("welcome", you=YOU, signals=self.signals)
        self.tell("emergency_stop", active=False, sources=[])
        self.tell_seat(driver=None)

    def _hear(self, message: str | bytes) -> None:
        if isinstance(message, bytes):
            self.heard.append(decode_hands(message))
            self.tell("pong", number=self.heard[-1].number)
            return
        request = json.loads(message)
        self.asked.append(request)
        if request["do"] in self.silent:
            return
        refusal = self.refusals.get(request["do"], "")
        self.tell("answer", to=request["number"], ok=not refusal, text=refusal or "done")
        if request["do"] == "take_seat" and self._driver is None:
            self.tell_seat()
