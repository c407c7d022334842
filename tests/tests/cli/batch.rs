//! `run --batch`: the bits of each job are those of the same run alone, and a run that ended early goes on.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use chaincell_tests::files::{is_hash, names, scratch, summary, text, write_path};
use chaincell_tests::process::SHORT;
use chaincell_tests::{Ended, Running, chaincell, run};
use serde_json::{Value, json};

/// A folder with models and paths.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = scratch();
        for (name, spec, options) in [
            ("links", "plane:9x9x0.01", &["--alpha", "0.02"][..]),
            ("shapes", "box:5x5x5x0.01", &["--young-pa", "5000"]),
        ] {
            let model = folder.path().join(name);
            run([&["bake", spec, "-o", text(&model)], options].concat()).with(0);
        }
        for (name, depth_m) in [("press.csv", 0.0004), ("shallow.csv", 0.0001)] {
            let row = |tick: u16| (tick.into(), [0.0, 0.0, -depth_m * f32::from(tick)], 1);
            write_path(&folder.path().join(name), (0..40).map(row));
        }
        Self { folder }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a list of jobs.
    fn list(&self, jobs: &[Value]) -> PathBuf {
        let lines: String = jobs.iter().map(|job| format!("{job}\n")).collect();
        self.write(&lines)
    }

    fn write(&self, lines: &str) -> PathBuf {
        let list = self.file("jobs.jsonl");
        fs::write(&list, lines).unwrap();
        list
    }

    /// Runs the list with its results in `results.jsonl`.
    fn batch(&self, options: &[&str]) -> Ended {
        let (list, results) = (self.file("jobs.jsonl"), self.file("results.jsonl"));
        run([&["run", "--batch", text(&list), "--results", text(&results)], options].concat())
    }

    fn results(&self) -> Vec<Value> {
        lines(&fs::read_to_string(self.file("results.jsonl")).unwrap())
    }

    /// The state hash of a job that is run alone.
    fn alone(&self, job: &Value) -> String {
        let out = tempfile::tempdir_in(self.folder.path()).unwrap();
        let mut args = vec!["run".to_owned(), "--out".into(), text(out.path()).into()];
        for (key, value) in job.as_object().unwrap() {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            match key.as_str() {
                "name" | "out" => {}
                "model" => args.push(text(&self.file(&value)).into()),
                "path" => args.push(format!("--path={}", text(&self.file(&value)))),
                key => args.push(format!("--{key}={value}")),
            }
        }
        run(args).with(0);
        summary(out.path())["state_hash"].as_str().unwrap().to_owned()
    }
}

fn lines(text: &str) -> Vec<Value> {
    assert!(text.is_empty() || text.ends_with('\n'), "{text}");
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The hashes of jobs by their names.
#[track_caller]
fn hashes(results: &[Value]) -> BTreeMap<String, String> {
    let of = |line: &Value| {
        assert!(is_hash(&line["state_hash"]), "{line}");
        let name = line["name"].as_str().unwrap().to_owned();
        (name, line["state_hash"].as_str().unwrap().to_owned())
    };
    let all: BTreeMap<String, String> = results.iter().map(of).collect();
    assert_eq!(all.len(), results.len(), "a job has two lines");
    all
}

/// Jobs of links, of shapes and of a body whose sweeps two threads may share.
fn jobs() -> Vec<Value> {
    let held = "cells:nodes:40";
    let top = "cells:nodes:64";
    vec![
        json!({"name": "a", "model": "links", "path": "press.csv", "contact": held}),
        json!({"name": "b", "model": "shapes", "path": "press.csv", "contact": top}),
        json!({"name": "c", "model": "links", "path": "shallow.csv", "contact": held, "sweeps": 3}),
        json!({"name": "d", "model": "shapes", "motion": "press", "seconds": 0.1,
            "contact": "probe:0.012", "depth-m": 0.004}),
        json!({"name": "e", "model": "links", "path": "press.csv", "contact": held,
            "precision": "fixed", "scheme": "track"}),
        json!({"name": "f", "model": "shapes", "path": "shallow.csv", "contact": top,
            "device": "omega"}),
    ]
}

#[test]
fn a_job_has_the_bits_of_its_run_alone() {
    let place = Place::new();
    let large = place.file("large");
    run(["bake", "plane:130x130x0.001", "-o", text(&large)]).with(0);
    let mut jobs = jobs();
    if std::thread::available_parallelism().unwrap().get() >= 2 {
        let job = json!({"model": "large", "motion": "press", "seconds": 0.02});
        for (name, threads) in [("one", 1), ("two", 2)] {
            let mut job = job.clone();
            job["name"] = name.into();
            job["threads"] = threads.into();
            jobs.push(job);
        }
    } else {
        println!("SKIPPED shared sweeps: there is one processor");
    }
    let name = |job: &Value| job["name"].as_str().unwrap().to_owned();
    let alone: BTreeMap<String, String> =
        jobs.iter().map(|job| (name(job), place.alone(job))).collect();
    if let (Some(one), Some(two)) = (alone.get("one"), alone.get("two")) {
        assert_eq!(one, two);
    }
    for (count, turn) in [("1", 0), ("2", 0), ("3", 3), ("2", 5)] {
        jobs.rotate_left(turn);
        let list = place.list(&jobs);
        let together = run(["run", "--batch", text(&list), "--jobs", count]).with(0);
        assert_eq!(hashes(&lines(&together.out)), alone, "--jobs {count}");
        jobs.reverse();
    }
}

#[test]
fn a_line_says_what_the_summary_says_and_the_folder_is_that_of_a_run() {
    let place = Place::new();
    place.list(&[
        json!({"model": "links", "path": "press.csv", "contact": "40", "out": "a/b"}),
        json!({"model": "links", "path": "press.csv", "contact": "40"}),
    ]);
    place.batch(&[]).with(0);
    let results = place.results();
    let summary = summary(&place.file("a/b"));
    for (key, value) in summary.as_object().unwrap() {
        if key != "step_ns" && key != "judgement" {
            assert!(results.iter().all(|line| line[key] == *value), "{key}");
        }
    }
    assert!(summary["tool_courses"][0]["largest_force_n"].as_f64().unwrap() > 0.0);
    let other = place.file("other");
    let path = place.file("press.csv");
    let model = place.file("links");
    run(["run", text(&model), "--path", text(&path), "--contact", "40", "--out", text(&other)])
        .with(0);
    let mut expected = names(&other);
    expected.push("job.json".into());
    expected.sort();
    assert_eq!(names(&place.file("a/b")), expected);
    for file in ["force.csv", "final.vtu", "session.trace", "picture.png"] {
        let of = |out: &Path| fs::read(out.join(file)).unwrap();
        assert!(of(&place.file("a/b")) == of(&other), "{file}");
    }
}

#[test]
fn a_bad_line_names_its_place_and_the_remedy_and_stops_no_other() {
    let place = Place::new();
    let good = r#"{"model":"links","path":"press.csv","contact":"40"}"#;
    fs::write(place.file("text.csv"), "tick\n").unwrap();
    let bad = [
        ("press", "give each job a line of its own"),
        ("{\"model\":\"links\"", "give each job a line of its own"),
        (r#"{"path":"press.csv"}"#, "`model` is missing: name a file of chaincell bake"),
        (r#"{"model":"links"}"#, "--path <PATH.csv>|--motion <MOTION>"),
        (
            r#"{"model":"links","path":"press.csv","depth_m":1}"#,
            "unknown key `depth_m`: write `depth-m`",
        ),
        (r#"{"model":"links","path":"press.csv","colour":1}"#, "`chaincell run --help`"),
        (r#"{"model":"links","path":"press.csv","batch":"x"}"#, "unknown key `batch`"),
        (r#"{"model":"links","path":"none.csv"}"#, "none.csv: No such file"),
        (r#"{"model":"none","path":"press.csv"}"#, "a model is made by chaincell bake"),
        (r#"{"model":"links","path":"text.csv"}"#, "text.csv:1: "),
        (r#"{"model":"press.csv","path":"press.csv"}"#, "cannot read model"),
        (r#"{"model":"links","path":"press.csv","sweeps":"x"}"#, "give a whole number"),
        (r#"{"model":"links","path":"press.csv","sweeps":0}"#, "--sweeps"),
        (
            r#"{"model":"links","path":"press.csv","sweeps":{}}"#,
            "give a text, a number or an array",
        ),
        (
            r#"{"model":"links","path":"press.csv","sweeps":null}"#,
            "give a text, a number or an array",
        ),
        (r#"{"model":"links","path":"press.csv","recorded":1}"#, "give true or false"),
        (
            r#"{"model":"links","path":"press.csv","path":"press.csv"}"#,
            "cannot be used multiple times",
        ),
        (r#"{"model":["links","links"],"path":"press.csv"}"#, "it stands once"),
        (r#"{"model":"links","path":"press.csv","name":7}"#, "`name`: give one text"),
        (r#"{"model":"links","path":"press.csv","trace":"t"}"#, "--out"),
        (r#"{"model":"links","path":"press.csv","snapshot-every":2}"#, "--out"),
        (r#"{"model":"links","path":"press.csv","contact":"9999"}"#, "9999"),
        (r#"{"model":"links","path":"press.csv","contact":"file:none.txt"}"#, "none.txt"),
        (r#"{"model":"links","path":"press.csv","out":"links"}"#, "a file is there: name a folder"),
        ("\"text\"", "give each job a line of its own"),
    ];
    let mut list = format!("{good}\n\n");
    list.extend(bad.iter().map(|(line, _)| format!("{line}\n")));
    list += good;
    place.write(&list);
    let ended = place.batch(&["--jobs", "2"]).with(1);
    let results = place.results();
    let said = format!("27 jobs: 2 done, 0 done before, {} failed", bad.len());
    assert!(ended.err.contains(&said), "{}", ended.err);
    assert!(
        ended.err.contains("of 27 jobs failed, first ") && ended.err.contains("jobs.jsonl:3: ")
    );
    for (number, (line, part)) in (3..).zip(bad) {
        let found = results.iter().find(|result| result["job"] == number).unwrap();
        let error = found["error"].as_str().unwrap();
        let front = format!("{}:{number}: ", text(&place.file("jobs.jsonl")));
        assert!(error.starts_with(&front) && error.contains(part), "{line}: {error}");
        assert!(!error.contains('\n') && found.get("state_hash").is_none(), "{found}");
    }
    let done = |line: u64| results.iter().find(|result| result["job"] == line).unwrap().clone();
    assert!(is_hash(&done(1)["state_hash"]));
    assert_eq!(done(1)["state_hash"], done(28)["state_hash"]);
}

#[test]
fn two_jobs_share_neither_a_name_nor_a_place() {
    let place = Place::new();
    let job = |more: Value| {
        let mut job = json!({"model": "links", "path": "press.csv", "contact": "40"});
        job.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        job
    };
    place.list(&[
        job(json!({"name": "a", "out": "x"})),
        job(json!({"name": "a"})),
        job(json!({"out": "./x"})),
        job(json!({"out": "y", "picture": "off"})),
        job(json!({"out": "z", "picture": "off"})),
        job(json!({"out": "z/../x/."})),
        job(json!({"out": 7})),
        job(json!({"out": "7"})),
        job(json!({"out": ["w"]})),
        job(json!({"contact": ["cells:file:ids.txt"]})),
    ]);
    place.batch(&["--jobs", "2"]).with(1);
    let mut results = place.results();
    results.sort_by_key(|line| line["job"].as_u64());
    let error = |line: usize| results[line - 1]["error"].as_str().unwrap_or_default().to_owned();
    assert!(error(2).contains("line 1 has it: give each job its own"), "{}", error(2));
    assert!(error(3).contains("line 1 writes there: name another place"), "{}", error(3));
    assert!(error(6).contains("line 1 writes there"), "{}", error(6));
    assert!(error(8).contains("line 7 writes there"), "{}", error(8));
    // An array stands for an option that may stand several times.
    assert!(error(9).contains("`out` [\"w\"]: it stands once"), "{}", error(9));
    assert!(error(10).contains("it stands once"), "{}", error(10));
    assert_eq!([1, 4, 5, 7].map(error), [const { String::new() }; 4]);
    assert!(!place.file("y/picture.png").exists() && place.file("x/picture.png").exists());
}

#[test]
fn a_job_that_was_done_is_passed_over_until_its_inputs_change() {
    let place = Place::new();
    let mut jobs = jobs();
    jobs[0]["out"] = "out".into();
    place.list(&jobs);
    place.batch(&[]).with(0);
    let first = hashes(&place.results());
    let again = |expected: &str| {
        let ended = place.batch(&[]).with(0);
        assert!(ended.err.contains(expected), "{}", ended.err);
        place.results()
    };
    assert_eq!(again("0 done, 6 done before").len(), 6);
    // Another order, and files elsewhere with the same content.
    jobs.reverse();
    fs::rename(place.file("shallow.csv"), place.file("moved.csv")).unwrap();
    for job in jobs.iter_mut().filter(|job| job["path"] == "shallow.csv") {
        job["path"] = "moved.csv".into();
    }
    place.list(&jobs);
    assert_eq!(again("0 done, 6 done before").len(), 6);
    // Another option, another path, another model, results that have gone.
    jobs[3]["sweeps"] = 4.into();
    place.list(&jobs);
    again("1 done, 5 done before");
    let moved = fs::read_to_string(place.file("moved.csv")).unwrap();
    fs::write(place.file("moved.csv"), moved.replace("39,0.0", "39,0.001")).unwrap();
    again("2 done, 4 done before");
    fs::remove_dir_all(place.file("out")).unwrap();
    again("1 done, 5 done before");
    let model = place.file("links");
    run(["bake", "plane:9x9x0.01", "--alpha", "0.03", "-o", text(&model)]).with(0);
    let ended = place.batch(&[]).with(1);
    // The folder of the earlier inputs stays until it may go.
    assert!(ended.err.contains("2 done, 3 done before, 1 failed"), "{}", ended.err);
    assert!(ended.err.contains("--force"), "{}", ended.err);
    for job in jobs.iter_mut().filter(|job| job["name"] == "a") {
        job["force"] = true.into();
    }
    place.list(&jobs);
    let last = again("1 done, 5 done before");
    assert_eq!(again("0 done, 6 done before").len(), last.len());
    assert_ne!(last.last().unwrap()["state_hash"], Value::from(first["a"].clone()));
}

/// A batch that is killed at any moment, or stopped, goes on where it was, and ends with the same hashes.
#[test]
fn a_batch_that_ended_early_goes_on() {
    let place = Place::new();
    let jobs: Vec<Value> = (0..12)
        .map(|number| {
            json!({"name": format!("{number}"), "model": "shapes", "motion": "press", "seconds": 0.3,
                "contact": "probe:0.012", "depth-m": 0.001 + 2e-4 * f64::from(number),
                "out": format!("out/{number}")})
        })
        .collect();
    let list = place.list(&jobs);
    let results = place.file("results.jsonl");
    let args = ["run", "--batch", text(&list), "--results", text(&results), "--jobs", "2"];
    let is_written = |lines: usize| {
        fs::read(&results)
            .is_ok_and(|text| text.iter().filter(|byte| **byte == b'\n').count() >= lines)
    };
    let until = |running: &mut Running, lines: usize| {
        while running.is_running() && !is_written(lines) {
            std::thread::yield_now();
        }
    };
    for lines in [1, 4] {
        let mut running = Running::chaincell(args);
        until(&mut running, lines);
        running.kill();
        let mut file = fs::OpenOptions::new().append(true).open(&results).unwrap();
        file.write_all(b"{\"job\":9,\"na").unwrap();
    }
    let mut running = Running::chaincell(args);
    until(&mut running, 7);
    let ended = running.interrupt().with(130);
    assert!(ended.err.contains("the results so far are in"), "{}", ended.err);
    run(args).with(0);
    let found = hashes(&place.results());
    fs::remove_file(&results).unwrap();
    let fresh: Vec<Value> = jobs
        .into_iter()
        .map(|mut job| {
            job.as_object_mut().unwrap().remove("out");
            job
        })
        .collect();
    place.list(&fresh);
    place.batch(&["--jobs", "1"]).with(0);
    assert_eq!(found, hashes(&place.results()));
    assert_eq!(found.len(), 12);
    for number in 0..12 {
        let out = place.file(&format!("out/{number}"));
        assert_eq!(summary(&out)["state_hash"], Value::from(found[&number.to_string()].clone()));
        assert_eq!(summary(&out)["interrupted"], false);
    }
}

#[test]
fn a_list_may_come_from_standard_input() {
    let place = Place::new();
    let list = place.list(&jobs());
    let mut command = chaincell();
    command.args(["run", "--batch", "-"]).current_dir(place.folder.path());
    command.stdin(fs::File::open(&list).unwrap());
    let ended = command.output().unwrap();
    assert!(ended.status.success());
    let said = String::from_utf8(ended.stdout).unwrap();
    let direct = run(["run", "--batch", text(&list)]).with(0);
    assert_eq!(hashes(&lines(&said)), hashes(&lines(&direct.out)));
}

#[test]
fn what_is_no_list_and_where_no_results_can_be() {
    let place = Place::new();
    let list = place.list(&jobs());
    let refused = |args: &[&str], parts: &[&str]| {
        let err = run([&["run", "--batch"], args].concat()).with(2).err;
        assert!(parts.iter().all(|part| err.contains(part)), "{args:?}: {err}");
    };
    let none = place.file("none");
    refused(&[text(&none)], &["none: No such file"]);
    refused(&[text(place.folder.path())], &["it is a folder: give a file"]);
    refused(&[text(&place.file("links"))], &["it is no UTF-8 text"]);
    let array = place.file("array.json");
    fs::write(&array, " [{}]").unwrap();
    refused(&[text(&array)], &["jq -c '.[]'"]);
    refused(&[text(&list), "--results", text(&list)], &["it is the input"]);
    let press = place.file("press.csv");
    let before = fs::read(&press).unwrap();
    refused(&[text(&list), "--results", text(&press)], &["press.csv:1: no result of a batch"]);
    assert_eq!(fs::read(&press).unwrap(), before);
    refused(&[text(&list), "--results", text(&none.join("results"))], &["cannot write"]);
    refused(&[text(&list), "--sweeps", "3"], &["--batch", "--sweeps"]);
    refused(&[text(&list), "--motion", "press"], &["--batch", "--motion"]);
    refused(&[text(&list), "--out", "x"], &["--batch", "--out"]);
    refused(&[text(&list), "--jobs", "0"], &["--jobs"]);
    let alone = ["run", "m", "--motion", "press", "--out", "x", "--jobs", "2"];
    assert!(run(alone).with(2).err.contains("--jobs <N>"));
    assert!(run(["run", "--results", "x"]).with(2).err.contains("--batch"));
    assert!(run(["run", "m", "--motion", "press"]).with(2).err.contains("--out"));
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = chaincell();
    let ended = command.args(["run", "--batch", text(&list)]).stdin(Stdio::null()).stdout(full);
    let ended = ended.output().unwrap();
    assert_eq!(ended.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&ended.stderr).contains("cannot write to standard output"));
}

#[test]
fn results_on_a_full_disk_stay_whole_and_go_on() {
    let place = Place::new();
    let job = json!({"model": "links", "path": "press.csv", "contact": "40"});
    place.list(&vec![job; 40]);
    let lines_of = |size: &str| {
        format!(
            "mkdir -p disk && mount -t tmpfs -o size={size} none disk || exit 99; \
             cat results.jsonl > disk/results.jsonl 2>/dev/null; \
             \"$chaincell\" \"$@\"; code=$?; cp disk/results.jsonl .; exit $code"
        )
    };
    let args = ["run", "--batch", "jobs.jsonl", "--results", "disk/results.jsonl"];
    let run_on = |size: &str| {
        let test = "results_on_a_full_disk_stay_whole_and_go_on";
        let mut command =
            chaincell_tests::process::unshared(test, place.folder.path(), &lines_of(size))?;
        Some(Running::start(command.args(args)).end(SHORT))
    };
    let Some(ended) = run_on("32k") else { return };
    let ended = ended.with(2);
    assert!(ended.err.contains("cannot write disk/results.jsonl"), "{}", ended.err);
    assert!(ended.err.contains("make room and run it again"), "{}", ended.err);
    let count = place.results().len();
    assert!((1..40).contains(&count), "{count}");
    run_on("1m").unwrap().with(0);
    let results = place.results();
    assert_eq!(results.len(), 40);
    assert!(results.iter().all(|line| line["state_hash"] == results[0]["state_hash"]));
}
