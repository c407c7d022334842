//! A relay between hand and agent that delays, loses and cuts.

use std::collections::VecDeque;
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What the relay does at present.
#[derive(Debug, Default)]
pub struct Weather {
    /// Delay of each way [us].
    pub delay_us: AtomicU64,
    /// Of ten datagrams to the agent these many at the end are lost.
    pub lost_of_ten: AtomicU64,
    /// Nothing passes.
    pub is_cut: AtomicBool,
    has_ended: AtomicBool,
}

/// A running relay; it ends when this is dropped.
pub struct Relay {
    /// For the hand.
    pub address: String,
    /// To be changed at any time.
    pub weather: Arc<Weather>,
    thread: Option<JoinHandle<()>>,
}

impl Relay {
    /// Passes datagrams to an agent and back.
    pub fn start(agent: &str, delay_us: u64) -> Self {
        let [front, rear] = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
        rear.connect(agent).unwrap();
        [&front, &rear].iter().for_each(|socket| socket.set_nonblocking(true).unwrap());
        let address = front.local_addr().unwrap().to_string();
        let weather = Arc::new(Weather { delay_us: delay_us.into(), ..Weather::default() });
        let seen = Arc::clone(&weather);
        let thread = Some(std::thread::spawn(move || pass(&front, &rear, &seen)));
        Self { address, weather, thread }
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.weather.has_ended.store(true, Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn pass(front: &UdpSocket, rear: &UdpSocket, weather: &Weather) {
    let (mut hand, mut count) = (None::<SocketAddr>, 0u64);
    let mut under_way: [VecDeque<(Instant, Vec<u8>)>; 2] = Default::default();
    let mut buffer = [0; 2048];
    while !weather.has_ended.load(Relaxed) {
        let is_cut = weather.is_cut.load(Relaxed);
        let due = Instant::now() + Duration::from_micros(weather.delay_us.load(Relaxed));
        while let Ok((length, from)) = front.recv_from(&mut buffer) {
            (hand, count) = (Some(from), count + 1);
            if !is_cut && count % 10 < 10 - weather.lost_of_ten.load(Relaxed) {
                under_way[0].push_back((due, buffer[..length].to_vec()));
            }
        }
        while let Ok(length) = rear.recv(&mut buffer) {
            if !is_cut {
                under_way[1].push_back((due, buffer[..length].to_vec()));
            }
        }
        let is_due = |(due, _): &(Instant, Vec<u8>)| *due <= Instant::now();
        while under_way[0].front().is_some_and(is_due) {
            let _ = rear.send(&under_way[0].pop_front().unwrap().1);
        }
        while under_way[1].front().is_some_and(is_due) {
            let (_, bytes) = under_way[1].pop_front().unwrap();
            let _ = hand.map(|hand| front.send_to(&bytes, hand));
        }
        std::thread::sleep(Duration::from_micros(50));
    }
}
