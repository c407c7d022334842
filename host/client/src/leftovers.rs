//! Leftovers in shared memory of programs that were killed while they made a file: half a file, or a file
//! that belongs to nothing. iceoryx2 waits for the maker, for a second or for ever, and clears up only
//! complete files. So leftovers are removed before iceoryx2 looks, and again while a program waits for it.
//!
//! | file | is a leftover if | its maker |
//! |---|---|---|
//! | shared memory | it has no length, or its owner may not read it | in its name |
//! | count of nodes, in shared memory | the same | unknown: judged by its age |
//! | a service's description | its owner may write it, or its memory is missing | a node that lists it |
//! | the same, complete | no node lists it any more | none: judged by its age |
//! | shared memory, complete | its processes are dead, it has no node or description | in its name |
//! | a node's files | one of three is missing, or its owner may not read it | in its name |
//!
//! An id is a time, a process and a count. Files that a living process is making are left alone.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, Metadata};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use iceoryx2::prelude::{Config, SemanticString};
use rustix::process::{Pid, geteuid, test_kill_process};
use rustix::time::{ClockId, clock_gettime};

use crate::memory;

/// A file of this age whose maker is unknown is abandoned: to make one takes microseconds.
const OLD: Duration = Duration::from_millis(300);
/// A process that began this long after a file is not its maker, but reuses its process id.
const LATER: Duration = Duration::from_secs(2);
/// Clock ticks of `/proc` a second, on every Linux.
const PROC_HZ: u64 = 100;
/// Permissions of a file's owner.
const OWNER_READS: u32 = 0o400;
const OWNER_WRITES: u32 = 0o200;

/// Cause that blocks the next program: a file that is still being made, or one whose memory is gone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Cause {
    /// A process has begun to make a file.
    Unfinished {
        /// The file.
        path: PathBuf,
        /// The living process, if the file names it.
        process: Option<u32>,
    },
    /// Its shared memory is gone, although a living process has it open.
    Gone {
        /// The process.
        process: u32,
    },
}

/// Folders and prefix of iceoryx2's files.
#[derive(Debug, Clone)]
pub struct Leftovers {
    memory: PathBuf,
    services: PathBuf,
    nodes: PathBuf,
    prefix: String,
}

/// A file that blocks a service.
struct Fault {
    path: PathBuf,
    details: Metadata,
    /// Living processes that may be its makers.
    makers: Vec<u32>,
    /// True if the maker is unknown: without a known living one, the file may still have one.
    is_anonymous: bool,
    /// The service, if the file is a complete description of one.
    whole: Option<String>,
}

impl Leftovers {
    pub(crate) fn of(config: &Config) -> Self {
        let path = |of: &[u8]| PathBuf::from(std::ffi::OsStr::from_bytes(of));
        Self {
            memory: memory::FOLDER.into(),
            services: path(config.global.service_dir().as_bytes()),
            nodes: path(config.global.node_dir().as_bytes()),
            prefix: config.global.prefix.to_string(),
        }
    }

    /// Removes files that no living process is making. Returns true if files of unknown makers stay until
    /// they are old enough.
    pub fn clear(&self) -> bool {
        let mut is_young_left = false;
        for fault in self.faults().into_iter().filter(|fault| fault.makers.is_empty()) {
            if fault.is_anonymous && is_young(&fault.details) {
                is_young_left = true;
            } else {
                remove_same(&fault.path, &fault.details);
            }
        }
        self.clear_nodes();
        is_young_left
    }

    /// Returns the cause for which the services of these names cannot be opened.
    pub(crate) fn cause(&self, services: &[&str]) -> Option<Cause> {
        let mut unfinished = None;
        for Fault { path, makers, whole, .. } in self.faults() {
            match (whole, makers.first()) {
                (Some(name), Some(&process)) if services.contains(&name.as_str()) => {
                    return Some(Cause::Gone { process });
                }
                (Some(_), _) => {}
                (None, process) => {
                    unfinished = Some(Cause::Unfinished { path, process: process.copied() });
                }
            }
        }
        unfinished
    }

    fn faults(&self) -> Vec<Fault> {
        // List the files. A maker lists a service first, then makes its description, then its memory.
        let services = self.files(&self.services, ".service");
        let memory = self.files(&self.memory, "");
        let (listed, nodes) = (self.listed(), self.node_ids());
        let described: Vec<Option<(String, String)>> =
            services.iter().map(|(path, _, details)| described(path, details)).collect();
        // With a description of another release of iceoryx2, which cannot be read, memory is left alone.
        let are_known =
            services.iter().zip(&described).all(|(of, id)| id.is_some() || is_begun(&of.2));
        // Shared memory: half made, or without processes and description.
        let mut faults = Vec::new();
        for (path, name, details) in &memory {
            let is_half = details.len() == 0 || details.mode() & OWNER_READS == 0;
            let is_free = match name.rsplit_once('.') {
                Some((front, "dynamic")) => {
                    are_known && !described.iter().flatten().any(|of| of.1 == last_id(front))
                }
                Some((_, kind)) => ["connection", "data"].contains(&kind),
                None => false,
            };
            let fault = of_memory(path, name, details);
            let has_node = processes_of(name).any(|process| nodes.contains(&process));
            let is_stray = is_free && !fault.is_anonymous && fault.makers.is_empty() && !has_node;
            if is_half || is_stray {
                faults.push(fault);
            }
        }
        // Descriptions: half made, without their memory, or listed by no node.
        let is_there = |id: &str| {
            memory.iter().any(|(_, name, _)| {
                name.strip_suffix(".dynamic").is_some_and(|of| last_id(of) == id)
            })
        };
        for ((path, name, details), described) in services.into_iter().zip(described) {
            let hash = name.strip_suffix(".service").unwrap_or(&name);
            let holders = listed.get(hash);
            if described.is_none() && !is_begun(&details) {
                continue;
            }
            if holders.is_some() && described.as_ref().is_some_and(|(_, id)| is_there(id)) {
                continue;
            }
            let makers: Vec<u32> = holders.into_iter().flatten().copied().collect();
            // A complete one that no node lists was about to be removed.
            let (is_anonymous, whole) = (described.is_some(), described.map(|(name, _)| name));
            faults.push(Fault { path, details, makers, is_anonymous, whole });
        }
        faults
    }

    /// Returns the services that nodes list, by their hashes, with those nodes' living processes.
    fn listed(&self) -> BTreeMap<String, Vec<u32>> {
        let mut listed: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for (path, id) in self.node_folders() {
            let Ok(details) = fs::symlink_metadata(&path) else { continue };
            let process = process_of(id);
            let living = lives(process, &details).then_some(process);
            for (_, name, _) in self.files(&path, ".service_tag") {
                let hash = name.strip_suffix(".service_tag").unwrap_or(&name);
                listed.entry(hash.to_owned()).or_default().extend(living);
            }
        }
        listed
    }

    /// Returns the processes that have nodes here, including dead ones not cleared up yet.
    fn node_ids(&self) -> BTreeSet<u32> {
        self.node_folders().into_iter().map(|(_, id)| process_of(id)).collect()
    }

    /// Removes incomplete nodes of dead processes: iceoryx2 takes them for nodes that are being made.
    fn clear_nodes(&self) {
        // Collect the files of each node.
        let mut nodes: BTreeMap<u128, Vec<(PathBuf, String, Metadata)>> = BTreeMap::new();
        for (_, id) in self.node_folders() {
            nodes.entry(id).or_default();
        }
        for file in self.files(&self.nodes, "") {
            if let Some(id) = file.1.split('.').next().and_then(|id| id.parse().ok()) {
                nodes.entry(id).or_default().push(file);
            }
        }
        // Remove the nodes whose process is dead.
        for (id, files) in nodes {
            let folder = self.nodes.join(id.to_string());
            let newest = files.iter().map(|(_, _, details)| details.clone()).max_by_key(made);
            let details = newest.or_else(|| fs::symlink_metadata(&folder).ok());
            if details.is_some_and(|details| lives(process_of(id), &details)) {
                continue;
            }
            let is_whole = files.len() == 3
                && files.iter().all(|(_, _, details)| details.mode() & OWNER_READS != 0);
            if is_whole {
                // iceoryx2 removes a complete node itself, but not one with half-made tags in its folder.
                let tags = self.files(&folder, "").into_iter();
                tags.filter(|(_, _, details)| details.mode() & OWNER_WRITES != 0)
                    .for_each(|(path, _, details)| remove_same(&path, &details));
                continue;
            }
            let _ = fs::remove_dir_all(&folder);
            files.iter().for_each(|(path, _, details)| remove_same(path, details));
        }
    }

    /// Returns the folders of nodes, with their ids.
    fn node_folders(&self) -> Vec<(PathBuf, u128)> {
        let Ok(folder) = fs::read_dir(&self.nodes) else { return Vec::new() };
        let ids = folder.flatten().filter_map(|entry| {
            let id = entry.file_name().to_str()?.parse().ok()?;
            Some((entry.path(), id))
        });
        ids.collect()
    }

    /// Returns this user's files in a folder whose names begin with the prefix and end with `ending`; each
    /// with its name after the prefix.
    fn files(&self, folder: &Path, ending: &str) -> Vec<(PathBuf, String, Metadata)> {
        let Ok(folder) = fs::read_dir(folder) else { return Vec::new() };
        let files = folder.flatten().filter_map(|entry| {
            let name = entry.file_name();
            let name = name.to_str()?.strip_prefix(&self.prefix)?;
            let details = entry.metadata().ok()?;
            let is_ours = details.is_file() && details.uid() == geteuid().as_raw();
            (is_ours && name.ends_with(ending)).then(|| (entry.path(), name.to_owned(), details))
        });
        files.collect()
    }
}

/// Judges a file of shared memory: HASH_ID.KIND, or HASH_ID_ID.KIND with the ids of both its users.
fn of_memory(path: &Path, name: &str, details: &Metadata) -> Fault {
    let processes: Vec<u32> = processes_of(name).collect();
    let is_anonymous = processes.is_empty();
    let are_alive = processes.iter().all(|&process| lives(process, details));
    let makers = if are_alive { processes } else { Vec::new() };
    Fault { path: path.to_owned(), details: details.clone(), makers, is_anonymous, whole: None }
}

/// Returns the processes of the ids in a name.
fn processes_of(name: &str) -> impl Iterator<Item = u32> {
    let ids = name.split('.').next().unwrap_or(name).split('_');
    ids.filter_map(|id| id.parse().ok()).map(process_of)
}

/// Returns the last id in a name.
fn last_id(name: &str) -> &str {
    name.rsplit('_').next().unwrap_or(name)
}

/// Returns the process of an id, which is seconds, nanoseconds, process and count of 32 bits each.
fn process_of(id: u128) -> u32 {
    (id >> 64) as u32
}

/// Returns name and id of the service in a complete description.
fn described(path: &Path, details: &Metadata) -> Option<(String, String)> {
    if is_begun(details) {
        return None;
    }
    let text = fs::read_to_string(path).ok()?;
    let value = |key: &str| {
        let of_key = |line: &str| {
            Some(line.trim().strip_prefix(key)?.trim().strip_prefix('=')?.trim().to_owned())
        };
        text.lines().find_map(of_key)
    };
    let number = |key| value(key)?.parse::<u64>().ok();
    let name = value("service_name")?.trim_matches('"').to_owned();
    let (low, high) = (number("payload_value")?, number("unique_value")?);
    Some((name, (u128::from(high) << 64 | u128::from(low)).to_string()))
}

/// Returns true if a description is half made.
fn is_begun(details: &Metadata) -> bool {
    details.mode() & OWNER_WRITES != 0 || details.len() == 0
}

/// Returns the time of the last write to a file.
fn made(details: &Metadata) -> SystemTime {
    details.modified().unwrap_or(SystemTime::UNIX_EPOCH)
}

/// Returns true if a file may still be in the making; not one from the future: the clock was set back.
fn is_young(details: &Metadata) -> bool {
    made(details).elapsed().is_ok_and(|age| age < OLD)
}

/// Returns true if the process that made a file is alive, and not another one that reuses its id.
fn lives(process: u32, details: &Metadata) -> bool {
    let Some(pid) = i32::try_from(process).ok().and_then(Pid::from_raw) else { return false };
    let is_there = test_kill_process(pid) != Err(rustix::io::Errno::SRCH);
    let Ok(stat) = fs::read_to_string(format!("/proc/{process}/stat")) else { return is_there };
    let mut fields = stat.rsplit(") ").next().unwrap_or("").split(' ');
    let has_ended = matches!(fields.next(), Some("Z" | "X"));
    let begun = fields.nth(18).and_then(|ticks| ticks.parse::<u64>().ok());
    is_there && !has_ended && begun.is_none_or(|ticks| since_boot(ticks) <= made(details) + LATER)
}

/// Returns the time `ticks` clock ticks after the start of the system.
fn since_boot(ticks: u64) -> SystemTime {
    let up = clock_gettime(ClockId::Boottime);
    let up = Duration::new(up.tv_sec.unsigned_abs(), up.tv_nsec.unsigned_abs() as u32);
    let then = Duration::from_millis(ticks.saturating_mul(1000 / PROC_HZ));
    SystemTime::now() - up.saturating_sub(then)
}

/// Removes a file, unless another one has its name now.
fn remove_same(path: &Path, details: &Metadata) {
    let is_same = |now: Metadata| (now.dev(), now.ino()) == (details.dev(), details.ino());
    if fs::symlink_metadata(path).is_ok_and(is_same) {
        let _ = fs::remove_file(path);
    }
}
