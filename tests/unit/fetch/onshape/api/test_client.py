"""The client against a bare server: what is sent and counted, what is asked again, what a refusal says."""

import gzip
import json
import threading
from base64 import b64encode
from contextlib import contextmanager, suppress
from dataclasses import replace
from email.utils import formatdate
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import count
from time import monotonic, sleep, time

import pytest

from linkwright.stages.fetch.onshape.api.client import Client
from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import (
    AuthError,
    NotFound,
    Offline,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
)
from tests.support.kept import QUICK

KEY = Credentials("the-access", "the-secret")
MASS = "/partstudios/d/D/m/M/e/STUDIO/massproperties?configuration=a%3Db%2Bc"
DEFINITION = "/assemblies/d/D/w/W/e/ROOT?configuration=default"

CONFIGURED = "/assemblies/d/D/w/W/e/ROOT?configuration=leg%3D0.25%20m"


@contextmanager
def serving(answer, patience=QUICK, **more):
    """A client of a server whose `answer(handler)` writes each reply."""

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self):
            with suppress(OSError):
                answer(self)

        do_POST = do_GET  # noqa: N815 - the name http.server calls

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    origin = f"http://127.0.0.1:{server.server_address[1]}"
    try:
        url = AssemblyUrl(origin, "D", "w/W", "ROOT", "default")
        with Client(url, KEY, patience=patience, **more) as client:
            yield client
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def reply(status, body=b"", *, length=None, **headers):
    def answer(handler):
        handler.send_response_only(status)
        handler.send_header("Content-Length", str(len(body) if length is None else length))
        for name, value in headers.items():
            handler.send_header(name.replace("_", "-"), value)
        handler.end_headers()
        handler.wfile.write(body)
        handler.close_connection = length is not None

    return answer


def test_the_canonical_request_is_sent_as_it_is_with_basic_auth():
    seen = {}

    def answer(handler):
        seen.update(path=handler.path, **{k.lower(): v for k, v in handler.headers.items()})
        reply(200, b"{}")(handler)

    with serving(answer) as client:
        assert client.get(MASS) == b"{}"
    assert seen["path"] == "/api/v16" + MASS
    assert seen["authorization"] == "Basic dGhlLWFjY2Vzczp0aGUtc2VjcmV0"
    assert "gzip" in seen["accept-encoding"]


def test_a_packed_reply_is_unpacked():
    body = json.dumps({"bodies": list(range(1000))}).encode()
    with serving(reply(200, gzip.compress(body), Content_Encoding="gzip")) as client:
        assert client.get(MASS) == body


@pytest.mark.parametrize(
    ("request_", "status", "headers", "error", "said"),
    [
        (DEFINITION, 401, {}, AuthError, "works only on the host where it was made"),
        (MASS, 403, {}, AuthError, "may not read the mass properties of part studio STUDIO"),
        (MASS, 402, {}, QuotaExhausted, "yearly quota"),
        (DEFINITION, 404, {}, NotFound, "a part studio or a drawing?"),
        (MASS, 404, {}, NotFound, "not shared with you"),
        (MASS, 429, {"Retry_After": "450"}, RateLimited, "wait 450 s"),
        (MASS, 429, {"Retry_After": "450"}, RateLimited, "source.max_wait allows 120 s"),
        (MASS, 429, {"Retry_After": "450"}, RateLimited, "in 8 min: what was fetched is kept"),
        (MASS, 429, {"Retry_After": "450"}, RateLimited, "source.max_wait=460"),
        (MASS, 429, {"Retry_After": "soon"}, RateLimited, "(429)"),
        (MASS, 403, {"Date": formatdate(0, usegmt=True)}, AuthError, "ahead of the server's"),
        (MASS, 405, {}, Declined, "the form of the request"),
        (MASS, 418, {}, Declined, "(418)"),
        (MASS, 304, {}, ProtocolError, "not followed"),
        (DEFINITION, 400, {}, SourceError, "a part studio or a drawing?"),
        (MASS, 400, {}, Declined, "(400)"),
        (CONFIGURED, 400, {}, SourceError, "refuses the configuration 'leg=0.25 m' (400)"),
        (CONFIGURED, 400, {}, SourceError, "source.configuration, which is checked against the document"),
        (CONFIGURED, 404, {}, NotFound, "deleted, not shared"),
        (MASS, 406, {}, Declined, "(406)"),
        (MASS, 499, {}, ProtocolError, "tried 3 times"),
        (MASS, 500, {}, ProtocolError, "failed to give"),
        (MASS, 503, {}, ProtocolError, "failed to give"),
    ],
)
def test_each_refusal_is_explained_with_the_words_of_the_server(request_, status, headers, error, said):
    body = b'{"message": "Told\\nso by the-secret.", "status": 0}'
    with serving(reply(status, body, **headers)) as client, pytest.raises(SourceError) as caught:
        client.get(request_)
    assert type(caught.value) is error
    assert said in str(caught.value)
    assert "the-secret" not in str(caught.value)
    assert "127.0.0.1" in caught.value.where
    if status != 304:
        assert "Told so by ***." in caught.value.message


@pytest.mark.parametrize("status", [400, 401, 402, 429, 500])
def test_a_key_that_json_hides_in_escapes_is_not_repeated(status):
    echo = f"Basic {b64encode(b'the-access:the-secret').decode()} the-secret"
    body = b'{"message": "%s"}' % "".join(f"\\u{ord(letter):04x}" for letter in echo).encode()
    patience = replace(QUICK, max_wait=0)
    with serving(reply(status, body), patience) as client, pytest.raises(SourceError) as caught:
        client.get(MASS)
    assert '("Basic *** ***")' in caught.value.message


def test_a_web_page_is_never_quoted_nor_taken_for_a_reply():
    page = b"<!doctype html><html><body>Sign in</body></html>"
    with serving(reply(502, page)) as client, pytest.raises(ProtocolError) as caught:
        client.get(MASS)
    assert "html" not in caught.value.message
    with serving(reply(200, b"  " + page)) as client, pytest.raises(ProtocolError, match="a web page"):
        client.get(MASS)


def test_only_what_is_billed_is_counted():
    statuses = iter([200, 404, 307, 406, 200, 400, 402])
    with serving(lambda handler: reply(next(statuses), b"{}")(handler)) as client:
        for _ in range(7):
            with suppress(SourceError):
                client.get(MASS)
        assert client.calls == 3


BAD = {
    "cut short": reply(200, b'{"bodies"', length=1000),
    "badly packed": reply(200, gzip.compress(b"x" * 10000)[:-200] + b"?" * 200, Content_Encoding="gzip"),
    "not JSON": reply(200, b'{"bodies": {'),
    "too short a length": reply(200, b'{"bodies": {}}', length=5),
}


def parses(body):
    try:
        json.loads(body)
    except ValueError:
        msg = "not JSON"
        raise ProtocolError(msg, hint="again") from None


@pytest.mark.parametrize("bad", BAD)
def test_what_was_billed_in_vain_is_asked_for_once_more(bad):
    for heals in (True, False):
        numbers = count()

        def answer(handler, numbers=numbers, heals=heals):
            (BAD[bad] if next(numbers) == 0 or not heals else reply(200, b"{}"))(handler)

        with serving(answer) as client:
            if heals:
                assert client.get(MASS, check=parses) == b"{}"
            else:
                with pytest.raises(ProtocolError, match=r"cut short|not JSON") as caught:
                    client.get(MASS, check=parses)
                assert "tried 2 times" in caught.value.message
                assert caught.value.where == client.host
            assert client.calls == 2


def hang_up(handler):
    handler.close_connection = True
    handler.connection.close()


@pytest.mark.parametrize("first", [reply(500), reply(502, b"<html>"), reply(499), hang_up])
def test_what_fails_unbilled_is_asked_three_times(first):
    numbers, lines = count(), []
    with serving(
        lambda handler: (first if next(numbers) < 2 else reply(200, b"{}"))(handler), progress=lines.append
    ) as client:
        assert client.get(MASS) == b"{}"
        assert client.calls == 1
        assert len(lines) == 2
        assert "trying again in" in lines[0]
    with serving(first) as client, pytest.raises((ProtocolError, Offline), match="tried 3 times"):
        client.get(MASS)


@pytest.mark.parametrize("status", [400, 401, 402, 403, 404, 405, 406, 415])
def test_what_will_not_pass_is_asked_once(status):
    numbers = count()

    def answer(handler):
        next(numbers)
        reply(status)(handler)

    with serving(answer) as client, pytest.raises(SourceError):
        client.get(MASS)
    assert next(numbers) == 1


def test_a_reply_that_drips_is_given_up():
    def drip(handler):
        handler.send_response(200)
        handler.send_header("Content-Length", "1000")
        handler.end_headers()
        for _ in range(1000):
            handler.wfile.write(b" ")
            sleep(0.01)

    start = monotonic()
    with serving(drip, replace(QUICK, whole=0.1, read=5)) as client:
        with pytest.raises(Offline, match="did not answer in time"):
            client.get(MASS)
        assert client.calls == 2
    with serving(lambda handler: sleep(0.4), replace(QUICK, read=0.05)) as client:
        with pytest.raises(Offline, match="did not answer in time"):
            client.get(MASS)
        assert client.calls == 0
    assert monotonic() - start < 9  # the reply itself takes ten seconds


def test_a_closed_window_is_waited_for():
    numbers, lines = count(), []

    def answer(handler):
        bad = (
            reply(429, Retry_After="0")
            if next(numbers) < 3
            else reply(200, b"{}", X_Rate_Limit_Remaining="7")
        )
        bad(handler)

    with serving(answer, progress=lines.append) as client:
        assert client.get(MASS) == b"{}"
        assert (client.calls, len(lines), client.left) == (1, 3, {"massproperties": 7})
        assert client.waited > 0


def test_a_server_that_always_refuses_is_not_asked_for_ever():
    numbers = count()

    def answer(handler):
        next(numbers)
        reply(429)(handler)

    with serving(answer) as client, pytest.raises(RateLimited):
        client.get(MASS)
    assert next(numbers) == QUICK.refusals


def test_a_date_may_say_when_to_come_back():
    when = formatdate(time() + 3600, usegmt=True)
    with serving(reply(429, Retry_After=when)) as client, pytest.raises(RateLimited, match=r"in 60 min"):
        client.get(MASS)


def test_an_overloaded_server_that_asks_for_too_long_is_left_at_once():
    numbers = count()

    def answer(handler):
        next(numbers)
        reply(503, Retry_After="5000")(handler)

    with serving(answer) as client, pytest.raises(ProtocolError, match=r"\(503\)"):
        client.get(MASS)
    assert next(numbers) == 1


@pytest.mark.parametrize("refused", [reply(402), reply(429, Retry_After="5000")])
def test_after_the_end_of_the_quota_no_call_is_made_and_no_wait_goes_on(refused):
    asked = []

    def answer(handler):
        asked.append(handler.path)
        if "waits" in handler.path:
            reply(429, Retry_After="100")(handler)
        else:
            refused(handler)

    with serving(answer) as client:
        error = []

        def wait():
            try:
                client.get("/documents/d/D/w/W/waits")
            except SourceError as caught:
                error.append(caught)

        thread = threading.Thread(target=wait)
        thread.start()
        while not client.waited:
            sleep(0.001)
        with pytest.raises((QuotaExhausted, RateLimited)) as first:
            client.get(MASS)
        thread.join(5)
        assert not thread.is_alive()
        with pytest.raises(type(first.value)):
            client.get(DEFINITION)
    assert type(error[0]) is type(first.value)
    assert len(asked) == 2


def test_a_stop_ends_all_waits():
    with serving(reply(429, Retry_After="100")) as client:
        timer = threading.Timer(0.05, client.stop)
        timer.start()
        with pytest.raises(Offline, match="stopped"):
            client.get(MASS)


@pytest.mark.parametrize("begun", [False, True], ids=["no answer yet", "within the body"])
def test_a_stop_ends_a_call_on_its_way_and_nothing_is_asked_again(begun):
    asked, over, said = [], threading.Event(), []

    def slow(handler):
        asked.append(handler.path)
        if begun:
            handler.send_response_only(200)
            handler.send_header("Content-Length", "100")
            handler.end_headers()
            handler.wfile.flush()
        over.wait(20)

    with serving(slow, patience=replace(QUICK, read=20.0, whole=20.0), progress=said.append) as client:
        threading.Timer(0.3, client.stop).start()
        start = monotonic()
        with pytest.raises(Offline, match="stopped"):
            client.get(MASS)
        assert monotonic() - start < 15  # the server takes twenty seconds
        over.set()
    assert (len(asked), said) == (1, [])


@pytest.mark.parametrize(
    ("answer", "limit"),
    [(reply(200, b"{}", length=9), 1), (reply(302, Location=f"/api/v16{MASS}"), 2)],
    ids=["asked again", "sent elsewhere"],
)
def test_a_bound_on_calls_holds_for_what_was_not_planned(answer, limit):
    with serving(answer, max_calls=limit) as client, pytest.raises(SourceError) as caught:
        client.get(MASS)
    assert (client.calls, caught.value.where) == (limit, "source.max_calls")
    assert f"source.max_calls={limit + 1} or more; what was fetched is kept" in caught.value.hint


def test_what_undoes_a_change_is_posted_whatever_the_bound_on_calls():
    with serving(reply(200, b"{}"), max_calls=0) as client:
        with pytest.raises(SourceError, match="max_calls is 0"):
            client.get(MASS)
        assert client.post("/variables/d/D/w/W/e/E/variables", b"[]", restoring=True) == b"{}"


def test_what_is_posted_is_sent_with_its_type_and_asked_again_only_if_it_cannot_have_been_done():
    seen, numbers = [], count()

    def answer(handler):
        size = int(handler.headers["Content-Length"])
        seen.append((handler.command, handler.headers["Content-Type"], handler.rfile.read(size)))
        reply(429 if next(numbers) == 0 else 200, b"[]")(handler)

    with serving(answer) as client:
        assert client.post("/variables/d/D/w/W/e/E/variables", b"[1]") == b"[]"
        assert client.calls == 1
    assert seen == [("POST", "application/json", b"[1]")] * 2


@pytest.mark.parametrize("bad", [reply(500), reply(200, b"[", length=9), hang_up, reply(302, Location="/x")])
def test_what_may_have_been_carried_out_is_not_posted_again(bad):
    numbers = count()

    def answer(handler):
        handler.rfile.read(int(handler.headers["Content-Length"]))
        next(numbers)
        bad(handler)

    with serving(answer) as client, pytest.raises(SourceError):
        client.post("/variables/d/D/w/W/e/E/variables", b"[1]")
    assert next(numbers) == 1


@pytest.mark.parametrize("bad", [reply(500), reply(499), hang_up])
def test_what_undoes_a_change_is_posted_again_within_bounds(bad):
    numbers, fails = count(), [1]

    def answer(handler):
        handler.rfile.read(int(handler.headers["Content-Length"]))
        (bad if next(numbers) < fails[0] else reply(200, b"[]"))(handler)

    with serving(answer) as client:
        assert client.post("/variables/d/D/w/W/e/E/variables", b"[1]", restoring=True) == b"[]"
        assert next(numbers) == 2
        fails[0] = 1000
        with pytest.raises(SourceError, match="tried 3 times"):
            client.post("/variables/d/D/w/W/e/E/variables", b"[1]", restoring=True)
        assert next(numbers) == 2 + 1 + 3


@pytest.mark.parametrize("status", [402, 429])
def test_what_undoes_a_change_is_posted_where_all_calls_were_stopped(status):
    times = []

    def answer(handler):
        if handler.command == "GET":
            return reply(status, Retry_After="450")(handler)
        handler.rfile.read(int(handler.headers["Content-Length"]))
        times.append(monotonic())
        return reply(429, Retry_After="1")(handler) if len(times) == 1 else reply(200, b"[]")(handler)

    with serving(answer) as client:
        for _ in range(2):
            with pytest.raises((QuotaExhausted, RateLimited)):
                client.get(MASS)
        with pytest.raises((QuotaExhausted, RateLimited)):
            client.post("/variables/d/D/w/W/e/E/variables", b"[1]")
        assert times == []
        assert client.post("/variables/d/D/w/W/e/E/variables", b"[1]", restoring=True) == b"[]"
    # Its own window is waited for all the same.
    assert times[1] - times[0] >= 1


def test_long_replies_show_how_much_has_arrived_and_short_ones_do_not():
    def halves(handler):
        size = 50 if "short" in handler.path else 3_000_000
        handler.send_response(200)
        handler.send_header("Content-Length", str(size))
        handler.end_headers()
        for _ in range(2):
            handler.wfile.write(b"1" * (size // 2))
            handler.wfile.flush()
            if size > 50:
                sleep(0.3)

    seen = []
    with serving(halves, transient=seen.append) as client:
        client.get("/short")
        assert seen == []
        client.get("/long")
    shown = [float(line.removesuffix(" MB received")) for line in seen]
    assert 1 <= len(shown) <= 5
    assert shown == sorted(shown)
    assert shown[0] >= 1.0
    assert shown[-1] > 1.5


def test_what_the_server_is_is_taken_down():
    with serving(reply(200, b"{}", X_Api_Version="v16", On_Version="1.218.0")) as client:
        client.get(MASS)
        assert client.met == {"api": "v16", "release": "1.218.0"}


def test_no_server_is_offline():
    with serving(reply(200, b"{}")) as client:
        pass
    url = AssemblyUrl(f"http://{client.host}", "D", "w/W", "ROOT", "default")
    with Client(url, KEY, patience=QUICK) as late:
        with pytest.raises(Offline, match="cannot be reached"):
            late.get(MASS)
        assert late.calls == 0
