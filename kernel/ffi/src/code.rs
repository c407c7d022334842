//! Result codes: what was refused and why, stable numbers for C.

use core::ffi::CStr;

chaincell_kernel::codes! {
    /// What a call came to: 0 when all is well, negative when it was refused.
    ///
    /// A number never changes its meaning; `chaincell_code_text` says it in words.
    Code: i32, CStr {
        /// Done.
        Ok = 0, c"ok";
        /// A pointer is null.
        Null = -1, c"a pointer is null: only that of the detail may be";
        /// A pointer does not have the alignment of what it points to.
        Misaligned = -2, c"a pointer is misaligned: tissue storage starts at a multiple of 16";
        /// The storage is too small: `needed` and `available` bytes.
        Storage = -3, c"the storage is too small: ask chaincell_model_size";
        /// No model or tissue stands there: initialise it first.
        NotInitialised = -4, c"no model or tissue stands there: initialise it first";
        /// No such scheme.
        Scheme = -5, c"no such scheme: see chaincell_scheme";
        /// A number is out of its range: the model's number of cells bounds it, or what its function or
        /// field says; `needed` what was asked for, `available` the most.
        Range = -6, c"a number is out of its range: cells bound it, or what the header says there";
        /// No cell has this input id: `position` in the list.
        UnknownId = -7, c"no cell has this input id: take one of the input mesh's nodes";
        /// A body of links has no stress.
        NoStress = -8, c"a body of links has no stress: bake it with --young-pa";
        /// The image does not start at a multiple of 16.
        ModelMisaligned = -20,
            c"the image does not start at a multiple of 16 bytes: place it with CHAINCELL_ALIGNED";
        /// The image ends before it is complete.
        ModelTruncated = -21, c"the image is truncated: copy or bake it again";
        /// The first bytes are not those of a model image.
        ModelMagic = -22, c"not a chaincell model: bake one with `chaincell bake`";
        /// The image has format `available`, this library reads `needed`.
        ModelVersion = -23, c"the image has another format version: bake it again";
        /// The checksum does not match: the bytes were changed after the bake.
        ModelChecksum = -24, c"the image's checksum does not match: copy or bake it again";
        /// The header or the section table contradicts itself.
        ModelLayout = -25, c"the image's section table contradicts itself: bake it again";
        /// A required section is missing: `section`.
        ModelMissing = -26, c"a section of the image is missing: bake it again";
        /// A section has a version that this library does not read: `section`.
        ModelSectionVersion = -27, c"a section has an unknown version: bake the model again";
        /// A section has the wrong size: `section`.
        ModelSectionSize = -28, c"a section of the image has the wrong size: bake it again";
        /// A scalar of the body is out of range: `position` is its word.
        ModelParameter = -29, c"a parameter of the image is out of range: bake it again";
        /// An index is out of range or order: `section`, `position`.
        ModelIndex = -30, c"an index of the image is out of range or order: bake it again";
        /// A number is not finite or out of range: `section`, `position`.
        ModelValue = -31, c"a value of the image is out of range: bake it again";
        /// `sweeps` is not in 1 to 65,535.
        SettingsSweeps = -40, c"sweeps must be 1 to 65535";
        /// `step` is not above 0 and at most `limit`, the model's proven bound.
        SettingsStep = -41, c"step must be above 0 and at most the model's bound, step_max";
        /// `tick_time` is not finite, or below `limit`.
        SettingsTickTime = -42, c"tick_time must be finite, and at least the smallest time";
        /// `max_tool_step_m` is not positive and finite.
        SettingsMaxToolStep = -43, c"max_tool_step_m must be positive and finite";
        /// `max_force_n` is not positive.
        SettingsMaxForce = -44, c"max_force_n must be positive";
        /// `unloading` is none of its three values, or not off where links relax.
        SettingsUnloading = -45, c"unloading is none of chaincell_unloading, or not off where links relax";
        /// `drive` is neither of its two values.
        SettingsDrive = -46, c"drive is none of chaincell_drive";
        /// `cut` is neither of its two values.
        SettingsCut = -47, c"cut is none of chaincell_cutting";
        /// The tissue has too few cells for the model: `needed`, `available`.
        ResetCapacity = -60, c"the model has more cells than the tissue";
        /// Too little room for the coarse level: `needed`, `available` blocks of eight `float`.
        ResetCoarse = -61, c"too little room for the model's coarse functions: bake with --coarse none";
        /// The thread's arithmetic flushes denormals to zero (FTZ, DAZ or FZ is on).
        FloatFlushToZero = -63, c"denormals are flushed to zero: switch FTZ/DAZ/FZ off";
        /// The thread's arithmetic does not round to nearest.
        FloatRounding = -64, c"rounding is not to nearest: restore the default rounding mode";
        /// The model leaves the range of the scheme's numbers: `limit` is the one that it leaves.
        ResetRange = -65,
            c"the model leaves the range of fixed point: bake it with a smaller --k-m, or take another scheme";
        /// A body of nodal shapes needs track or predict.
        ResetShapes = -66, c"a body of nodal shapes needs the scheme track or predict";
        /// Floating-point exceptions stop the program on this thread.
        FloatTrap = -67,
            c"floating-point exceptions stop the program: mask them, by fedisableexcept(FE_ALL_EXCEPT)";
        /// More contact cells than the tissue has room for: `needed`, `available`.
        ContactCapacity = -80, c"more contact cells than the tissue was initialised for";
        /// The contact cell is not in the model: `position` in the list.
        ContactUnknown = -81, c"a contact cell is not in the model";
        /// The contact cell is fixed: `position` in the list.
        ContactFixed = -82, c"a contact cell is fixed and cannot be held by the tool";
        /// The contact cell is named twice: `position` of the second one in the list.
        ContactRepeated = -83, c"a contact cell stands twice in the list";
        /// The tissue belongs to another model.
        ContactModel = -84, c"the tissue belongs to another model: initialise it again";
        /// Too little room to hold that many cells beside the coarse level: `needed`, `available`
        /// blocks of eight `float`.
        ContactCoarse = -85, c"too little room to hold these cells against the coarse functions";
        /// The tool is engaged: other cells can be chosen only while it is released.
        ContactEngaged = -86, c"the tool is engaged: release it first";
        /// This library or scheme has no contact with tools: take track or predict.
        ContactScheme = -90, c"no contact with tools here: take track or predict, or hold cells";
        /// Tools meet the triangles of a surface, and this model has none: bake it with
        /// `--contact-surface yes`.
        ContactNoSurface = -91, c"no contact surface: bake --contact-surface yes";
        /// No tools, or more than the tissue has room for: `needed`, `available`.
        ContactTools = -92, c"there must be 1 tool to as many as the tissue has room for";
        /// A tool has no parts, or too many: `position` is the tool, `needed` its parts, `available` the
        /// most.
        ContactParts = -93, c"a tool must have 1 to 8 parts";
        /// A part of a tool cannot be: `position` in the list of all parts.
        ContactPart = -94,
            c"a part's radius must be above 0, its lengths finite and not negative, its turn a unit quaternion";
        /// Friction is not within 0 and `limit`.
        ContactFriction = -95, c"friction must be 0 to 10";
        /// Friction holds samples, and the tissue has no room for any.
        ContactSamples = -96, c"friction needs room for samples: see chaincell_room";
        /// The tissue has no room for contact on surfaces: `needed` cells, `available`.
        ContactRoom = -97, c"no room for contact on surfaces: initialise with a chaincell_room";
        /// A radius is below `limit`, the smallest that this model's surface takes \[m\].
        ContactRadiusMin = -98, c"the radius is too small for the triangles of this surface";
        /// The tissue belongs to another model.
        StateModel = -100, c"the tissue belongs to another model: initialise it again";
        /// More or fewer positions than cells: `needed`, `available`.
        StateCount = -101, c"there must be one position for each cell";
        /// A coordinate is not finite or too large: `position` is its cell.
        StatePosition = -102, c"coordinates must be finite and at most 1e6 mean link lengths";
        /// `tick_s` is not within 1e-5 to 1.
        StageTick = -120, c"tick_s must be 1e-5 to 1";
        /// The coupling's stiffness or damping is negative or above 1e6.
        StageCoupling = -121, c"the coupling's stiffness and damping must be 0 to 1e6";
        /// The device's damping is negative or above 1e6, or the delay above 16 ticks, without a
        /// coupling above 1.
        StagePassivity = -122,
            c"the device's damping must be 0 to 1e6 N s/m, the delay 0 to 16 ticks, without a coupling 0 or 1";
        /// `max_slew_n_per_s` is not positive.
        StageSlew = -123, c"max_slew_n_per_s must be positive";
        /// The stage's `max_force_n` is not positive.
        StageMaxForce = -124, c"the stage's max_force_n must be positive";
        /// `ramp_ticks` or `watchdog_ticks` is above 60,000.
        StageTicks = -125, c"ramp_ticks and watchdog_ticks must be at most 60000";
        /// No such device.
        StageDevice = -126, c"no such device: see chaincell_device";
        /// The stage's `max_speed_m_per_s` is not positive.
        StageMaxSpeed = -127, c"max_speed_m_per_s must be positive";
        /// The buffer is shorter than the snapshot: `needed`, `available` bytes.
        SnapshotBuffer = -140, c"the buffer is shorter than the snapshot: ask for its size";
        /// The bytes are no snapshot.
        SnapshotMagic = -141, c"not a snapshot";
        /// Another version of snapshots: `needed`, `available`.
        SnapshotVersion = -142, c"another version of snapshots: save it by this release";
        /// The snapshot is of another scheme or release.
        SnapshotLayout = -143, c"the snapshot is of another scheme or release: use the one that saved it";
        /// The snapshot is of another model.
        SnapshotModel = -144, c"the snapshot is of another model: load that one";
        /// The snapshot is not whole.
        SnapshotLength = -145, c"the snapshot is not whole: copy or save it again";
        /// The snapshot's checksum does not match.
        SnapshotChecksum = -146, c"the snapshot's checksum does not match: copy it again";
        /// A value that cannot be: `position` is its word behind the header.
        SnapshotValue = -147, c"a value in the snapshot cannot be: save it again";
        /// Too little room for what the snapshot has: `needed`, `available`.
        SnapshotRoom = -148, c"too little room for the snapshot: initialise with that of the saved";
        /// This model's body cannot be cut.
        CutModel = -160, c"the body cannot be cut: bake it with --cuttable";
        /// The tissue has no memory for cuts.
        CutRoom = -161, c"no memory for cuts: initialise with `cuts` in the chaincell_room";
        /// The model has no such face: `position` in the list.
        CutFace = -162, c"no such face: take a tetrahedron of the input mesh and a corner from 0 to 3";
        /// Pins hold the surface that tools touch, and no tools are chosen.
        PinTools = -180, c"pins hold the surface that tools touch: choose tools first";
        /// Point, radius or stiffness of a pin cannot be.
        PinValue = -181, c"a pin's point must be finite, its radius finite and above 0, its stiffness at least 1e-6 N/m";
        /// No sample of the surface lies within the radius; `limit` is the distance of the nearest one \[m\].
        PinReach = -182, c"no sample of the surface within the radius: move the point, or take a larger radius";
        /// Too little room for the samples of the pin: `needed`, `available`.
        PinRoom = -183, c"too little room for the pin: release another, or initialise with more `pins`";
        /// The tool neither grips nor touches the tissue: `position`.
        PinNothingHeld = -184, c"the tool neither grips nor touches the tissue: press it on first";
        /// No pin has this number.
        PinUnknown = -185, c"no pin has this number: take that which the pin got when it was set";
    }
}

/// Where and by how much a call was refused; what a code does not name is 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Detail {
    /// Section of the image, a number as in the kernel's `image::kind`.
    pub section: u32,
    /// Position in the section, in the list or among the cells.
    pub position: u32,
    /// What is needed, in the code's own unit.
    pub needed: usize,
    /// What is there, in the same unit.
    pub available: usize,
    /// Largest or smallest admitted value, in the code's own unit: a step \[dimensionless time\],
    /// the number that the model leaves, a radius \[m\], or friction.
    pub limit: f32,
}

/// A code with its detail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refusal {
    /// What was refused.
    pub code: Code,
    /// Where, and by how much.
    pub detail: Detail,
}

impl Refusal {
    pub(crate) fn sizes(code: Code, needed: usize, available: usize) -> Self {
        Self { code, detail: Detail { needed, available, ..Detail::default() } }
    }

    pub(crate) fn with_sizes(mut self, needed: usize, available: usize) -> Self {
        (self.detail.needed, self.detail.available) = (needed, available);
        self
    }

    pub(crate) fn position(code: Code, position: usize) -> Self {
        let position = u32::try_from(position).unwrap_or(u32::MAX);
        Self { code, detail: Detail { position, ..Detail::default() } }
    }

    pub(crate) fn limit(code: Code, limit: f32) -> Self {
        Self { code, detail: Detail { limit, ..Detail::default() } }
    }

    pub(crate) fn section(code: Code, section: u32, position: u32) -> Self {
        Self { code, detail: Detail { section, position, ..Detail::default() } }
    }
}

impl From<Code> for Refusal {
    fn from(code: Code) -> Self {
        Self { code, detail: Detail::default() }
    }
}
