//! The command as a process that always ends: built once, killed when its time is up.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

/// Longest life of a command that has little to do.
pub const SHORT: Duration = Duration::from_secs(60);
/// Span between looks at a process.
const LOOK: Duration = Duration::from_millis(2);
/// Longest wait for the output of a process that has ended.
const LAST_WORDS: Duration = Duration::from_secs(10);

/// The `chaincell` binary of this build's profile, brought up to date once.
fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| {
        // <target>/<profile>/deps/<test>
        let test = std::env::current_exe().unwrap();
        let profile_folder = test.parent().and_then(Path::parent).unwrap();
        let target = profile_folder.parent().unwrap();
        let profile = if cfg!(debug_assertions) { "dev" } else { "release" };
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let built = Command::new(cargo)
            .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap())
            .args(["build", "--locked", "--offline", "--quiet", "--profile", profile])
            // The whole workspace selects the same features as its tests: nothing is built twice.
            .args(["--workspace", "--bin", "chaincell", "--bin", "chaincell-lab"])
            .arg("--target-dir")
            .arg(target)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        let binary = profile_folder.join("chaincell");
        assert!(binary.is_file(), "no {}", binary.display());
        binary
    })
}

/// A command line that starts with the `chaincell` of this build.
#[must_use]
pub fn chaincell() -> Command {
    let mut command = Command::new(binary());
    command.env_remove("CHAINCELL_LOG").env_remove("IOX2_LOG_LEVEL");
    command
}

/// A copy of `chaincell` in a folder. Another process makes it: in this one it could still be open for writing
/// in a child that another test starts, and does not run then.
#[track_caller]
#[must_use]
pub fn copied(folder: &Path) -> PathBuf {
    let copy = folder.join("chaincell");
    let made = Command::new("cp").arg(binary()).arg(&copy).status().unwrap();
    assert!(made.success(), "no copy {}", copy.display());
    copy
}

/// A shell with a mount namespace of its own in a folder: it runs `lines`, where `$chaincell` is the command
/// and `$@` are the arguments to come. `None`, with a line that says so, where this user may not.
#[must_use]
pub fn unshared(test: &str, folder: &Path, lines: &str) -> Option<Command> {
    let may = Command::new("unshare").args(["-m", "true"]).output();
    if !may.is_ok_and(|tried| tried.status.success()) {
        println!("SKIPPED {test}: `unshare -m` is not permitted");
        return None;
    }
    let mut command = Command::new("unshare");
    command.args(["-m", "--propagation", "private", "sh", "-c", lines, "sh"]);
    command.current_dir(folder).env("chaincell", chaincell().get_program());
    Some(command)
}

/// How a process ended.
#[derive(Debug)]
pub struct Ended {
    /// Exit code, `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Ended {
    /// The process ended with this exit code and without a panic.
    #[track_caller]
    pub fn with(self, code: i32) -> Self {
        assert!(!self.err.contains("panicked"), "{}", self.err);
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// Standard output as one JSON object, or its last line where several are printed.
    #[track_caller]
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(self.out.lines().last().unwrap_or_default()).unwrap()
    }
}

/// Runs `chaincell` to its end.
#[track_caller]
pub fn run(args: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Ended {
    Running::start(chaincell().args(args)).end(SHORT)
}

/// A process under way; killed when this is dropped.
#[derive(Debug)]
pub struct Running {
    child: Child,
    out: Stream,
    err: Stream,
}

impl Running {
    /// Starts `chaincell` with arguments.
    #[track_caller]
    pub fn chaincell(args: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Self {
        Self::start(chaincell().args(args))
    }

    /// Starts a command with its output collected.
    #[track_caller]
    pub fn start(command: &mut Command) -> Self {
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let out = Stream::of(child.stdout.take().unwrap());
        let err = Stream::of(child.stderr.take().unwrap());
        Self { child, out, err }
    }

    /// Waits for a line on standard output.
    #[track_caller]
    pub fn wait_for_line(&mut self, line: &str) {
        let start = Instant::now();
        while !self.out.text.lines().any(|text| text == line) {
            let left = SHORT.saturating_sub(start.elapsed());
            assert!(self.out.take(left), "no line `{line}`: {:?} {:?}", self.out, self.err.all());
        }
    }

    /// The lines on standard output so far.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.out.text.lines()
    }

    /// Waits for a line on standard error; all lines up to it.
    #[track_caller]
    pub fn notes_until(&mut self, line: &str) -> Vec<String> {
        let start = Instant::now();
        while !self.err.text.lines().any(|text| text == line) {
            let left = SHORT.saturating_sub(start.elapsed());
            assert!(self.err.take(left), "no line `{line}`: {:?} {:?}", self.err, self.out.all());
        }
        self.err.text.lines().map(str::to_owned).collect()
    }

    /// Process id.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether the process has not ended.
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        kill_process(self.pid(), signal).unwrap();
    }

    /// Kills it, and waits until it is gone.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Ctrl-C, and how the process then ended.
    #[track_caller]
    pub fn interrupt(self) -> Ended {
        self.signal(Signal::INT);
        self.end(SHORT)
    }

    /// Ctrl-C of the terminal for a process that leads a group: the whole group gets it.
    #[track_caller]
    pub fn interrupt_group(self) -> Ended {
        kill_process_group(self.pid(), Signal::INT).unwrap();
        self.end(SHORT)
    }

    fn pid(&self) -> Pid {
        Pid::from_raw(i32::try_from(self.child.id()).unwrap()).unwrap()
    }

    /// Waits for the end; one that takes longer is killed and fails the test.
    #[track_caller]
    pub fn end(mut self, at_most: Duration) -> Ended {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            if start.elapsed() > at_most {
                self.child.kill().unwrap();
                panic!("no end after {at_most:?}: {} {}", self.out.all(), self.err.all());
            }
            std::thread::sleep(LOOK);
        };
        Ended { code: status.code(), out: self.out.all(), err: self.err.all() }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail only for a process that has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Output of a process, read by a thread of its own so that no pipe ever fills up.
#[derive(Debug)]
struct Stream {
    lines: Receiver<Vec<u8>>,
    text: String,
}

impl Stream {
    fn of(pipe: impl Read + Send + 'static) -> Self {
        let (sender, lines) = mpsc::channel();
        std::thread::spawn(move || {
            let mut reader = BufReader::new(pipe);
            loop {
                let mut line = Vec::new();
                match reader.read_until(b'\n', &mut line) {
                    Ok(1..) if sender.send(line).is_ok() => {}
                    _ => return,
                }
            }
        });
        Self { lines, text: String::new() }
    }

    /// Takes a line; false at the end of the stream or of the time.
    fn take(&mut self, at_most: Duration) -> bool {
        match self.lines.recv_timeout(at_most) {
            Ok(line) => {
                self.text.push_str(&String::from_utf8_lossy(&line));
                true
            }
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => false,
        }
    }

    /// All of it, once the process has ended.
    fn all(&mut self) -> String {
        while self.take(LAST_WORDS) {}
        std::mem::take(&mut self.text)
    }
}
