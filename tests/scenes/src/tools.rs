//! Tools of a scene whose body has a contact surface.

use chaincell_kernel::{ToolPart, ToolPose};

/// Most tools of a scene.
pub const TOOLS_MAX: usize = 2;

/// Tools that meet the surface of a scene's body. The first goes where the samples are, the second
/// the same way with x and y turned round; two tools turn while they go, and grip and let go.
#[derive(Debug, Clone, Copy)]
pub struct Tools {
    /// The parts of each.
    pub parts: &'static [&'static [ToolPart]],
    /// Coefficient of friction.
    pub friction: f32,
    /// Where each begins a stroke \[m\].
    pub start_m: [[f32; 3]; TOOLS_MAX],
    /// Length of a way that turns a tool by a good part of its largest turn \[m\].
    pub turn_m: f32,
}

impl Tools {
    /// Number of tools.
    #[must_use]
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// Where the tools are at a sample, those beyond [`Self::count`] of no meaning.
    #[must_use]
    pub fn poses(&self, sample: &ToolPose) -> [ToolPose; TOOLS_MAX] {
        let [first, second] = self.start_m;
        let one = ToolPose::at(sample.position_m, sample.engaged.into());
        if self.count() < TOOLS_MAX {
            return [one; TOOLS_MAX];
        }
        let [x, y, z] = sample.position_m.into();
        let way = [x - first[0], y - first[1], z - first[2]];
        let [a, b, c] = way.map(|x| 0.5 * part_of_one(x / self.turn_m));
        let other = [second[0] - way[0], second[1] - way[1], second[2] + way[2]];
        [
            ToolPose { orientation: [a, b, c, 1.0], ..one },
            ToolPose {
                orientation: [-b, c, 0.25 + a, 1.0],
                ..ToolPose::at(other.into(), one.engaged.into())
            },
        ]
    }
}

/// From -1 to 1, rising.
fn part_of_one(x: f32) -> f32 {
    x / (1.0 + x.abs())
}
