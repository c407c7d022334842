//! The scenes: the one place where bodies, schemes and sizes stand.
//!
//! `tests/tests/bake/scenes.rs` bakes every image anew and compares.

use chaincell_kernel::{
    CutRoom, Dynamics, Euler, Model, Predict, Rkl2, Settings, Tissue, TissueMut, ToolPart,
    TouchStore, Track, Unloading, coarse_room, elastic_room, include_model, term_states,
};

use fixed::types::I8F24;

use crate::{Act, Scene, Tier, Tools};

/// `chaincell bake plane:21x21x0.01 --coarse none --lean`: four neighbours.
pub static PLANE4: &[u8] = include_model!("../../data/plane4.chaincell");
/// `chaincell bake plane:21x21x0.01 --diagonals --alpha 0.02 --coarse none --contact-surface no`: eight
/// neighbours, sliced.
pub static PLANE8: &[u8] = include_model!("../../data/plane8.chaincell");
/// `chaincell bake box:7x7x5x0.01 --alpha 0.03 --coarse 2.5 --contact-surface no`: slack, sliced, 18 coarse
/// functions.
pub static BOX7: &[u8] = include_model!("../../data/box7.chaincell");
/// `chaincell bake organ:500 --coarse 3.5 --lean`: 24 coarse functions.
pub static ORGAN500: &[u8] = include_model!("../../data/organ500.chaincell");
/// `chaincell bake organ:300 --coarse 3 --contact-surface no` with alpha and stiffness of their own for every
/// link: sliced, 24 coarse functions.
pub static VARIED300: &[u8] = include_model!("../../data/varied300.chaincell");

/// `chaincell bake box:6x6x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 --contact-surface no`:
/// nodal shapes, coarse functions.
pub static TISSUE6: &[u8] = include_model!("../../data/tissue6.chaincell");
/// The same with `--contact-surface yes`.
pub static TOUCH6: &[u8] = include_model!("../../data/touch6.chaincell");

/// The same with `--branch 1,0.02 --branch 0.5,12`: its stress relaxes.
pub static RELAX6: &[u8] = include_model!("../../data/relax6.chaincell");

/// `chaincell bake box:5x5x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 --contact-surface yes --cuttable
/// --cut-spare 0.3 --toughness-j-per-m2 10`: nodal shapes, coarse functions, spare cells for a blade.
pub static BLADE5: &[u8] = include_model!("../../data/blade5.chaincell");

/// `chaincell bake box:4x4x6x0.01 --young-pa 5000 --poisson 0.4 --coarse none --contact-surface no --cuttable
/// --cut-spare 0.1 --tear-stretch 1.2`: a bar of nodal shapes that tears by itself.
pub static TEAR4: &[u8] = include_model!("../../data/tear4.chaincell");

/// A scissor of two capsules with a ball at their end, and a rounded box beside a sphere.
const SCISSOR: [ToolPart; 3] = [
    ToolPart {
        centre_m: [0.006, 0.0, 0.008],
        orientation: [0.0, 0.5, 0.0, 1.0],
        ..ToolPart::capsule(0.01, 0.005)
    },
    ToolPart {
        centre_m: [-0.006, 0.0, 0.008],
        orientation: [0.0, -0.5, 0.0, 1.0],
        ..ToolPart::capsule(0.01, 0.005)
    },
    ToolPart::sphere(0.007),
];
const SPATULA: [ToolPart; 2] = [
    ToolPart::rounded_box([0.006, 0.004, 0.001], 0.005),
    ToolPart { centre_m: [0.009, 0.0, 0.004], ..ToolPart::sphere(0.007) },
];

/// A blade with a ball for its back.
const SCALPEL: [ToolPart; 2] = [
    ToolPart { centre_m: [0.0, 0.0, 0.02], ..ToolPart::sphere(0.005) },
    ToolPart { orientation: [0.0, 0.1, 0.3, 1.0], ..ToolPart::edge(0.03) },
];

/// Defaults but for the number of sweeps, the bands and the force's limit.
fn settings<D: Dynamics>(
    model: &Model<'_>,
    sweeps: u16,
    unloading: Unloading,
    max_force_n: f32,
) -> Settings {
    let tick_time = D::tick_time(model, sweeps);
    Settings { sweeps, tick_time, unloading, max_force_n, ..Settings::for_model(model) }
}

/// Plays a scene in its tissue, with memory for contact on surfaces where it has tools, and for cuts or
/// remembered strain where it needs it.
macro_rules! act_in {
    ($act:ident, $scene:expr, $body:expr) => {
        $act.act($scene, $body.view())
    };
    ($act:ident, $scene:expr, $body:expr, words $words:literal) => {
        $act.act($scene, TissueMut { cut: CutRoom::new(&mut [0; $words]), ..$body.view() })
    };
    ($act:ident, $scene:expr, $body:expr, $touch:ty) => {
        $act.act($scene, $body.touching(<$touch>::new().room()))
    };
    ($act:ident, $scene:expr, $body:expr, $touch:ty, $words:literal) => {
        $act.act(
            $scene,
            TissueMut {
                cut: CutRoom::new(&mut [0; $words]),
                ..$body.touching(<$touch>::new().room())
            },
        )
    };
}

/// What there may be.
macro_rules! option {
    () => {
        None
    };
    ($value:expr) => {
        Some($value)
    };
}

macro_rules! scenes {
    ($($(#[$doc:meta])* $name:ident {
        image: $image:ident, cells: $cells:literal, $(states: $states:literal,)?
        held: $held:expr, $(held_words: $held_words:literal,)?
        $(tools: $tools:expr, near: $near:literal, anchors: $anchors:literal, $(words: $words:literal,)?)?
        reach_m: $reach:literal,
        scheme: $scheme:ty, also: [$($tier:ident $other:ty),*], sweeps: $sweeps:literal, unloading: $unloading:ident,
        max_force_n: $force:expr,
    })*) => {
        $($(#[$doc])* pub mod $name {
            use super::*;

            /// Scheme of the scene, in `f32`.
            pub type Scheme = $scheme;
            /// A tissue that the scene just fits.
            pub type Body = BodyOf<Scheme>;
            /// The same for the scene's scheme in another number type.
            pub type BodyOf<D> = Tissue<$cells, D, { HELD.len() }, { 0 $(+ term_states($states))? }>;
            const HELD: &[u32] = &$held;
            /// The scene.
            pub static SCENE: Scene = Scene {
                name: stringify!($name),
                scheme: <Scheme as Dynamics>::NAME,
                tiers: &[Tier::F32 $(, Tier::$tier)*],
                image: $image,
                cells: $cells,
                held: HELD,
                tools: option!($($tools)?),
                reach_m: $reach,
                settings: |model| {
                    settings::<Scheme>(model, $sweeps, Unloading::$unloading, $force)
                },
            };
        })*

        /// All scenes.
        pub static SCENES: [&Scene; [$(stringify!($name)),*].len()] = [$(&$name::SCENE),*];

        /// Gives `act` a scene by its name with a tissue for it on the stack; `None` where there
        /// is no such scene in that tier. Firmware with a small stack takes the scene's own `Body` instead.
        pub fn stage<A: Act>(name: &str, tier: Tier, act: A) -> Option<A::Output> {
            match (name, tier) {
                $((stringify!($name), Tier::F32) => {
                    Some(act_in!(act, &$name::SCENE, $name::Body::new()
                        $(, words $held_words)?
                        $(, TouchStore<$cells, $near, $anchors, { crate::TOOLS_MAX }> $(, $words)?)?))
                }
                $((stringify!($name), Tier::$tier) => {
                    Some(act.act(&$name::SCENE, $name::BodyOf::<$other>::new().view()))
                })*)*
                _ => None,
            }
        }
    };
}

scenes! {
    /// The plane with four neighbours under the paper's own steps.
    plane4_euler {
        image: PLANE4, cells: 441, held: [220], reach_m: 0.03,
        scheme: Euler, also: [Fixed Euler<I8F24>], sweeps: 4, unloading: Release, max_force_n: f32::INFINITY,
    }
    /// The plane with eight neighbours and slack under super-steps of second order.
    plane8_rkl2 {
        image: PLANE8, cells: 441, held: [220], reach_m: 0.03,
        scheme: Rkl2, also: [], sweeps: 9, unloading: Retreat, max_force_n: f32::INFINITY,
    }
    /// That plane after its equilibrium, without a coarse level.
    plane8_track {
        image: PLANE8, cells: 441, held: [199, 220, 241], reach_m: 0.03,
        scheme: Track, also: [Fixed Track<0, I8F24>], sweeps: 4, unloading: Release, max_force_n: 0.5,
    }
    /// A block with slack and coarse functions.
    box7_track {
        image: BOX7, cells: 245, held: [124, 129], reach_m: 0.03,
        scheme: Track<{ coarse_room(18, 2) }>, also: [Fixed Track<0, I8F24>], sweeps: 4, unloading: Retreat, max_force_n: 0.5,
    }
    /// The organ with a coarse level.
    organ500_track {
        image: ORGAN500, cells: 499, held: [415, 435, 436, 438, 439, 457, 477], reach_m: 0.06,
        scheme: Track<{ coarse_room(24, 7) }>, also: [Fixed Track<0, I8F24>], sweeps: 4, unloading: Release,
        max_force_n: f32::INFINITY,
    }
    /// The organ with a prediction and one sweep a tick.
    organ500_predict {
        image: ORGAN500, cells: 499, held: [415, 435, 436, 438, 439, 457, 477], reach_m: 0.06,
        scheme: Predict<{ coarse_room(24, 7) }>, also: [], sweeps: 1, unloading: Release,
        max_force_n: f32::INFINITY,
    }
    /// A block of nodal shapes, with a coarse level; the kernel needs its feature `nodal`.
    tissue6_track {
        image: TISSUE6, cells: 144, states: 144, held: [59, 63, 83], reach_m: 0.03,
        scheme: Track<{ elastic_room(48) }>, also: [], sweeps: 3, unloading: Release,
        max_force_n: f32::INFINITY,
    }
    /// An organ whose links all differ, with a coarse level.
    varied300_track {
        image: VARIED300, cells: 299, held: [287, 288], reach_m: 0.06,
        scheme: Track<{ coarse_room(24, 2) }>, also: [Fixed Track<0, I8F24>], sweeps: 4, unloading: Retreat,
        max_force_n: f32::INFINITY,
    }
    /// A sphere with friction that presses that block, slides and lets go, with a prediction; the kernel
    /// needs its feature `surface`, here and below.
    touch6_predict {
        image: TOUCH6, cells: 144, states: 144, held: [],
        tools: Tools {
            parts: &[&[ToolPart::sphere(0.008)]],
            friction: 0.3,
            start_m: [[-0.003, -0.007, 0.039]; 2],
            turn_m: 0.01,
        },
        near: 256, anchors: 256, reach_m: 0.012,
        scheme: Predict<{ elastic_room(48) }>, also: [], sweeps: 2, unloading: Release,
        max_force_n: f32::INFINITY,
    }
    /// Two tools of several parts that turn, grip and let go, with fewer slots than triangles in reach.
    touch6_tools {
        image: TOUCH6, cells: 144, states: 144, held: [],
        tools: Tools {
            parts: &[&SCISSOR, &SPATULA],
            friction: 0.3,
            start_m: [[-0.009, -0.005, 0.038], [0.011, 0.005, 0.037]],
            turn_m: 0.01,
        },
        near: 40, anchors: 96, reach_m: 0.012,
        scheme: Track<{ elastic_room(48) }>, also: [], sweeps: 3, unloading: Release,
        max_force_n: f32::INFINITY,
    }
    /// A sphere with friction on the same block of tissue that relaxes; the kernel needs its feature `relax`.
    relax6_track {
        image: RELAX6, cells: 144, states: 144, held: [],
        tools: Tools {
            parts: &[&[ToolPart::sphere(0.008)]],
            friction: 0.3,
            start_m: [[-0.003, -0.007, 0.039]; 2],
            turn_m: 0.01,
        },
        near: 256, anchors: 256, words: 4050, reach_m: 0.012,
        scheme: Track<{ elastic_room(48) }>, also: [], sweeps: 2, unloading: Release,
        max_force_n: f32::INFINITY,
    }
    /// A blade that cuts a block on many ways, until its spare cells are used up; the kernel needs its feature `cut`.
    blade5_track {
        image: BLADE5, cells: 130, states: 130, held: [],
        tools: Tools {
            parts: &[&SCALPEL],
            friction: 0.2,
            start_m: [[-0.001, -0.006, 0.0305]; 2],
            turn_m: 0.01,
        },
        near: 128, anchors: 64, words: 14878, reach_m: 0.024,
        scheme: Track<{ elastic_room(8) }>, also: [], sweeps: 3, unloading: Release,
        max_force_n: f32::INFINITY,
    }
    /// A bar whose held end is pushed, drawn and bent until its spare cells are torn off; the kernel needs its feature
    /// `cut`.
    tear4_track {
        image: TEAR4, cells: 106, states: 106,
        held: [5, 11, 17, 23, 29, 35, 41, 47, 53, 59, 65, 71, 77, 83, 89, 95], held_words: 9006, reach_m: 0.03,
        scheme: Track, also: [], sweeps: 3, unloading: Release,
        max_force_n: f32::INFINITY,
    }
}
