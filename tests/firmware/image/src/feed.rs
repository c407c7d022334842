//! The position interrupt: a sample of the motion each millisecond, handed to the loop.

use core::cell::Cell;
use core::sync::atomic::{AtomicU32, Ordering};

use chaincell_kernel::ToolPose;
use chaincell_kernel::handover::SampleQueue;
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer};
use static_cell::ConstStaticCell;

use crate::scene::SCENE;

static QUEUE: ConstStaticCell<SampleQueue<8>> = ConstStaticCell::new(SampleQueue::new());
static SENSOR: Mutex<Cell<Option<Sensor>>> = Mutex::new(Cell::new(None));
static LATE: AtomicU32 = AtomicU32::new(0);

/// What the interrupt owns.
struct Sensor {
    queue: Producer<'static, ToolPose>,
    next: u32,
    end: u32,
}

/// Starts a motion of `ticks` samples; the end that the loop reads. `None` the second time.
pub fn start(ticks: u32) -> Option<Consumer<'static, ToolPose>> {
    let (queue, samples) = QUEUE.try_take()?.split();
    let sensor = Sensor { queue, next: 0, end: ticks };
    critical_section::with(|token| SENSOR.borrow(token).set(Some(sensor)));
    Some(samples)
}

/// The interrupt. A sample that finds the queue full waits for the next one: an emulated core
/// may be slower than its device, and every image is to play the same motion.
pub fn due() {
    critical_section::with(|token| {
        let place = SENSOR.borrow(token);
        let Some(mut sensor) = place.take() else { return };
        if sensor.next < sensor.end {
            if sensor.queue.enqueue(SCENE.sample(sensor.next)).is_ok() {
                sensor.next += 1;
            } else {
                LATE.fetch_add(1, Ordering::Relaxed);
            }
        }
        place.set(Some(sensor));
    });
}

/// Interrupts that found the queue full.
pub fn late() -> u32 {
    LATE.load(Ordering::Relaxed)
}
