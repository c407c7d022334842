//! Device metres to scene metres, and scene newtons back to device newtons by the transpose.

/// Smallest and largest `--scale`.
const SCALE: (f32, f32) = (0.01, 100.0);
/// Largest coordinate of `--origin` \[m\].
const ORIGIN_M_MAX: f32 = 100.0;

/// The map `scene = origin + scale * axes * device`.
///
/// Forces go back by the transpose of `scale * axes`, so the power that the hand feels is that of the tool
/// in the scene: at a scale of 2 the hand feels twice the force of the tissue.
///
/// ```
/// use chaincell_haply::frame::Frame;
///
/// let frame = Frame::new("x,-z,y", 2.0, [0.0, 0.0, 0.04])?;
/// assert_eq!(frame.to_scene([0.01, 0.02, 0.03]), [0.02, -0.06, 0.08]); // [m]
/// assert_eq!(frame.to_device([1.0, 0.0, 3.0]), [2.0, 6.0, 0.0]); // [N]
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The device's axis of each axis of the scene, and its factor.
    axes: [(usize, f32); 3],
    origin_m: [f32; 3],
}

impl Frame {
    /// Reads the axes of `--frame`: the device's axis that each axis of the scene follows.
    ///
    /// # Errors
    /// Other text than three different axes with signs; a map that mirrors the hand; a scale or an origin
    /// beyond their ranges.
    pub fn new(axes: &str, scale: f32, origin_m: [f32; 3]) -> Result<Self, String> {
        if !(SCALE.0..=SCALE.1).contains(&scale) {
            return Err(format!("--scale {scale}: must be from {} to {}", SCALE.0, SCALE.1));
        }
        if !origin_m.iter().all(|x| x.abs() <= ORIGIN_M_MAX) {
            return Err(format!(
                "--origin {origin_m:?}: each coordinate must be from -{ORIGIN_M_MAX} to {ORIGIN_M_MAX} [m]"
            ));
        }
        let names: Vec<&str> = axes.split(',').map(str::trim).collect();
        let read: Option<Vec<(usize, f32)>> = names.iter().map(|name| axis(name)).collect();
        let Some(&[first, second, third]) = read.as_deref() else {
            return Err(format!("--frame {axes}: give three axes of the device, as x,-z,y"));
        };
        let read = [first, second, third];
        let handedness = handedness(&read);
        if handedness == 0.0 {
            return Err(format!("--frame {axes}: each axis of the device must occur once"));
        }
        if handedness < 0.0 {
            return Err(format!("--frame {axes}: it mirrors the hand; change one sign"));
        }
        Ok(Self { axes: read.map(|(from, sign)| (from, sign * scale)), origin_m })
    }

    /// Returns the position in the scene \[m\].
    #[must_use]
    pub fn to_scene(&self, device_m: [f32; 3]) -> [f32; 3] {
        let mut scene_m = self.origin_m;
        for (to, (from, factor)) in scene_m.iter_mut().zip(self.axes) {
            *to += factor * device_m[from];
        }
        scene_m
    }

    /// Returns the force on the hand \[N\] of a force on the tool.
    #[must_use]
    pub fn to_device(&self, scene_n: [f32; 3]) -> [f32; 3] {
        let mut device_n = [0.0; 3];
        for (force_n, (to, factor)) in scene_n.into_iter().zip(self.axes) {
            device_n[to] = factor * force_n;
        }
        device_n
    }
}

fn axis(name: &str) -> Option<(usize, f32)> {
    let (name, sign) = match name.strip_prefix('-') {
        Some(rest) => (rest, -1.0),
        None => (name, 1.0),
    };
    Some((["x", "y", "z"].iter().position(|axis| *axis == name)?, sign))
}

/// Returns the determinant of the axes: 1, -1 for a mirror, 0 where an axis is missing.
fn handedness(axes: &[(usize, f32); 3]) -> f32 {
    let sign = axes.iter().map(|(_, sign)| sign).product::<f32>();
    match axes.map(|(from, _)| from) {
        [0, 1, 2] | [1, 2, 0] | [2, 0, 1] => sign,
        [0, 2, 1] | [1, 0, 2] | [2, 1, 0] => -sign,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_go_back_by_the_transpose_so_that_power_is_kept() {
        let velocity = [0.3, -0.2, 0.7];
        let force_n = [1.0, -2.0, 0.5];
        for axes in ["x,y,z", "x,-z,y", "-y,x,z", "z,x,y", "-x,-y,z", "y,z,x"] {
            let frame = Frame::new(axes, 3.0, [0.0; 3]).unwrap();
            let dot = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f32>();
            let scene = dot(frame.to_scene(velocity), force_n);
            let device = dot(velocity, frame.to_device(force_n));
            assert!((scene - device).abs() < 1e-5, "{axes}: {scene} {device}");
        }
    }

    #[test]
    fn what_is_no_frame_is_refused_with_the_option_and_the_remedy() {
        let refusal = |axes: &str| Frame::new(axes, 1.0, [0.0; 3]).unwrap_err();
        for axes in ["", "x,y", "x,y,w", "x,y,z,x", "x;y;z", "--x,y,z"] {
            assert!(refusal(axes).contains("give three axes"), "{axes}");
        }
        assert!(refusal("x,x,z").contains("must occur once"));
        for axes in ["-x,y,z", "y,x,z", "-x,-y,-z"] {
            assert!(refusal(axes).contains("mirrors the hand"), "{axes}");
        }
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let text = Frame::new("x,y,z", scale, [0.0; 3]).unwrap_err();
            assert!(text.starts_with("--scale"), "{text}");
        }
        let text = Frame::new("x,y,z", 1.0, [0.0, f32::NAN, 0.0]).unwrap_err();
        assert!(text.starts_with("--origin"), "{text}");
    }
}
