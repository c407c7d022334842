//! The pressed body as every engine gets it: cells in the model's order, the model's links.

use chaincell_host::engine::rest_m;
use chaincell_host::error::{Error, Result};
use chaincell_kernel::Model;
use chaincell_lab::experiments::report::scene::Scene;
use nalgebra::Vector3;

/// A body whose cell `press` goes down by a tenth of its height in one step and stays there.
pub struct Pressed<'m> {
    pub name: &'static str,
    pub model: Model<'m>,
    /// Positions at rest \[m\].
    pub rest_m: Vec<[f64; 3]>,
    pub links: Vec<[u32; 2]>,
    pub press: u16,
    /// Where `press` goes \[m\].
    pub target_m: [f64; 3],
    /// Other end and rest length \[m\] of the pressed cell's links.
    pressed_links: Vec<(u32, f64)>,
}

impl<'m> Pressed<'m> {
    pub fn new(scene: &'m Scene, depth_m: f64) -> Result<Self> {
        let model = scene.model()?;
        let press = *scene.contacts.first().ok_or_else(|| Error::check("nothing to press"))?;
        let rest_m: Vec<[f64; 3]> = (0..model.cells()).map(|cell| rest_m(&model, cell)).collect();
        let links: Vec<[u32; 2]> = (0..model.cells())
            .flat_map(|i| model.row(i).map(move |link| [i as u32, u32::from(model.upper()[link])]))
            .collect();
        let (at, press_id) = (rest_m[usize::from(press)], u32::from(press));
        let pressed_links = links.iter().filter_map(|&[i, j]| {
            let other = if i == press_id { j } else { i };
            let touches = i == press_id || j == press_id;
            touches.then(|| (other, way(rest_m[other as usize], at).norm()))
        });
        Ok(Self {
            name: scene.name,
            pressed_links: pressed_links.collect(),
            model,
            press,
            target_m: std::array::from_fn(|axis| at[axis] + depth_m * scene.direction[axis]),
            links,
            rest_m,
        })
    }

    /// Whether a cell's place is prescribed.
    pub fn is_held(&self, cell: u16) -> bool {
        cell == self.press || self.model.is_fixed(cell)
    }

    /// Force of the links on the pressed cell over their stiffness: sum of the extensions \[m\].
    pub fn link_force_m(&self, positions_m: &[[f64; 3]]) -> Vector3<f64> {
        let at = positions_m[usize::from(self.press)];
        let extensions = self.pressed_links.iter().map(|&(other, rest)| {
            let way = way(positions_m[other as usize], at);
            let length = way.norm();
            if length > 0.0 { way * ((length - rest) / length) } else { Vector3::zeros() }
        });
        extensions.sum()
    }
}

/// From one point to another.
fn way(to: [f64; 3], from: [f64; 3]) -> Vector3<f64> {
    Vector3::from(to) - Vector3::from(from)
}
