//! What a server shows.

use std::fmt;
use std::sync::Arc;

use super::feed::Feed;

/// Answers the body of a request, or refuses it in words.
pub type Answer = Box<dyn Fn(&[u8]) -> Result<Vec<u8>, String> + Send + Sync>;
/// Answers a message of a page, `None` for no answer.
pub type Reply = Box<dyn Fn(&str) -> Option<String> + Send + Sync>;

/// The page and all that it asks for.
#[derive(Default)]
pub struct Site {
    /// The page, shown to anybody on this machine: it has no secret.
    pub page: Vec<u8>,
    /// Files by their paths.
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// Work by the path that a body is posted to.
    pub posts: Vec<(&'static str, Answer)>,
    /// A running scene.
    pub live: Option<Live>,
}

/// A running scene.
pub struct Live {
    /// Its frames and notices.
    pub feed: Arc<Feed>,
    /// Takes the messages of pages.
    pub reply: Reply,
}

impl fmt::Debug for Site {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let files: Vec<&str> = self.files.iter().map(|(path, _)| *path).collect();
        let posts: Vec<&str> = self.posts.iter().map(|(path, _)| *path).collect();
        let mut shown = to.debug_struct("Site");
        shown.field("files", &files).field("posts", &posts);
        shown.field("is_live", &self.live.is_some()).finish_non_exhaustive()
    }
}

impl fmt::Debug for Live {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.debug_struct("Live").field("feed", &self.feed).finish_non_exhaustive()
    }
}
