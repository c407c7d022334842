//! The properties of a model's body.

use core::ops::Range;

use super::branches::Branch;
use super::layout::Layout;
use super::parts::Parts;
use super::surface::ContactSurface;
use super::terms::TermData;
use super::{Model, range};
use crate::number::two_float::LANES;

impl<'a> Model<'a> {
    /// Number of cells, including the spare ones of a body that can be cut.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.rest.len()
    }

    /// Number of links.
    #[must_use]
    pub fn links(&self) -> usize {
        self.upper.len()
    }

    /// Dimension of the grid, 1 to 3.
    #[must_use]
    pub fn dimension(&self) -> u32 {
        self.dimension
    }

    /// Number of connected parts.
    #[must_use]
    pub fn parts(&self) -> u32 {
        self.parts
    }

    /// Checksum of the image; it identifies the model.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        self.checksum
    }

    /// Mean link length, the kernel's internal unit of length \[m\].
    #[must_use]
    pub fn unit_m(&self) -> f32 {
        self.unit_m
    }

    /// The body's centre, origin of the internal frame \[m\].
    #[must_use]
    pub fn centre_m(&self) -> [f32; 3] {
        self.centre_m
    }

    /// Stiffness of a link of weight 1 [N/m].
    #[must_use]
    pub fn stiffness_n_per_m(&self) -> f32 {
        self.stiffness_n_per_m
    }

    /// Half-width of the links' band in rest lengths (Eq. 5); the mean if links differ.
    #[must_use]
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    /// Returns true if some link has a band: it admits lengths other than its rest length. Cost: a read of
    /// each link if alpha differs between links.
    #[must_use]
    pub fn has_slack(&self) -> bool {
        match self.link_alphas {
            Some(alphas) => alphas.iter().any(|&alpha| alpha > 0.0),
            None => self.alpha > 0.0,
        }
    }

    /// Saturation K of the output (Eq. 3) [mean link lengths].
    #[must_use]
    pub fn saturation(&self) -> f32 {
        self.saturation
    }

    /// Cell resistance `R_x` (Eq. 2).
    #[must_use]
    pub fn resistance(&self) -> f32 {
        self.resistance
    }

    /// Cell capacitance C (Eq. 2).
    #[must_use]
    pub fn capacitance(&self) -> f32 {
        self.capacitance
    }

    /// Largest proven common step of `euler`, 2 C / b with b the largest (`W_i` + `W_j`) / 2 over
    /// the links, and at most `R_x` C [dimensionless time].
    #[must_use]
    pub fn step_max(&self) -> f32 {
        let links = 2.0 * self.capacitance / self.degree_bound;
        let leak = self.resistance * self.capacitance;
        if leak < links { leak } else { links }
    }

    /// Smallest time that `rkl2` advances a tick, 1e-12 of [`Self::step_max`]
    /// [dimensionless time].
    #[must_use]
    pub fn tick_time_min(&self) -> f32 {
        let least = 1.0e-12 * self.step_max();
        if least > f32::MIN_POSITIVE { least } else { f32::MIN_POSITIVE }
    }

    /// Largest energy a tool may load into the body, in internal units
    /// (times [`Self::energy_unit_j`] in joules).
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// let most_j = model.energy_max() * model.energy_unit_j();
    /// assert!((4.0..4.2).contains(&most_j)); // [J]
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[must_use]
    pub fn energy_max(&self) -> f32 {
        self.energy_max
    }

    /// Newtons per internal unit of force, 2 `k_ref` times the mean link length.
    #[must_use]
    pub fn force_unit_n(&self) -> f32 {
        2.0 * self.stiffness_n_per_m * self.unit_m
    }

    /// Joules per internal unit of energy, 2 `k_ref` times the mean link length squared.
    #[must_use]
    pub fn energy_unit_j(&self) -> f32 {
        self.force_unit_n() * self.unit_m
    }

    /// Fixed-state cells, ascending.
    #[must_use]
    pub fn fixed(&self) -> &'a [u16] {
        self.fixed
    }

    /// Returns true if a cell's state is fixed. Cost: a binary search in [`Self::fixed`].
    #[must_use]
    pub fn is_fixed(&self, cell: u16) -> bool {
        self.fixed.binary_search(&cell).is_ok()
    }

    /// Surface cells, ascending; empty if the bake stored none.
    #[must_use]
    pub fn surface(&self) -> &'a [u16] {
        self.surface
    }

    /// Outward unit normals of the surface cells, in their order.
    #[must_use]
    pub fn normals(&self) -> &'a [[f32; 3]] {
        self.normals
    }

    /// Surface triangles for display, as cells, outward.
    #[must_use]
    pub fn triangles(&self) -> &'a [[u16; 3]] {
        self.triangles
    }

    /// Tetrahedra for display, as cells.
    #[must_use]
    pub fn tetrahedra(&self) -> &'a [[u16; 4]] {
        self.tetrahedra
    }

    /// Notes of the host from the bake, opaque to the kernel; empty if the host left none.
    #[must_use]
    pub fn notes(&self) -> &'a [u8] {
        self.notes
    }

    /// Input id of each cell but the spare ones, in the order of the cells; in a model with an embedded mesh, the
    /// node at which the cell lies.
    #[must_use]
    pub fn input_id(&self) -> &'a [u32] {
        self.input_id
    }

    /// Returns the cell of an input id; `None` for a node that is no cell. Cost: up to one read of each cell.
    /// In a model with an embedded mesh the result is the cell whose group holds the node, at the cost of one
    /// read; several ids may have the same cell.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// // The plane's 9 x 9 nodes, row by row: node 40 is the one in the middle.
    /// let cell = model.cell_of_input(40);
    /// assert_eq!(cell, Some(47)); // the image has its own order of cells
    /// assert_eq!(model.cell_of_input(81), None); // there is no such node
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[must_use]
    pub fn cell_of_input(&self, id: u32) -> Option<u16> {
        if let Some(mesh) = self.embedded {
            return mesh.own_cell(id as usize);
        }
        let cell = self.input_id.iter().position(|&other| other == id)?;
        u16::try_from(cell).ok()
    }

    /// Number of nodes of the input's numbering.
    #[must_use]
    pub fn input_nodes(&self) -> u32 {
        self.input_nodes
    }

    /// Number of slices of eight consecutive cells.
    #[inline(always)]
    pub(crate) fn slice_count(&self) -> usize {
        self.cells().div_ceil(LANES)
    }

    /// Number of hat functions of the coarse level, 0 without one.
    #[must_use]
    pub fn coarse_functions(&self) -> usize {
        self.coarse_basis.map_or(0, |basis| basis.count)
    }

    /// Returns true if the body is made of nodal shapes: its links carry no force.
    #[must_use]
    #[inline(always)]
    pub fn is_nodal(&self) -> bool {
        self.others.replaces_links()
    }

    /// Returns true if the motion of a cell affects cells beyond those that are linked to it.
    #[inline(always)]
    pub(crate) fn reaches_beyond_links(&self) -> bool {
        self.is_nodal() || self.others.joins_unlinked()
    }

    /// The parts in which threads share the body.
    #[must_use]
    #[inline(always)]
    pub fn thread_parts(&self) -> Parts {
        if self.is_nodal() { Parts::of_shapes(self.cells()) } else { Parts::of_links(self.cells()) }
    }

    /// The unit of the terms' moduli and stresses \[Pa\].
    pub(crate) fn stress_unit_pa(&self) -> f32 {
        2.0 * self.stiffness_n_per_m / self.unit_m
    }

    /// Young's modulus \[Pa\] and Poisson's ratio of the tissue around a cell; `None` for a spare cell and in
    /// a body of links.
    #[must_use]
    pub fn elasticity(&self, cell: usize) -> Option<[f32; 2]> {
        if cell >= self.body_cells() {
            return None;
        }
        self.others.elasticity(cell, self.stress_unit_pa())
    }

    /// Returns the stretch below which shapes resist more, 0 for none; `None` in a body of links.
    #[must_use]
    pub fn stretch_min(&self) -> Option<f32> {
        self.others.stretch_min()
    }

    /// Returns true if the body's stress relaxes. See [`Branch`].
    #[must_use]
    #[inline]
    pub fn relaxes(&self) -> bool {
        !self.others.branches().is_empty()
    }

    /// Returns true for a body that only [`Track`](crate::Track) and [`Predict`](crate::Predict) in single precision
    /// support: one of shapes, one that can be cut, and one whose stress relaxes.
    #[must_use]
    pub fn moves_singly(&self) -> bool {
        self.is_nodal() || self.cuttable().is_any() || self.relaxes()
    }

    /// Returns true if the body's links relax: their bands do not close.
    pub(crate) fn keeps_bands(&self) -> bool {
        self.relaxes() && !self.is_nodal()
    }

    /// The branches of relaxation in ascending time; none in an elastic body. See [`Branch`].
    pub fn branches(&self) -> impl Iterator<Item = Branch> + use<'a> {
        self.others.branches().iter().map(Branch::of)
    }

    /// Calls `visit(half_width, modulus_pa)` for each set of stiffening bands, the narrowest first: half its
    /// width in rest lengths, and Young's modulus of only this set \[Pa\]. A half-width below 0 stands for a set that
    /// resists links shorter than its band alone, a modulus below 0 for one that resists longer ones alone.
    pub fn each_stiffening(&self, mut visit: impl FnMut(f32, f32)) {
        self.others.stiffening(self.stress_unit_pa(), &mut visit);
    }

    /// Calls `visit(other, element)` for each contribution to the row of the curvature bound L at a cell of a
    /// body of nodal shapes; an element may get several contributions, which add up. A cell's bound is at
    /// least the sum of the magnitudes of its row. There are no calls in a body of links.
    pub fn each_of_bound_row(&self, cell: usize, mut visit: impl FnMut(usize, f32)) {
        self.others.each_of_row(cell, &mut visit);
    }

    /// Number of cells for which the energy terms keep states: 0 in a body of links.
    #[must_use]
    pub fn kept_states(&self) -> usize {
        if self.others.keeps() { self.cells() } else { 0 }
    }

    /// Returns true if the links are also stored in slices for vector units.
    #[must_use]
    pub fn is_sliced(&self) -> bool {
        self.slices.is_some()
    }

    /// Returns true if alpha is stored for each link.
    #[must_use]
    pub fn alpha_varies(&self) -> bool {
        self.link_alphas.is_some()
    }

    /// Returns true if the stiffness is stored for each link.
    #[must_use]
    pub fn weight_varies(&self) -> bool {
        self.link_weights.is_some()
    }

    /// Upper ends of all links, row by row.
    #[must_use]
    pub fn upper(&self) -> &'a [u16] {
        self.upper
    }

    /// Rest lengths of all links [mean link lengths].
    #[must_use]
    pub fn rest_lengths(&self) -> &'a [f32] {
        self.rest_length
    }

    /// Rest position of a cell [mean link lengths from the centre]; zero beyond the last.
    #[must_use]
    #[inline]
    pub fn rest_position(&self, cell: usize) -> [f32; 3] {
        self.rest.get(cell).copied().unwrap_or([0.0; 3])
    }

    /// The links of `cell` as their lower end, as indices into [`Self::upper`]; empty beyond the last
    /// cell.
    #[must_use]
    #[inline]
    pub fn row(&self, cell: usize) -> Range<usize> {
        range(self.rows, cell)
    }

    /// The half-links of `cell` as their upper end.
    #[inline]
    pub(crate) fn back_row(&self, cell: usize) -> Range<usize> {
        range(self.back_rows, cell)
    }

    /// Alpha of a link, the half-width of its band in rest lengths.
    #[must_use]
    #[inline]
    pub fn link_alpha(&self, link: usize) -> f32 {
        self.link_alphas.and_then(|alphas| alphas.get(link).copied()).unwrap_or(self.alpha)
    }

    /// Weight k / `k_ref` of a link; 0 in a body of nodal shapes.
    #[must_use]
    #[inline]
    pub fn link_weight(&self, link: usize) -> f32 {
        let even = if self.is_nodal() { 0.0 } else { 1.0 };
        self.link_weights.and_then(|weights| weights.get(link).copied()).unwrap_or(even)
    }

    /// Returns the links of a cell as pairs of link and other end, in ascending order of the other
    /// end. Cost: one step a link.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// let others: Vec<usize> = model.neighbours(47).map(|(_link, cell)| cell).collect();
    /// assert_eq!(others, [44, 45, 46, 54, 56, 64, 65, 72]); // eight: the plane has diagonals
    /// assert_eq!(model.cell_weight(47), 8.0); // each has the stiffness k_ref
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> + use<'a> {
        let (lower, back_link, upper) = (self.lower, self.back_link, self.upper);
        let below = self.back_row(cell).filter_map(move |half| {
            Some((*back_link.get(half)? as usize, usize::from(*lower.get(half)?)))
        });
        let above =
            self.row(cell).filter_map(move |link| Some((link, usize::from(*upper.get(link)?))));
        below.chain(above)
    }

    /// Returns W, the sum of the weights of a cell's links, in ascending order of their other ends.
    #[must_use]
    pub fn cell_weight(&self, cell: usize) -> f32 {
        self.neighbours(cell).fold(0.0, |sum, (link, _)| sum + self.link_weight(link))
    }

    /// The part that terms are checked against.
    pub(crate) fn layout(&self) -> Layout<'a> {
        Layout {
            rest: self.rest,
            #[cfg(test)]
            mobility: self.mobility,
            has_weights: self.link_weights.is_some(),
            has_slack: self.has_slack(),
            saturation: self.saturation,
            degree_bound: self.degree_bound,
        }
    }

    /// Returns the curvature bound of a cell, the inverse of its mobility and twice the diagonal of L: W, the
    /// sum of its links' weights, plus the parts of the other terms.
    #[must_use]
    #[inline]
    pub fn cell_bound(&self, cell: usize) -> f32 {
        self.others.add_bound(cell, self.cell_weight(cell))
    }

    /// Number of nodes of the embedded mesh, by input id; 0 for a model in which every node is a cell. A node
    /// may be left out: it has no position.
    #[must_use]
    pub fn fine_nodes(&self) -> usize {
        self.embedded.map_or(0, |mesh| mesh.rest.len())
    }

    /// Rest position of a node of the embedded mesh [mean link lengths from the centre].
    #[must_use]
    pub fn fine_rest(&self, node: usize) -> Option<[f32; 3]> {
        let mesh = self.embedded?;
        mesh.own_cell(node)?;
        mesh.rest.get(node).copied()
    }

    /// Cells of a node of the embedded mesh, with their weights; its own cell first. Empty for a
    /// node that is left out.
    pub fn fine_weights(&self, node: usize) -> impl Iterator<Item = (u16, f32)> + use<'a> {
        let of = self.embedded.and_then(|mesh| {
            mesh.own_cell(node)?;
            Some((mesh.cells.get(node)?, mesh.weights.get(node)?))
        });
        of.into_iter()
            .flat_map(|(cells, weights)| cells.iter().copied().zip(weights.iter().copied()))
    }

    /// Surface triangles of the embedded mesh, outward, for display.
    #[must_use]
    pub fn fine_triangles(&self) -> &'a [[u32; 3]] {
        self.embedded.map_or(&[], |mesh| mesh.triangles)
    }

    /// Tetrahedra of the embedded mesh, for display.
    #[must_use]
    pub fn fine_tetrahedra(&self) -> &'a [[u32; 4]] {
        self.embedded.map_or(&[], |mesh| mesh.tetrahedra)
    }

    /// Returns the position of a node of the embedded mesh for cells at `position_of`
    /// [mean link lengths from the centre]; `None` beyond the last node, for a node that is left out, and in
    /// a model without an embedded mesh. Cost: at most [`FINE_CELLS`](super::image::FINE_CELLS) positions.
    #[must_use]
    pub fn fine_position(
        &self,
        node: usize,
        position_of: impl Fn(usize) -> Option<[f32; 3]>,
    ) -> Option<[f32; 3]> {
        let mut place = self.fine_rest(node)?;
        for (cell, weight) in self.fine_weights(node).filter(|&(_, weight)| weight != 0.0) {
            let cell = usize::from(cell);
            let (now, rest) = (position_of(cell)?, self.rest_position(cell));
            for ((x, now), rest) in place.iter_mut().zip(now).zip(rest) {
                *x += weight * (now - rest);
            }
        }
        Some(place)
    }

    /// Returns the triangles that tools touch; `None` if the model has no contact surface.
    pub(crate) fn contact_surface(&self) -> Option<ContactSurface<'a>> {
        Some(ContactSurface::of(self.triangles, self.contact?).with(self.opened))
    }

    /// Returns true if tools may touch the model.
    #[must_use]
    pub fn has_contact_surface(&self) -> bool {
        self.contact.is_some()
    }

    /// Calls `visit(parts, stiffness_n_per_m)` for each triangle of the contact surface, in the order of the
    /// image: the number of subdivisions of an edge under a part of this radius \[m\], and the total
    /// stiffness of its samples [N/m]. There are no calls without a contact surface.
    pub fn each_contact_triangle(&self, radius_m: f32, mut visit: impl FnMut(u16, f32)) {
        let radius = radius_m / self.unit_m;
        let Some(surface) = self.contact_surface() else { return };
        for (_, of) in (0..surface.triangles.len()).filter_map(|index| surface.triangle(index)) {
            visit(of.parts(radius), 2.0 * self.stiffness_n_per_m * of.weight(radius));
        }
    }

    /// Smallest radius of a tool's part, at which the samples are just dense enough [mean link lengths]; `None`
    /// without a contact surface.
    #[must_use]
    pub fn tool_radius_min(&self) -> Option<f32> {
        Some(self.contact_surface()?.radius_min())
    }
}
