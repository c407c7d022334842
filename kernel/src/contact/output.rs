//! Output of one tool, and the pose at which the tissue meets it.

use nalgebra::Vector3;

use crate::number::clamp::clamped;

/// Output of one of several tools in a tick.
///
/// ```
#[doc = include_str!("example.txt")]
/// use chaincell_kernel::ToolOutput;
/// # for step in 0..=6 {
/// #     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
/// #     tissue.tick(&network, &[pose], Budget::All);
/// # }
///
/// let ToolOutput { force_n, torque_n_m, contacts, .. } = tissue.tool_output(&network, 0);
/// assert!(force_n.z > 0.05 && contacts > 0); // [N], a ball pressed down by 4 mm
/// assert!(torque_n_m.x.abs() < 0.004 * force_n.z); // [N m], about its centre
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolOutput {
    /// Force of the tissue on the tool \[N\].
    pub force_n: Vector3<f32>,
    /// Torque on it about its position \[N m\].
    pub torque_n_m: Vector3<f32>,
    /// Its part of [`TickOutput::work_j`](crate::TickOutput::work_j), including the work of the torque \[J\].
    pub work_j: f32,
    /// Upper bound of the stiffness at the tool within a tick [N/m].
    pub stiffness_n_per_m: f32,
    /// Number of triangles in contact with it, or with gripped samples.
    pub contacts: u32,
}

impl ToolOutput {
    /// Output of a tool without contact.
    pub const NONE: Self = Self {
        force_n: Vector3::new(0.0, 0.0, 0.0),
        torque_n_m: Vector3::new(0.0, 0.0, 0.0),
        work_j: 0.0,
        stiffness_n_per_m: 0.0,
        contacts: 0,
    };

    /// Clamps the force to its limit. Returns true if that changed it.
    pub(crate) fn clamp(&mut self, max_force_n: f32) -> bool {
        let (within_n, is_clamped) = clamped(self.force_n.into(), max_force_n);
        if is_clamped {
            self.force_n = within_n.into();
        }
        is_clamped
    }
}

/// Where the tissue meets a tool: its proxy, which stops short of the tool where that is too deep.
///
/// ```
#[doc = include_str!("example.txt")]
/// use chaincell_kernel::ProxyPose;
///
/// let outside = ToolPose::at([0.0, 0.0, 0.036].into(), 1);
/// tissue.tick(&network, &[outside], Budget::All);
/// let ProxyPose { position_m, share, .. } = tissue.proxy_pose(&network, 0).ok_or("not engaged")?;
/// assert!((position_m[2] - 0.036).abs() < 1e-6 && share == 1.0); // [m], at the tool
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProxyPose {
    /// Position of its frame in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Rotation from its frame to the mesh's: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// Share of the parts' radii that it has: below 1 after engaging in contact, 0 while it waits inside the
    /// tissue.
    pub share: f32,
}

/// Output of a pin.
///
/// ```
#[doc = include_str!("example.txt")]
/// # if !FEATURES.contains(&"pins") {
/// #     return Ok(());
/// # }
/// use chaincell_kernel::PinOutput;
///
/// let pin = tissue.pin_at(&network, [0.0, 0.0, 0.030], 0.004, f32::INFINITY)?; // on the surface
/// let PinOutput { position_m, force_n, samples, .. } = tissue.pin_output(&network, pin).ok_or("no pin")?;
/// assert!((position_m[2] - 0.030).abs() < 1e-3 && samples > 0); // [m]
/// assert_eq!(<[f32; 3]>::from(force_n), [0.0; 3]); // [N], nothing pulls yet
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinOutput {
    /// Force of the tissue on the pin \[N\]. It is not clamped by the largest force.
    pub force_n: Vector3<f32>,
    /// The mean of the places at which its samples are pinned, in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Mean displacement of its samples from there \[m\].
    pub given_m: [f32; 3],
    /// Its present stiffness [N/m]; it falls to 0 while the pin is released.
    pub stiffness_n_per_m: f32,
    /// Energy of its springs \[J\].
    pub energy_j: f32,
    /// Number of samples that it holds.
    pub samples: u32,
}
