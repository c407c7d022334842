//! An engine and, now and then, the same without vector unit and sleep: the same bits.

use arbitrary::{Result, Unstructured};
use chaincell_host::engine::Engine;
use chaincell_kernel::trace::Command;

/// Both, the second where there is one.
pub(super) struct Twins<'m> {
    pub engine: Engine<'m>,
    pub twin: Option<Engine<'m>>,
}

impl<'m> Twins<'m> {
    /// An engine with a twin in a session of four.
    pub fn new(
        engine: Engine<'m>,
        mut twin: Engine<'m>,
        bytes: &mut Unstructured<'_>,
    ) -> Result<Self> {
        plain(&mut twin);
        Ok(Self { engine, twin: bytes.ratio(1, 4)?.then_some(twin) })
    }

    /// Changes both.
    pub fn both(&mut self, mut change: impl FnMut(&mut Engine<'_>)) {
        change(&mut self.engine);
        self.twin.as_mut().into_iter().for_each(change);
    }

    /// Carries out the command of these words, whatever comes of it, and says so; words that are none, or
    /// ask for more sweeps than that, ask for a snapshot.
    pub fn command(&mut self, words: [u32; 3], sweeps_max: u16) -> bool {
        let command = Command::from_words(words).ok();
        let is_slow = |of: &Command| matches!(of, Command::Sweeps(sweeps) if *sweeps > sweeps_max);
        let Some(command) = command.filter(|of| !is_slow(of)) else {
            self.go_on_from_a_snapshot();
            return false;
        };
        self.obey(&command);
        true
    }

    fn obey(&mut self, command: &Command) {
        self.both(|engine| {
            let _ = engine.obey(command);
        });
        if let (Command::Reset, Some(twin)) = (command, &mut self.twin) {
            plain(twin);
        }
    }

    /// The twin goes on from what the engine saves, in memory of another life, while the engine just
    /// goes on; without a twin the engine goes on from it.
    fn go_on_from_a_snapshot(&mut self) {
        let bytes = self.engine.save().unwrap();
        assert_eq!(self.engine.save().unwrap(), bytes);
        let Some(twin) = &mut self.twin else { return self.engine.restore(&bytes).unwrap() };
        twin.reset().unwrap();
        let far = vec![[-3.0, 0.5, 2.0]; twin.network().model().cells()];
        twin.set_positions(&far).unwrap();
        twin.restore(&bytes).unwrap();
        assert_eq!(twin.save().unwrap(), bytes);
        twin.go_scalar();
    }

    /// Every cell at once somewhere else, as far as 10^`decades` mean link lengths from the body.
    pub fn displace(&mut self, bytes: &mut Unstructured<'_>, decades: i32) -> Result<()> {
        let model = *self.engine.network().model();
        let seed = bytes.arbitrary::<[i8; 4]>()?;
        let scale = 10_f32.powi(bytes.int_in_range(-6..=decades)?);
        let keep = f32::from(bytes.arbitrary::<i8>()?) / 64.0;
        let positions: Vec<[f32; 3]> = (0..model.cells())
            .map(|cell| {
                let rest = model.rest_position(cell);
                [0, 1, 2].map(|axis| {
                    let noise = f32::from(seed[(3 * cell + axis + cell / 5) % 4]) / 128.0;
                    keep * rest[axis] + scale * noise
                })
            })
            .collect();
        self.both(|engine| engine.set_positions(&positions).unwrap());
        Ok(())
    }
}

/// Without vector unit and sleep.
fn plain(twin: &mut Engine<'_>) {
    twin.go_scalar();
    twin.forbid_sleep();
}
