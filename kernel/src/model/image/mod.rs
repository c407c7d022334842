//! The model image: a flat little-endian file of versioned sections, read in place.
//!
//! ```text
//! offset  bytes  content
//!      0      8  magic "CHAINCEL"
//!      8      4  format version (1)
//!     12      4  bytes of the whole image
//!     16      4  number of sections
//!     20      4  CRC-32 (ISO-HDLC) of all bytes but these four
//!     24      8  zero
//!     32   16 n  section table: kind, version, offset, bytes (u32 each)
//!      …         sections, each at a multiple of 16 bytes
//! ```
//!
//! A section that a model does not need is absent and costs nothing. Unknown kinds are skipped,
//! a known kind with an unknown version is refused.

mod error;
mod sections;

pub use error::ModelError;
pub(crate) use sections::Sections;
pub use sections::checksum;
pub(crate) use sections::checksum_but;

/// First bytes of every image.
pub const MAGIC: [u8; 8] = *b"CHAINCEL";
/// Version of the format this kernel reads.
pub const FORMAT_VERSION: u32 = 1;
/// Version of every section defined here.
pub const SECTION_VERSION: u32 = 1;
/// Bytes before the section table.
pub const HEADER_BYTES: usize = 32;
/// Bytes of one entry of the section table.
pub const ENTRY_BYTES: usize = 16;
/// Alignment of the image and of every section.
pub const ALIGNMENT: usize = 16;
/// Largest number of cells: ids are 16 bits wide, and 65,535 stays free.
pub const CELLS_MAX: usize = 65_535;
/// Most coarse functions.
pub const COARSE_MAX: usize = 1024;
/// Largest factor of the local part of a cell's direction.
pub const COARSE_FACTOR_MAX: f32 = 1.0e4;
/// Most sets of stiffening bands.
pub const STIFFENING_MAX: usize = 6;
/// Most branches of relaxation.
pub const BRANCHES_MAX: usize = 4;
/// Corner without a coarse function, and cell without an entry.
pub const NO_FUNCTION: u16 = u16::MAX;
/// Cells of a node of the embedded mesh.
pub const FINE_CELLS: usize = 8;
/// Cell of a node that is left out.
pub const NO_CELL: u16 = u16::MAX;
/// Offset of the checksum \[bytes\].
pub const CHECKSUM_OFFSET: usize = 20;

/// Section kinds. Element types in brackets; `half-links` = links counted at their upper end.
pub mod kind {
    /// Scalars of the body, see [`super::params`] (u32 or f32, 16 words).
    pub const PARAMS: u32 = 1;
    /// Rest positions from the body's centre in mean link lengths ([f32; 3] a cell).
    pub const REST: u32 = 2;
    /// Row starts: the links of cell i, as the lower end, are `ROWS[i]..ROWS[i + 1]`
    /// (u32, cells + 1).
    pub const ROWS: u32 = 3;
    /// Upper end of each link, ascending within a row (u16 a link).
    pub const UPPER: u32 = 4;
    /// Rest length of each link in mean link lengths (f32 a link).
    pub const REST_LENGTH: u32 = 5;
    /// Row starts of the half-links: cell i as the upper end (u32, cells + 1).
    pub const BACK_ROWS: u32 = 6;
    /// Lower end of each half-link, ascending within a row (u16 a link).
    pub const LOWER: u32 = 7;
    /// Link of each half-link (u32 a link).
    pub const BACK_LINK: u32 = 8;
    /// Mobility 1 / W of each cell, W = sum of its links' weights; 0 for a fixed-state cell,
    /// for a cell without links and for a spare cell (f32 a cell).
    pub const MOBILITY: u32 = 9;
    /// Fixed-state cells, ascending (u16).
    pub const FIXED: u32 = 10;
    /// Input id of each cell but the spare ones (u32 a cell).
    pub const INPUT_ID: u32 = 11;
    /// Optional: alpha of each link (f32 a link).
    pub const ALPHA: u32 = 12;
    /// Optional: weight k / `k_ref` of each link (f32 a link).
    pub const WEIGHT: u32 = 13;
    /// Optional: surface cells, ascending (u16).
    pub const SURFACE: u32 = 14;
    /// With `SURFACE`: outward unit normals ([f32; 3] a surface cell).
    pub const NORMALS: u32 = 15;
    /// Optional, for display: surface triangles, outward ([u16; 3]).
    pub const TRIANGLES: u32 = 16;
    /// Optional, for display: tetrahedra ([u16; 4]).
    pub const TETRAHEDRA: u32 = 17;
    /// Optional: starts of the slices of eight consecutive cells, in groups of eight slots. Slices repeat the
    /// links of every cell, lane by lane, for vector units; a slice has as many groups as its most linked
    /// cell has links (u32, slices + 1).
    pub const SLICE_ROWS: u32 = 19;
    /// With `SLICE_ROWS`: other end of each slot, ascending in each lane, then the lane's own cell
    /// (u16, 8 a group).
    pub const SLICE_NEIGHBOURS: u32 = 20;
    /// With `SLICE_ROWS`: rest length of each slot, 0 for padding (f32, 8 a group).
    pub const SLICE_LENGTHS: u32 = 21;
    /// With `SLICE_ROWS` and `ALPHA`: alpha of each slot (f32, 8 a group).
    pub const SLICE_ALPHAS: u32 = 22;
    /// With `SLICE_ROWS` and `WEIGHT`: weight of each slot, 1 for padding (f32, 8 a group).
    pub const SLICE_WEIGHTS: u32 = 23;
    /// Optional: number of coarse functions (u32, one word).
    pub const COARSE: u32 = 24;
    /// With `COARSE`: starts of the boxes' pairs in `COARSE_CELLS`, none empty (u32, boxes + 1).
    pub const COARSE_ROWS: u32 = 25;
    /// With `COARSE`: the basis functions at the corners of each box; [`super::NO_FUNCTION`] for none
    /// ([u16; 8]).
    pub const COARSE_CORNERS: u32 = 26;
    /// With `COARSE`: the free cells, box by box, in pairs; the last cell of an odd number is repeated
    /// ([u16; 2]).
    pub const COARSE_CELLS: u32 = 27;
    /// With `COARSE`: weights of those cells at the corners of their box, corner 0 of the first and of the
    /// second cell, corner 1 and so on; 0 where a cell is repeated ([f32; 16] a pair).
    pub const COARSE_WEIGHTS: u32 = 28;
    /// With `COARSE`: first position of each cell in `COARSE_CELLS`, 65,535 for a cell of mobility 0 (u16 a cell).
    pub const COARSE_ENTRY: u32 = 29;
    /// With `COARSE`: the inverse, symmetric, rows padded with zeros to a multiple of 8 (f32). With `COARSE_TURNS`
    /// it is that of all three axes together: rows and columns of x, then of y and of z, each padded.
    pub const COARSE_INVERSE: u32 = 30;
    /// Optional: notes of the host, opaque to the kernel (bytes).
    pub const NOTES: u32 = 18;
    /// Optional: rest positions of the nodes of a mesh finer than the network, by input id
    /// ([f32; 3], input nodes).
    pub const FINE_REST: u32 = 33;
    /// With `FINE_REST`: the cells of each node, its own first; [`super::NO_CELL`] for a
    /// node that is left out ([u16; 8] a node).
    pub const FINE_CELLS: u32 = 34;
    /// With `FINE_REST`: the weights of those cells, 1 in all ([f32; 8] a node).
    pub const FINE_WEIGHTS: u32 = 35;
    /// With `FINE_REST`, optional, for display: surface triangles over the nodes, outward
    /// ([u32; 3]).
    pub const FINE_TRIANGLES: u32 = 36;
    /// With `FINE_REST`, optional, for display: tetrahedra over the nodes ([u32; 4]).
    pub const FINE_TETRAHEDRA: u32 = 37;
    /// Optional, needs `SLICE_ROWS`: the body is made of nodal shapes, its links carry no force;
    /// the law of the shape, [`super::LAW_DET1`], and the bits of the stretch at which the band begins, 0
    /// for none (u32, two words). Another law is refused as another version of the section.
    pub const NODAL: u32 = 38;
    /// With `NODAL`: numbers of the cells, by slice, number and lane, see [`super::nodal`]
    /// ([[f32; 8]; 8] a slice).
    pub const NODAL_CELLS: u32 = 39;
    /// With `NODAL`: numbers of the half-links, by group of `SLICE_ROWS`, number and lane, see
    /// [`super::nodal`] ([[f32; 8]; 4] a group).
    pub const NODAL_SLOTS: u32 = 40;
    /// With `COARSE` and `NODAL`: the cell whose rotation each basis function takes (u16).
    pub const COARSE_TURNS: u32 = 41;
    /// With `COARSE_TURNS`: length of the local part of each cell's direction, relative to r / W (f32 a cell).
    pub const COARSE_FACTORS: u32 = 42;
    /// With `NODAL`, optional: sets of bands on the links, the narrowest first, at most
    /// [`super::STIFFENING_MAX`]; the bits of half the width in rest lengths and of the modulus
    /// [2 `k_ref` / l] ([u32; 2]). With a half width below 0 a set resists links that are shorter than its band
    /// alone, with a modulus below 0 those that are longer alone.
    pub const STIFFENING: u32 = 43;
    /// With `STIFFENING`: 2 V / l0^2 of each slot of `SLICE_ROWS`, V the volume of the tetrahedra
    /// around its link; 0 for padding (f32, 8 a group).
    pub const STIFFENING_SLOTS: u32 = 44;
    /// With `TRIANGLES`, optional: the contact numbers of each triangle, see [`super::contact`]
    /// ([f32; 3] a triangle); without it tools are refused.
    pub const CONTACT: u32 = 45;
    /// With `CUTTING`: the cells of each tetrahedron, of positive volume, in the mesh's order ([u16; 4]).
    pub const CUT_CORNERS: u32 = 46;
    /// With `CUTTING`: starts of the cells' tetrahedra in `CUT_STARS`; none is a spare cell's (u32, cells + 1).
    pub const CUT_STAR_ROWS: u32 = 47;
    /// With `CUTTING`: the tetrahedra at each cell, ascending (u32, 4 a tetrahedron).
    pub const CUT_STARS: u32 = 48;
    /// Optional: the body can be cut, see [`super::cutting`] (u32 or f32, 4 words, 6 if it tears). Its last cells are
    /// spare: they have no links, no input id and mobility 0, rest at the centre and exert no force.
    pub const CUTTING: u32 = 49;
    /// Without `CUTTING`, optional: branches of relaxation in ascending time, at most [`super::BRANCHES_MAX`], see
    /// [`super::branch`] ([f32; 10] a branch). The moduli of `NODAL_CELLS` and `NODAL_SLOTS` are then the
    /// instantaneous ones; without `NODAL` the stiffness of the links is, and the image has their slices.
    pub const BRANCHES: u32 = 50;
    /// With `CUTTING`, optional: toughness of each cell but the spare ones (f32) \[J/m^2\]; without it all cells have
    /// that of `CUTTING`.
    pub const CUT_TOUGHNESS: u32 = 51;
}

/// The law of `NODAL` that holds the volume by the distance to the shapes of determinant 1.
pub const LAW_DET1: u32 = 0;

/// Row indices of the sections of nodal shapes. Lengths in mean link lengths l, stresses in 2 `k_ref` / l, so
/// that energies have the kernel's internal unit.
pub mod nodal {
    /// Most links of a cell, far above those of a mesh: the cost of the checks grows with its square.
    pub const LINKS_MAX: usize = 1024;
    /// Numbers of a cell.
    pub const CELL_ROWS: usize = 8;
    /// `V_i`: a quarter of the volume of its tetrahedra; 1 beyond the last cell.
    pub const VOLUME: usize = 0;
    /// mu, the shear modulus.
    pub const MU: usize = 1;
    /// Smallest mu. A spare cell has this mu and bound, volume 1 and else zeros.
    pub const MU_MIN: f32 = 1.0e-6;
    /// 3 lambda.
    pub const LAMBDA_3: usize = 2;
    /// `a_ii`, three rows: minus the sum of its half-links' `a_ij`.
    pub const OWN: usize = 3;
    /// At least the sum of the magnitudes of its row in the bound L of the curvature.
    pub const BOUND: usize = 6;
    /// Stiffness of the band of stretches; 0 for none.
    pub const BAND: usize = 7;

    /// Numbers of a half-link from cell i, its lane, to the other end j. 0 for padding.
    pub const SLOT_ROWS: usize = 4;
    /// `a_ij`, three rows: sum over the tetrahedra with both of `V_t` / 4 times the gradient of
    /// j's hat function.
    pub const AREA: usize = 0;
    /// 2 beta times the sum over the same tetrahedra of mu `V_t` times minus the product of both
    /// gradients, mu the mean of the corners'.
    pub const SPREAD: usize = 3;

    /// Beta, the part of the shape's stiffness that acts on tetrahedra.
    pub const BETA: f32 = 0.2;
}

/// Indices of the numbers of `BRANCHES`.
pub mod branch {
    /// Number of numbers of a branch.
    pub const WORDS: usize = 10;
    /// Share of the instantaneous modulus; 0.99 in all at most.
    pub const SHARE: usize = 0;
    /// Time tau in which it fades to 1 / e \[ticks\], 1 to 1,600,000.
    pub const TIME_TICKS: usize = 1;
    /// Length of a tick, the same in all branches \[s\].
    pub const TICK_S: usize = 2;
    /// First of seven parts that fade in 1, 2, 4, … 64 ticks: 1 - exp(-ticks / tau).
    pub const FADED: usize = 3;
}

/// Version of the first word of `CUTTING` of a body that does not tear.
pub const CUTTING_VERSION: u32 = 1;
/// Version of the first word of `CUTTING` of a body that tears.
pub const TEARING_VERSION: u32 = 2;

/// Word indices of the `CUTTING` section.
pub mod cutting {
    /// Number of words of a body that does not tear.
    pub const WORDS: usize = 4;
    /// Number of words of a body that tears.
    pub const TEARING_WORDS: usize = 6;
    /// [`super::CUTTING_VERSION`], or [`super::TEARING_VERSION`]; in the upper half what becomes of loose pieces, see
    /// [`Loose::word`](crate::Loose::word) (u32).
    pub const VERSION: usize = 0;
    /// Number of spare cells, the last ones of the body (u32).
    pub const SPARE_CELLS: usize = 1;
    /// Groups of eight half-links to keep in reserve, in all (u32).
    pub const SPARE_GROUPS: usize = 2;
    /// Energy that a cut takes for each area, the largest of all cells' (f32) \[J/m^2\].
    pub const TOUGHNESS_J_PER_M2: usize = 3;
    /// Limit at which the body tears: [`BY_TOUGHNESS`] or [`BY_STRETCH`] (u32).
    pub const TEAR_RULE: usize = 4;
    /// The stretch of [`BY_STRETCH`], 1.01 to 10; else 0 (f32).
    pub const TEAR_STRETCH: usize = 5;
    /// The limit [`TearLimit::Toughness`](crate::TearLimit).
    pub const BY_TOUGHNESS: u32 = 1;
    /// The limit [`TearLimit::Stretch`](crate::TearLimit).
    pub const BY_STRETCH: u32 = 2;
}

/// Indices of the numbers of `CONTACT`, in mean link lengths l.
pub mod contact {
    /// E a / h [2 `k_ref`]: a the area at rest, h the mean length of the edges, E the mean of the corners'
    /// Young's moduli; for links, of the moduli to which they are equivalent.
    pub const STIFFNESS: usize = 0;
    /// h in l.
    pub const EDGE: usize = 1;
    /// a in l^2.
    pub const AREA: usize = 2;
}

/// Word indices of the `PARAMS` section.
pub mod params {
    /// Number of words.
    pub const WORDS: usize = 16;
    /// Number of cells (u32).
    pub const CELLS: usize = 0;
    /// Number of links (u32).
    pub const LINKS: usize = 1;
    /// Dimension of the grid, 1 to 3 (u32).
    pub const DIMENSION: usize = 2;
    /// Mean link length, the internal unit (f32) \[m\].
    pub const UNIT_M: usize = 3;
    /// Centre of the body, three words (f32) \[m\].
    pub const CENTRE_M: usize = 4;
    /// Stiffness of a link of weight 1 (f32) [N/m].
    pub const STIFFNESS_N_PER_M: usize = 7;
    /// Half-width of the band in rest lengths; the mean if links differ (f32).
    pub const ALPHA: usize = 8;
    /// Saturation K (f32) [mean link lengths].
    pub const SATURATION: usize = 9;
    /// Cell resistance `R_x` (f32).
    pub const RESISTANCE: usize = 10;
    /// Cell capacitance C (f32).
    pub const CAPACITANCE: usize = 11;
    /// b, the largest (`W_i` + `W_j`) / 2 over the links (f32).
    pub const DEGREE_BOUND: usize = 12;
    /// Largest energy a tool may load into the body (f32), in internal units.
    pub const ENERGY_MAX: usize = 13;
    /// Number of connected parts (u32).
    pub const PARTS: usize = 14;
    /// Number of nodes of the input's numbering (u32).
    pub const INPUT_NODES: usize = 15;
}
