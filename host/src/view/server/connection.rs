//! One connection: reads its request, checks it, and answers.

use std::io;
use std::net::TcpStream;

use super::access::Access;
use super::refusal::Refusal;
use super::request::Request;
use super::response::{Kind, refuse, refuse_in_words, respond};
use super::site::Site;
use super::socket;

/// Path of the WebSocket.
const LIVE: &str = "/live";

/// Answers the request of a connection.
///
/// # Errors
/// A connection that fails.
pub(super) fn answer(stream: &TcpStream, access: &Access, site: &Site) -> io::Result<()> {
    let request = match Request::read(stream) {
        Ok(Some(request)) => request,
        Ok(None) => return Ok(()),
        Err(refusal) => return refuse(stream, &refusal),
    };
    match route(stream, &request, access, site) {
        Ok(answered) => answered,
        Err(refusal) => refuse(stream, &refusal),
    }
}

fn route(
    stream: &TcpStream,
    request: &Request,
    access: &Access,
    site: &Site,
) -> Result<io::Result<()>, Refusal> {
    access.check_place(request)?;
    let (method, path) = (request.method.as_str(), request.path.as_str());
    // The page is no secret: it asks for all others with the token.
    if path == "/" {
        return match method {
            "GET" => Ok(respond(stream, Kind::Html, &site.page)),
            _ => Err(Refusal::WRONG_METHOD),
        };
    }
    if path == LIVE {
        access.check_protocols(request)?;
        let live = site.live.as_ref().ok_or(Refusal::NOT_FOUND)?;
        let key = socket::key(request)?;
        return Ok(socket::serve(stream, key, live));
    }
    access.check_bearer(request)?;
    if let Some((_, bytes)) = site.files.iter().find(|(own, _)| *own == path) {
        return match method {
            "GET" => Ok(respond(stream, Kind::Gzip, bytes)),
            _ => Err(Refusal::WRONG_METHOD),
        };
    }
    let (_, post) = site.posts.iter().find(|(own, _)| *own == path).ok_or(Refusal::NOT_FOUND)?;
    if method != "POST" {
        return Err(Refusal::WRONG_METHOD);
    }
    Ok(match post(&request.body) {
        Ok(bytes) => respond(stream, Kind::Gzip, &bytes),
        Err(text) => refuse_in_words(stream, "422 Unprocessable Content", &text),
    })
}
