//! `chaincell-haply`: options, connections, and the report.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use chaincell_client::clock::{SECOND_NS, now_ns, span_ns};
use chaincell_client::{Client, Options as ClientOptions};
use chaincell_haply::drive::{Options, Service, drive};
use chaincell_haply::frame::Frame;
use chaincell_haply::link::Link;
use chaincell_haply::message::{ForceKey, devices};
use chaincell_haply::scene::Monotonic;
use clap::Parser;

/// Time without an answer of the tissue after which its force falls, and in which it falls \[ms\].
const ANSWER_MS: u32 = 10;
/// Longest wait for the service's first message \[ns\].
const FIRST_NS: u64 = 2 * SECOND_NS;

/// Drive a Haply Inverse3 by a served scene.
#[derive(Debug, Parser)]
#[command(
    name = "chaincell-haply",
    version,
    after_help = "Examples:\n  \
    chaincell serve liver.chaincell --tool sphere:0.012 --scene left &\n  \
    chaincell-haply --scene left --origin=0,0.12,-0.05 --frame x,y,z --scale 1\n\n\
    The force is off until the tissue has answered and 100 states in a row were good, and on every doubt.\n\
    Ctrl-C lets it fall along a ramp. Exit codes: 0 ended, 1 service or tissue lost, 2 bad usage or nobody there."
)]
struct Args {
    /// Name of the scene, as given to `chaincell serve`
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Address of the Haply service
    #[arg(long, value_name = "ws://HOST:PORT", default_value = "ws://localhost:10001")]
    service: String,
    /// Device of the service [default: the first Inverse3]
    #[arg(long, value_name = "ID")]
    device: Option<String>,
    /// Axes of the device along the scene's x, y and z
    #[arg(long, value_name = "AXES", default_value = "x,y,z", allow_hyphen_values = true)]
    frame: String,
    /// Scene metres of a device metre; forces on the hand are scaled likewise
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true)]
    scale: f32,
    /// Position of the device's zero in the scene [m]
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true)]
    origin: String,
    /// Largest force on the hand [N], at most 20
    #[arg(long, value_name = "N", default_value_t = 2.0, allow_negative_numbers = true)]
    max_force_n: f32,
    /// Fastest motion of a hand [m/s], at most 20: a faster one, beyond 5 mm, is a jump
    #[arg(long, value_name = "V", default_value_t = 3.0, allow_negative_numbers = true)]
    max_speed_m_per_s: f32,
    /// Name of the force in messages: values for service 3.1 to 3.4
    #[arg(long, value_enum, default_value_t)]
    force_key: ForceKey,
    /// Longest wait for `chaincell serve` [s]
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
    wait_for_server_s: f64,
    /// End after this time [s]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(code) => ExitCode::from(code),
        Err(text) => {
            eprintln!("chaincell-haply: {text}");
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args) -> Result<u8, String> {
    let asked = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&asked);
    ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed))
        .map_err(|why| format!("cannot catch Ctrl-C: {why}"))?;
    let stop = || asked.load(Ordering::Relaxed);
    // Options first, then the service, then the tissue.
    let mut options = options(args)?;
    let wait_ns = span_ns("--wait-for-server-s", args.wait_for_server_s);
    let client_options = ClientOptions {
        scene: args.scene.clone(),
        server_wait_ns: wait_ns.map_err(|why| why.to_string())?,
        watchdog_ms: ANSWER_MS,
        ramp_ms: ANSWER_MS,
        ..ClientOptions::default()
    };
    let mut link = Link::open(&args.service)?;
    options.device_id = device(&mut link, args)?;
    let mut client =
        Client::open_unless(&client_options, stop).map_err(|why| format!("scene: {why}"))?;
    eprintln!("chaincell-haply: device {} of {}", options.device_id, args.service);
    let say = |doubt| eprintln!("chaincell-haply: {doubt}");
    let report = drive(&mut link, &mut client, &Monotonic, &options, stop, say);
    if args.json {
        println!("{}", report.to_json());
    } else {
        println!("{report}");
    }
    let code = report.ended.exit_code();
    if code != 0 {
        eprintln!("chaincell-haply: {}", report.ended);
    }
    Ok(code)
}

fn options(args: &Args) -> Result<Options, String> {
    for (option, value) in
        [("--max-force-n", args.max_force_n), ("--max-speed-m-per-s", args.max_speed_m_per_s)]
    {
        if !(value > 0.0 && value <= 20.0) {
            return Err(format!("{option} {value}: must be above 0 and at most 20"));
        }
    }
    let seconds = args.seconds.map(|seconds| span_ns("--seconds", seconds)).transpose();
    Ok(Options {
        device_id: String::new(),
        force_key: args.force_key,
        frame: Frame::new(&args.frame, args.scale, origin(&args.origin)?)?,
        max_force_n: args.max_force_n,
        max_speed_m_per_s: args.max_speed_m_per_s,
        end_ns: seconds.map_err(|why| why.to_string())?,
    })
}

fn origin(text: &str) -> Result<[f32; 3], String> {
    let numbers: Result<Vec<f32>, _> =
        text.split(',').map(|number| number.trim().parse()).collect();
    let numbers = numbers.ok().and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    numbers.ok_or_else(|| format!("--origin {text}: give three numbers in metres, as 0,0.12,-0.05"))
}

/// Chooses the device of the service's first message.
fn device(link: &mut Link, args: &Args) -> Result<String, String> {
    let first =
        link.receive(now_ns() + FIRST_NS).map_err(|why| format!("{}: {why}", args.service))?;
    let Some(first) = first else {
        return Err(format!(
            "{} lists no devices within 2 s: is it the Haply service 3.1 or newer?",
            args.service
        ));
    };
    let ids = devices(&first).map_err(|doubt| format!("{}: {doubt}", args.service))?;
    let chosen = match &args.device {
        Some(wanted) => ids.iter().find(|id| *id == wanted),
        None => ids.first(),
    };
    chosen.cloned().ok_or_else(|| {
        let listed = if ids.is_empty() { "none".to_owned() } else { ids.join(", ") };
        format!("the service lists no such Inverse3 (it has: {listed}): plug one in, or name it with --device ID")
    })
}
