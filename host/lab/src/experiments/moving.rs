//! The force of a moving tool beside that of the same body with many more sweeps a tick.

use chaincell_host::bake::ImageBytes;
use chaincell_host::cli::session::press;
use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{Flags, Model, Network, Settings, ToolPose, Unloading};
use nalgebra::Vector3;

/// Young's modulus of a liver \[Pa\].
pub const YOUNG_PA: f64 = 5000.0;
/// Its Poisson's ratio.
pub const POISSON: f64 = 0.45;

/// How far the force of a number of sweeps a tick is off, in shares of the reference's largest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingRow {
    /// Sweeps a tick.
    pub sweeps: u16,
    /// Half of the ticks in contact are below.
    pub median: f64,
    /// Nine of ten are.
    pub p90: f64,
    /// Of all ticks.
    pub largest: f64,
    /// Ticks in which the guard discarded a pass.
    pub rolled_back: usize,
}

/// A tool on a body, and where it goes.
pub struct Moving<'a> {
    image: &'a ImageBytes,
    contact: Contact,
    poses: Vec<Pose>,
    forces_n: Vec<Vector3<f64>>,
}

impl<'a> Moving<'a> {
    /// The built-in press to a depth in so many ticks, then aside by so much while it holds; its
    /// reference makes `sweeps` a tick.
    ///
    /// # Errors
    /// As the press and the engine.
    pub fn press(
        image: &'a ImageBytes,
        contact: Contact,
        (depth_m, aside_m, ticks): (f64, f64, u64),
        sweeps: u16,
    ) -> Result<Self> {
        let model = Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
        let mut poses = press(&engine(model, &contact, 1)?, Some(depth_m), ticks)?;
        slide(&mut poses, aside_m);
        let mut moving = Self { image, contact, poses, forces_n: Vec::new() };
        moving.forces_n = moving.play(sweeps)?.0;
        Ok(moving)
    }

    /// Its largest force \[N\].
    #[must_use]
    pub fn peak_n(&self) -> f64 {
        self.forces_n.iter().map(|force| force.norm()).fold(0.0, f64::max)
    }

    /// The error of a number of sweeps.
    ///
    /// # Errors
    /// As the engine; a tool that touches nothing.
    pub fn row(&self, sweeps: u16) -> Result<MovingRow> {
        let (forces_n, rolled_back) = self.play(sweeps)?;
        let both = forces_n.iter().zip(&self.forces_n);
        let touches = both.filter(|(force, exact)| force.norm() + exact.norm() > 0.0);
        let mut errors: Vec<f64> =
            touches.map(|(force, exact)| (force - exact).norm() / self.peak_n()).collect();
        errors.sort_by(f64::total_cmp);
        let Some(&largest) = errors.last() else {
            return Err(Error::input("the tool touches nothing: press deeper"));
        };
        let at = |share: usize| errors[errors.len() * share / 10];
        Ok(MovingRow { sweeps, median: at(5), p90: at(9), largest, rolled_back })
    }

    /// The forces, and in how many ticks a pass was discarded.
    fn play(&self, sweeps: u16) -> Result<(Vec<Vector3<f64>>, usize)> {
        let model = Model::from_bytes(self.image.as_bytes()).map_err(Error::check)?;
        let mut engine = engine(model, &self.contact, sweeps)?;
        let mut rolled_back = 0;
        let mut tick = |pose: &Pose| {
            let output = engine.tick(&ToolPose::from(*pose));
            rolled_back += usize::from(output.flags.contains(Flags::ROLLED_BACK));
            output.force_n.map(f64::from)
        };
        let forces_n = self.poses.iter().map(&mut tick).collect();
        Ok((forces_n, rolled_back))
    }
}

fn engine<'m>(model: Model<'m>, contact: &Contact, sweeps: u16) -> Result<Engine<'m>> {
    let (unloading, max_tool_step_m) = (Unloading::Off, 1.0);
    let settings = Settings { sweeps, unloading, max_tool_step_m, ..Settings::for_model(&model) };
    let network = Network::new(model, settings).map_err(Error::check)?;
    Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact.clone())
}

/// Moves the poses of the hold aside, steadily, and back with the retreat.
fn slide(poses: &mut [Pose], aside_m: f64) {
    let at = |pose: &Pose| Vector3::from(pose.position_m).cast::<f64>();
    let (Some(first), Some(middle)) = (poses.first().map(at), poses.get(poses.len() / 2).map(at))
    else {
        return;
    };
    let inward = (middle - first).normalize();
    let aside = inward.cross(&Vector3::ith(inward.iamin(), 1.0)).normalize();
    let count = poses.len();
    for (tick, pose) in poses.iter_mut().enumerate() {
        // The hold is from 0.4 of the ticks to 0.75.
        let share = ((tick as f64 / count as f64 - 0.4) / 0.35).clamp(0.0, 1.0);
        pose.position_m = (at(pose) + aside_m * share * aside).cast::<f32>().into();
    }
}

#[cfg(test)]
mod tests {
    use chaincell_host::bake::tissue::Tissue;
    use chaincell_host::bake::{BakeOptions, PerCell, ProbeContact, bake};
    use chaincell_host::mesh::{MeshOptions, load};
    use chaincell_kernel::ToolPart;

    use super::*;

    /// What a budget leaves under load: one sweep a tick, under a tool that moves.
    #[test]
    fn one_sweep_holds_the_force_of_a_moving_tool() {
        let tissue = Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(POISSON));
        let probe_contact = ProbeContact::Surface;
        let options = BakeOptions { tissue: Some(tissue), probe_contact, ..BakeOptions::default() };
        let mesh = load("organ:600", &MeshOptions::default()).unwrap();
        let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
        for way in [(0.043, 0.0, 1000), (0.02, 0.0, 500)] {
            let tools = vec![vec![ToolPart::sphere(0.012)]];
            let contact = Contact::Tools { tools, friction: 0.0 };
            let moving = Moving::press(&image, contact, way, 24).unwrap();
            let (one, two) = (moving.row(1).unwrap(), moving.row(2).unwrap());
            println!("{way:?}: {:.3} N, {one:?}, {two:?}", moving.peak_n());
            assert!(one.median < 0.02 && one.p90 < 0.10, "{way:?}: {one:?}");
            assert!(two.median < 0.005 && two.p90 < 0.03, "{way:?}: {two:?}");
        }
    }
}
