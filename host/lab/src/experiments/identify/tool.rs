//! What touches the body, from `--contact`.

use chaincell_host::cli::tool::ToolSpec;
use chaincell_host::engine::Contact;
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{ToolPart, ToolPose};
use nalgebra::Vector3;

/// What touches the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tool<'a> {
    /// It holds these cells, ascending; its displacement is theirs.
    Held(&'a [u16]),
    /// A sphere without friction; its displacement counts from where it meets the surface.
    Probe {
        /// Radius \[m\].
        radius_m: f64,
        /// The point of the surface that it meets first \[m\].
        at_m: [f64; 3],
    },
    /// The edge of a blade, with the place where it meets the surface \[m\].
    Blade(ToolPart, [f64; 3]),
}

impl Tool<'_> {
    /// The engine's contact.
    pub(super) fn contact(&self) -> Contact {
        match *self {
            Self::Held(cells) => Contact::Cells(cells.to_vec()),
            Self::Probe { radius_m, .. } => Contact::sphere(radius_m as f32, 0.0),
            Self::Blade(edge, _) => Contact::Tools { tools: vec![vec![edge]], friction: 0.0 },
        }
    }

    /// The tool displaced by so much along a direction.
    pub(super) fn sample(&self, direction: [f64; 3], depth_m: f64) -> ToolPose {
        let place = |from: [f64; 3], by_m: f64| -> Vector3<f32> {
            [0, 1, 2].map(|axis| (from[axis] + by_m * direction[axis]) as f32).into()
        };
        let position_m = match *self {
            Self::Held(_) => place([0.0; 3], depth_m),
            Self::Probe { radius_m, at_m } => place(at_m, depth_m - radius_m),
            Self::Blade(_, at_m) => place(at_m, depth_m),
        };
        ToolPose::at(position_m, 1)
    }
}

/// The radius of `probe:RADIUS` \[m\]; none for held cells.
pub fn probe_radius(contact: &str) -> Result<Option<f64>> {
    let Some(radius) = contact.strip_prefix("probe") else { return Ok(None) };
    let radius_m = radius.strip_prefix(':').and_then(|radius| radius.parse().ok());
    let radius_m = radius_m.filter(|radius_m: &f64| radius_m.is_finite() && *radius_m > 0.0);
    radius_m.map(Some).ok_or_else(|| {
        Error::input(format!("--contact {contact}: give the radius [m], as in probe:0.004"))
    })
}

/// The edge of `blade:LENGTH/TURN`, as `run` takes it; none for any other contact.
pub fn blade_edge(contact: &str) -> Result<Option<ToolPart>> {
    if !contact.starts_with("blade") {
        return Ok(None);
    }
    let spec = contact.parse::<ToolSpec>();
    let spec = spec.map_err(|why| Error::input(format!("--contact {contact}: {why}")))?;
    match spec.parts() {
        [edge] => Ok(Some(*edge)),
        _ => Err(Error::input(format!("--contact {contact}: give the blade alone"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probe_starts_on_the_surface_and_goes_in() {
        let tool = Tool::Probe { radius_m: 0.004, at_m: [0.0, 0.0, 0.01] };
        let height_m = |depth_m| tool.sample([0.0, 0.0, -1.0], depth_m).position_m[2];
        assert!((height_m(0.0) - 0.014).abs() < 1e-8 && (height_m(0.002) - 0.012).abs() < 1e-8);
        assert_eq!(Tool::Held(&[1]).sample([0.0, 1.0, 0.0], 0.5).position_m[1], 0.5);
    }

    #[test]
    fn an_edge_has_a_length_and_comes_alone() {
        assert_eq!(blade_edge("probe:0.004").unwrap(), None);
        let edge = blade_edge("blade:0.02/0,0,0,1").unwrap().unwrap();
        assert!(edge.is_edge());
        for bad in ["blade", "blade:-1", "blade:0.02/0,0,0,2", "blade:0.02+sphere:0.01"] {
            let error = blade_edge(bad).unwrap_err().to_string();
            assert!(error.contains(&format!("--contact {bad}:")), "{error}");
        }
    }

    #[test]
    fn a_radius_is_a_length() {
        assert_eq!(probe_radius("cells:nodes:1").unwrap(), None);
        assert_eq!(probe_radius("probe:0.004").unwrap(), Some(0.004));
        for bad in ["probe", "probe:", "probe:x", "probe:-1", "probe:0", "probe:inf"] {
            let error = probe_radius(bad).unwrap_err().to_string();
            assert!(error.contains(&format!("--contact {bad}:")), "{error}");
        }
    }
}
