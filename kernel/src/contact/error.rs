//! Errors of a tissue that refuses cells or tools.

/// Why a list of contact cells is refused; the position is that in the list.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, Tissue, Track, include_model};
/// use chaincell_kernel::ContactError;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
/// let border = model.fixed()[0];
/// let refused = tissue.choose_contacts(&network, &[border]);
/// assert_eq!(refused, Err(ContactError::Fixed(0)));
/// assert_eq!(tissue.choose_contacts(&network, &[46, 47]), Ok(())); // ascending
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// The tissue has memory for fewer contact cells.
    #[error("{needed} contact cells, room for {capacity}: raise the capacity")]
    Capacity {
        /// Cells asked for.
        needed: usize,
        /// Cells that the memory holds.
        capacity: usize,
    },
    /// The cell is not in the model.
    #[error("contact cell at position {0} is not in the model")]
    Unknown(usize),
    /// The cell's state is fixed.
    #[error("contact cell at position {0} is fixed")]
    Fixed(usize),
    /// The ids must ascend without repeats.
    #[error("contact cell at position {0} is not above the last")]
    Order(usize),
    /// The tissue was not reset to this network.
    #[error("the tissue belongs to another network: reset it first")]
    Model,
    /// The tissue has too little memory to hold that many cells against the model's coarse level: size it
    /// with [`coarse_room`](crate::coarse_room), or [`elastic_held_room`](crate::elastic_held_room) for nodal
    /// shapes.
    #[error(
        "holding these cells needs {needed} blocks of eight f32 for the coarse level, there is \
         room for {room}"
    )]
    CoarseRoom {
        /// Blocks needed.
        needed: usize,
        /// Blocks that the tissue has.
        room: usize,
    },
    /// The tool is engaged: contacts can be chosen only while it is not.
    #[error("the tool is engaged: release it first")]
    Engaged,
    /// Tools need a contact surface, and the model has none.
    #[error(
        "the model has no contact surface: bake a mesh with triangles or tetrahedra, a lean model with \
         `contact_surface` yes"
    )]
    NoContactSurface,
    /// The number of tools is 0 or above the tissue's capacity.
    #[error("{needed} tools: there must be 1 to {capacity}, as many as the tissue has room for")]
    Tools {
        /// Tools asked for.
        needed: usize,
        /// Most tools.
        capacity: usize,
    },
    /// A tool has no parts, or too many.
    #[error("tool {tool} must have 1 to {most} parts")]
    Parts {
        /// The tool, from 0.
        tool: usize,
        /// Most parts.
        most: usize,
    },
    /// The shape of a tool's part is invalid.
    #[error(
        "part {part} of tool {tool}: its radius must be above 0, its lengths finite and not \
         negative, its turn a unit quaternion"
    )]
    Part {
        /// The tool, from 0.
        tool: usize,
        /// The part, from 0.
        part: usize,
    },
    /// A tool has more than one edge, or parts behind it.
    #[error("part {part} of tool {tool} is an edge: a tool has one edge, as its last part")]
    Edge {
        /// The tool, from 0.
        tool: usize,
        /// The part, from 0.
        part: usize,
    },
    /// An edge cuts, and this body cannot be cut.
    #[error(
        "an edge needs a body that can be cut, and memory for it: bake the body with `cuttable`, and run it in a \
         program that cuts"
    )]
    CannotCut,
    /// The coefficient of friction is out of its range.
    #[error("friction must be 0 to {max}")]
    Friction {
        /// Largest coefficient.
        max: f32,
    },
    /// Friction holds samples, and the tissue has no memory for anchors.
    #[error("friction needs room for anchors: give the tissue some")]
    AnchorRoom,
    /// The tissue has too little memory for tools and the model's coarse level: size it with
    /// [`tool_room`](crate::tool_room).
    #[error(
        "tools need {needed} blocks of eight f32 for the coarse level, there is room for \
         {room}: size it with tool_room, or bake it with `coarse` none"
    )]
    ToolRoom {
        /// Blocks needed.
        needed: usize,
        /// Blocks that the tissue has.
        room: usize,
    },
    /// This kernel is built without the feature `surface`.
    #[error(
        "this program has no contact with tools: build it with the feature `surface`, or hold cells"
    )]
    SurfaceUnbuilt,
    /// The scheme has no contact on surfaces.
    #[error(
        "tools touch tissue under track and predict in single precision alone: take one of them, or \
         hold cells"
    )]
    SurfaceScheme,
    /// The radius needs more samples than a triangle can have.
    #[error("the radius of a tool's part must be at least {min_m} m on this model's surface")]
    RadiusMin {
        /// Smallest radius \[m\].
        min_m: f32,
    },
    /// The tissue has too little memory for tools on the surface.
    #[error("tools on the surface need room for {needed} cells, there is room for {capacity}")]
    SurfaceRoom {
        /// Cells of the model.
        needed: usize,
        /// Cells that the memory holds.
        capacity: usize,
    },
}

/// Why a pin is refused; nothing has changed.
///
/// ```
#[doc = include_str!("example.txt")]
/// # if !FEATURES.contains(&"pins") {
/// #     return Ok(());
/// # }
/// use chaincell_kernel::PinError;
///
/// let far = tissue.pin_at(&network, [0.0, 0.0, 0.1], 0.005, f32::INFINITY);
/// assert!(matches!(far, Err(PinError::Reach { .. }))); // the surface ends 66 mm below
/// assert_eq!(tissue.pin_held(&network, 0, f32::INFINITY), Err(PinError::NothingHeld(0)));
/// assert_eq!(tissue.unpin(3, 20), Err(PinError::Unknown(3)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PinError {
    /// The tissue was not reset to this network.
    #[error("the tissue belongs to another network: reset it first")]
    Model,
    /// This kernel is built without the feature `pins`.
    #[error("this program has no pins: build it with the feature `pins`")]
    Unbuilt,
    /// No tools are chosen: a pin holds the surface that tools touch.
    #[error(
        "pins hold the surface that tools touch: choose tools first, on a model with a contact surface"
    )]
    NoTools,
    /// Point, radius or stiffness cannot be.
    #[error(
        "the point of a pin must be finite, its radius finite and above 0, its stiffness at least 1e-6 N/m; infinite is rigid"
    )]
    Value,
    /// No sample of the surface lies within the radius.
    #[error(
        "no sample of the surface lies within the radius, the nearest is {nearest_m} m away: move the point, or take a larger radius"
    )]
    Reach {
        /// Distance of the nearest sample from the point \[m\].
        nearest_m: f32,
    },
    /// The memory for pinned samples is full.
    #[error(
        "the pin holds {needed} samples, there is room for {capacity} more: take a smaller radius, or release another pin"
    )]
    Room {
        /// Samples of the pin.
        needed: usize,
        /// Samples for which there is room.
        capacity: usize,
    },
    /// The tool does not exist, or neither grips nor touches anything.
    #[error("tool {0} neither grips nor touches the tissue: press it on first")]
    NothingHeld(usize),
    /// No pin has this number.
    #[error("there is no pin {0}: pins have the numbers that they got when they were set")]
    Unknown(u16),
}
