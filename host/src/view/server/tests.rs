//! The server from outside: foreign pages, other users, and clients that do not behave.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tungstenite::protocol::{Message, Role, WebSocketConfig};
use tungstenite::{Error as SocketError, WebSocket};

use super::{CONNECTIONS_MAX, Feed, Live, PAGES_MAX, Server, Site};

/// Longest wait of a client: a server that does not answer fails the test.
const LIMIT: Duration = Duration::from_secs(60);
const PAGE: &str = "<!doctype html>a page";

/// A server, its feed, and the messages that its pages sent.
struct Setup {
    server: Server,
    feed: Arc<Feed>,
    heard: Arc<Mutex<Vec<String>>>,
}

type Page = WebSocket<TcpStream>;

impl Setup {
    fn new() -> Self {
        let (feed, heard) = (Arc::<Feed>::default(), Arc::<Mutex<Vec<String>>>::default());
        let ear = Arc::clone(&heard);
        let reply = Box::new(move |message: &str| {
            ear.lock().unwrap().push(message.to_owned());
            (message != "nothing").then(|| format!("heard {message}"))
        });
        let post = Box::new(|body: &[u8]| match body {
            b"soft" => Ok(b"baked".to_vec()),
            _ => Err("give a material that is soft".to_owned()),
        });
        let site = Site {
            page: PAGE.into(),
            files: vec![("/model", b"a model".to_vec())],
            posts: vec![("/bake", post)],
            live: Some(Live { feed: Arc::clone(&feed), reply }),
        };
        Self { server: Server::start(0, site).unwrap(), feed, heard }
    }

    fn port(&self) -> u16 {
        let address = self.server.address();
        let after_host = address.strip_prefix("http://127.0.0.1:").unwrap();
        after_host.split('/').next().unwrap().parse().unwrap()
    }

    fn token(&self) -> String {
        self.server.address().split('#').nth(1).unwrap().to_owned()
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port())).unwrap();
        stream.set_read_timeout(Some(LIMIT)).unwrap();
        stream
    }

    /// Everything that the server sends after these bytes.
    fn exchange(&self, sent: &[u8]) -> String {
        let mut stream = self.connect();
        // A server may refuse before it has read all.
        let _ = stream.write_all(sent);
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8(answer).unwrap()
    }

    /// The status and the body of a request with these fields besides a right host.
    fn ask(&self, line: &str, fields: &[String], body: &str) -> (u16, String) {
        let host = format!("Host: 127.0.0.1:{}", self.port());
        self.ask_as(&host, line, fields, body)
    }

    fn ask_as(&self, host: &str, line: &str, fields: &[String], body: &str) -> (u16, String) {
        let length = format!("Content-Length: {}", body.len());
        let own = [line.to_owned() + " HTTP/1.1", host.to_owned(), length];
        let head = [&own, fields].concat().join("\r\n");
        let answer = self.exchange(format!("{head}\r\n\r\n{body}").as_bytes());
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
    }

    fn bearer(&self) -> String {
        format!("Authorization: Bearer {}", self.token())
    }

    fn upgrade(&self, token: &str) -> Vec<String> {
        let fields = [
            "Upgrade: websocket",
            "Connection: keep-alive, Upgrade",
            "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
        ];
        let protocols = format!("Sec-WebSocket-Protocol: chaincell, {token}");
        fields.map(str::to_owned).into_iter().chain([protocols]).collect()
    }

    /// Opens a page's WebSocket.
    fn open(&self) -> Page {
        let mut stream = self.connect();
        let port = self.port();
        let own = ["GET /live HTTP/1.1".to_owned(), format!("Host: localhost:{port}")];
        let origin = [format!("Origin: http://localhost:{port}")];
        let head = [&own[..], &origin, &self.upgrade(&self.token())].concat().join("\r\n");
        stream.write_all(format!("{head}\r\n\r\n").as_bytes()).unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            answer.extend(byte);
        }
        let answer = String::from_utf8(answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 101 "), "{answer}");
        // The example of RFC 6455.
        assert!(answer.contains("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"));
        assert!(answer.contains("Sec-WebSocket-Protocol: chaincell\r\n"), "{answer}");
        WebSocket::from_raw_socket(stream, Role::Client, Some(WebSocketConfig::default()))
    }
}

/// Code and reason with which a page is closed.
fn closed(page: &mut Page) -> (u16, String) {
    loop {
        match page.read() {
            Ok(Message::Close(Some(frame))) => {
                return (frame.code.into(), frame.reason.as_str().to_owned());
            }
            Ok(_) => {}
            Err(why) => panic!("{why}"),
        }
    }
}

fn frame(page: &mut Page) -> Vec<u8> {
    match page.read() {
        Ok(Message::Binary(bytes)) => bytes.to_vec(),
        other => panic!("{other:?}"),
    }
}

fn text(page: &mut Page) -> String {
    match page.read() {
        Ok(Message::Text(text)) => text.as_str().to_owned(),
        other => panic!("{other:?}"),
    }
}

fn say(page: &mut Page, message: &str) {
    page.send(Message::text(message)).unwrap();
}

#[test]
fn the_page_is_open_and_all_else_needs_the_token() {
    let setup = Setup::new();
    let (status, page) = setup.ask("GET /", &[], "");
    assert_eq!((status, page.as_str()), (200, PAGE));
    let head = setup.exchange(
        format!("GET /?x HTTP/1.1\r\nHost: localhost:{}\r\n\r\n", setup.port()).as_bytes(),
    );
    for field in ["default-src 'none'", "connect-src 'self'", "nosniff", "Cache-Control: no-store"]
    {
        assert!(head.contains(field), "{field}: {head}");
    }
    assert!(!head.contains(&setup.token()));
    let right = setup.bearer();
    let cut = right[..right.len() - 1].to_owned();
    let swapped = right.replace("Bearer", "Basic");
    for (line, body, found) in [("GET /model", "", "a model"), ("POST /bake", "soft", "baked")] {
        for wrong in [
            vec![],
            vec![cut.clone()],
            vec![swapped.clone()],
            vec!["Authorization: Bearer ".into()],
        ] {
            let (status, text) = setup.ask(line, &wrong, body);
            assert!(status == 403 && text.contains("open the whole address"), "{wrong:?}: {text}");
        }
        // Twice: nobody knows which one counts.
        assert_eq!(setup.ask(line, &[cut.clone(), right.clone()], body).0, 400);
        assert_eq!(setup.ask(line, std::slice::from_ref(&right), body), (200, found.to_owned()));
    }
    // Without the token nobody learns which names there are.
    assert_eq!(setup.ask("GET /other", &[], "").0, 403);
    assert_eq!(setup.ask("GET /other", std::slice::from_ref(&right), "").0, 404);
    assert_eq!(setup.ask("POST /model", std::slice::from_ref(&right), "").0, 405);
    assert_eq!(setup.ask("GET /bake", std::slice::from_ref(&right), "").0, 405);
    assert_eq!(setup.ask("DELETE /", &[], "").0, 405);
    let (status, text) = setup.ask("POST /bake", &[right], "hard");
    assert_eq!((status, text.as_str()), (422, "give a material that is soft\n"));
}

#[test]
fn another_host_is_refused_whatever_else_is_right() {
    let setup = Setup::new();
    let (port, right) = (setup.port(), setup.bearer());
    let hosts = [
        format!("Host: rebound.example:{port}"),
        "Host: 127.0.0.1".to_owned(),
        format!("Host: 127.0.0.1:{}", port ^ 1),
        format!("Host: localhost:{port}.example"),
        format!("Host: 127.0.0.2:{port}"),
        "X-None: 1".to_owned(),
    ];
    let upgrade = setup.upgrade(&setup.token());
    for host in &hosts {
        for (line, fields) in [
            ("GET /", &[][..]),
            ("GET /model", std::slice::from_ref(&right)),
            ("GET /live", &upgrade),
        ] {
            let (status, text) = setup.ask_as(host, line, fields, "");
            assert!(status == 421 && text.contains("127.0.0.1 alone"), "{host} {line}: {text}");
        }
    }
    let both = format!("Host: localhost:{port}\r\nHost: rebound.example:{port}");
    assert_eq!(setup.ask_as(&both, "GET /", &[], "").0, 400);
    for own in ["localhost", "127.0.0.1"] {
        assert_eq!(setup.ask_as(&format!("Host: {own}:{port}"), "GET /", &[], "").0, 200);
    }
}

#[test]
fn another_page_is_refused_whatever_else_is_right() {
    let setup = Setup::new();
    let (port, right) = (setup.port(), setup.bearer());
    let origins = [
        "null".to_owned(),
        "https://foreign.example".to_owned(),
        format!("https://127.0.0.1:{port}"),
        format!("http://127.0.0.1:{}", port ^ 1),
        "http://localhost".to_owned(),
        String::new(),
    ];
    for origin in origins.map(|origin| format!("Origin: {origin}")) {
        let with = |fields: &[String]| [fields, std::slice::from_ref(&origin)].concat();
        for (line, fields, body) in [
            ("GET /", with(&[]), ""),
            ("GET /model", with(std::slice::from_ref(&right)), ""),
            ("POST /bake", with(std::slice::from_ref(&right)), "soft"),
            ("GET /live", with(&setup.upgrade(&setup.token())), ""),
        ] {
            let (status, text) = setup.ask(line, &fields, body);
            assert!(status == 403 && text.contains("another page"), "{origin} {line}: {text}");
        }
    }
    let own = format!("Origin: http://127.0.0.1:{port}");
    assert_eq!(setup.ask("POST /bake", &[right, own], "soft").0, 200);
}

#[test]
fn a_socket_needs_the_token_and_the_whole_handshake() {
    let setup = Setup::new();
    let token = setup.token();
    for wrong in ["", "0", &token[1..], &format!("{token}0")] {
        assert_eq!(setup.ask("GET /live", &setup.upgrade(wrong), "").0, 403, "{wrong}");
    }
    let whole = setup.upgrade(&token);
    for left_out in 0..4 {
        let mut fields = whole.clone();
        fields.remove(left_out);
        assert_eq!(setup.ask("GET /live", &fields, "").0, 426, "{}", whole[left_out]);
    }
    let mut turned = whole;
    turned[4] = format!("Sec-WebSocket-Protocol: {token}, chaincell");
    assert_eq!(setup.ask("GET /live", &turned, "").0, 403);
    assert_eq!(setup.feed.pages(), 0);
}

#[test]
fn a_page_that_joins_gets_the_last_frame_and_notice_and_is_answered() {
    let setup = Setup::new();
    setup.feed.publish(vec![1]);
    setup.feed.publish(vec![2, 3]);
    setup.feed.notify("the notice".to_owned());
    let mut page = setup.open();
    assert_eq!(text(&mut page), "the notice");
    assert_eq!(frame(&mut page), [2, 3]);
    say(&mut page, "seen");
    say(&mut page, "nothing");
    say(&mut page, "pause");
    assert_eq!(text(&mut page), "heard pause");
    setup.feed.notify("the notice".to_owned());
    setup.feed.publish(vec![4]);
    assert_eq!(frame(&mut page), [4], "a notice is sent once");
    assert_eq!(*setup.heard.lock().unwrap(), ["nothing", "pause"]);
    drop(setup);
    assert_eq!(closed(&mut page), (1001, "chaincell has ended".to_owned()));
}

#[test]
fn a_slow_page_skips_to_the_newest_frame_and_delays_nobody() {
    let setup = Setup::new();
    let (mut slow, mut fast) = (setup.open(), setup.open());
    // More than the system keeps for a socket that nobody reads.
    let large = |number: u8| vec![number; 8 << 20];
    for number in 1..=20 {
        setup.feed.publish(large(number));
        assert_eq!(frame(&mut fast)[0], number);
        say(&mut fast, "seen");
    }
    assert!(frame(&mut slow)[0] < 20);
    assert_eq!(frame(&mut slow)[0], 20, "those in between are skipped");
    // It has not said that it has taken these two: no third one comes before.
    setup.feed.publish(vec![21]);
    setup.feed.publish(vec![22]);
    setup.feed.notify("still here".to_owned());
    assert_eq!(text(&mut slow), "still here");
    say(&mut slow, "seen");
    assert_eq!(frame(&mut slow), [22]);
}

#[test]
fn a_message_that_is_too_long_or_no_text_closes_its_page_alone() {
    let setup = Setup::new();
    let mut other = setup.open();
    let mut page = setup.open();
    say(&mut page, &"x".repeat(4096));
    assert_eq!(text(&mut page).len(), 4096 + "heard ".len());
    say(&mut page, &"x".repeat(4097));
    assert_eq!(closed(&mut page), (1009, "a message has at most 4 kB".to_owned()));
    let mut page = setup.open();
    page.send(Message::binary(vec![0; 8])).unwrap();
    assert_eq!(closed(&mut page).0, 1003);
    // Not masked, as no browser sends.
    let mut page = setup.open();
    page.get_mut().write_all(&[0x81, 0x01, b'x']).unwrap();
    assert!(matches!(page.read(), Err(SocketError::Protocol(_) | SocketError::Io(_))));
    setup.feed.publish(vec![7]);
    assert_eq!(frame(&mut other), [7]);
}

#[test]
fn the_ninth_page_is_told_so_and_a_closed_one_leaves_its_place() {
    let setup = Setup::new();
    setup.feed.publish(vec![5]);
    let mut pages: Vec<Page> = (0..PAGES_MAX).map(|_| setup.open()).collect();
    for page in &mut pages {
        assert_eq!(frame(page), [5]);
    }
    let (code, reason) = closed(&mut setup.open());
    assert!(code == 1013 && reason.contains("close one"), "{code} {reason}");
    assert_eq!(setup.feed.pages(), PAGES_MAX);
    drop(pages.pop());
    while setup.feed.pages() == PAGES_MAX {
        std::thread::yield_now();
    }
    assert_eq!(frame(&mut setup.open()), [5]);
}

#[test]
fn a_request_that_stops_or_is_none_is_refused_and_holds_up_nobody() {
    let setup = Setup::new();
    let mut half = setup.connect();
    half.write_all(b"GET / HTTP/1.1\r\nHost: 127").unwrap();
    let silent = setup.connect();
    let port = setup.port();
    let with =
        |rest: &str| format!("POST /bake HTTP/1.1\r\nHost: localhost:{port}\r\n{rest}\r\n\r\n");
    let cookies = format!("Cookie: {}", "x".repeat(20_000));
    let many = "A: b\r\n".repeat(65) + "C: d";
    for (bytes, status) in [
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\xff\x00\x80\r\n\r\n".to_vec(), 400),
        (b"\0\xff\0\xff\r\n\r\n".to_vec(), 400),
        (b"GET http://foreign.example/ HTTP/1.1\r\n\r\n".to_vec(), 400),
        (with(&cookies).into_bytes(), 431),
        (with(&many).into_bytes(), 431),
        (with("Content-Length: 4097").into_bytes(), 413),
        (with("Content-Length: 99999999999999999999999").into_bytes(), 413),
        (with("Content-Length: -1").into_bytes(), 400),
        (with("Content-Length: 1\r\nContent-Length: 2").into_bytes(), 400),
        (with("Transfer-Encoding: chunked").into_bytes(), 411),
    ] {
        let answer = setup.exchange(&bytes);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{status}: {answer}");
    }
    let mut answer = String::new();
    half.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 408 "), "{answer}");
    drop(silent);
    assert_eq!(setup.ask("GET /", &[], "").0, 200);
}

#[test]
fn a_stranger_that_leaves_anywhere_in_a_request_holds_nothing() {
    let setup = Setup::new();
    let mut other = setup.open();
    let fields = setup.upgrade(&setup.token()).join("\r\n");
    let port = setup.port();
    let whole = format!("GET /live HTTP/1.1\r\nHost: localhost:{port}\r\n{fields}\r\n\r\n");
    for length in (0..whole.len()).step_by(7).chain([whole.len()]) {
        let mut stream = setup.connect();
        stream.write_all(&whole.as_bytes()[..length]).unwrap();
    }
    while setup.feed.pages() > 1 || setup.server.shared.connections.load(Ordering::Relaxed) > 1 {
        std::thread::yield_now();
    }
    setup.feed.publish(vec![3]);
    assert_eq!(frame(&mut other), [3]);
}

#[test]
fn broken_frames_close_their_page_alone() {
    let setup = Setup::new();
    let mut other = setup.open();
    let masked = |head: &[u8], body: &[u8]| [head, &[0; 4], body].concat();
    let half = masked(&[0x01, 0xfe, 0x08, 0x00], &[b'x'; 2048]);
    let rest = masked(&[0x80, 0xfe, 0x08, 0x01], &[b'x'; 2049]);
    for (name, bytes) in [
        ("an unknown code", masked(&[0x83, 0x80], b"")),
        ("reserved bits", masked(&[0xf1, 0x81], b"x")),
        ("a text that is none", masked(&[0x81, 0x82], b"\xc3\x28")),
        ("a long ping", masked(&[0x89, 0xfe, 0x00, 0x7e], &[0; 126])),
        ("a ping in parts", masked(&[0x09, 0x80], b"")),
        ("a part of nothing", masked(&[0x80, 0x81], b"x")),
        ("parts that are too long together", [half.clone(), rest].concat()),
        ("a length of 2^63", masked(&[0x81, 0xff, 0x80, 0, 0, 0, 0, 0, 0, 0], b"")),
        ("half a message, and the end", half),
        ("noise", (0..999_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as u8).collect()),
    ] {
        let mut page = setup.open();
        page.get_mut().write_all(&bytes).unwrap();
        page.get_mut().shutdown(Shutdown::Write).unwrap();
        // Whatever is still sent, the end follows.
        let _ = page.get_mut().read_to_end(&mut Vec::new());
        while setup.feed.pages() > 1 {
            std::thread::yield_now();
        }
        assert!(setup.heard.lock().unwrap().is_empty(), "{name}");
    }
    setup.feed.publish(vec![4]);
    assert_eq!(frame(&mut other), [4]);
}

#[test]
fn a_crowd_of_silent_strangers_is_bounded_and_leaves_pages_alone() {
    let setup = Setup::new();
    let mut page = setup.open();
    let crowd: Vec<TcpStream> = (0..2 * CONNECTIONS_MAX).map(|_| setup.connect()).collect();
    // Those without a place are closed; the others have theirs until their time is over.
    for stream in &crowd[CONNECTIONS_MAX..] {
        assert!(matches!((&*stream).read(&mut [0]), Ok(0) | Err(_)));
    }
    for number in 1..=100 {
        setup.feed.publish(vec![number]);
        assert_eq!(frame(&mut page), [number]);
        say(&mut page, "seen");
    }
    drop(crowd);
    while setup.server.shared.connections.load(Ordering::Relaxed) > 1 {
        std::thread::yield_now();
    }
    assert_eq!(setup.ask("GET /", &[], "").0, 200);
}

#[test]
fn a_taken_port_is_refused_with_the_remedy() {
    let setup = Setup::new();
    let port = setup.port();
    let error = Server::start(port, Site::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with(&format!("`port` {port}: another program has it")), "{text}");
    assert!(text.contains("give another one"), "{text}");
}
