//! The network to bake: the mesh itself, or one whose nodes are groups of the mesh's nodes.

use super::groups::{CoarseLinks, Embedding, Groups, couple, embed, partition, stiffening};
use super::layout::{Link, OrderedCells};
use super::options::BakeOptions;
use super::per_cell::PerCell;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// A number of every link.
pub struct OfLinks {
    /// In the model's order.
    pub each: Vec<f64>,
    /// True if they are stored one by one.
    pub varies: bool,
}

/// The mesh with the network over it.
pub struct Plan<'a> {
    mesh: &'a Mesh,
    fixed: &'a [u32],
    options: &'a BakeOptions,
    coarse: Option<Coarse>,
}

/// A network of groups.
pub struct Coarse {
    pub groups: Groups,
    /// Nodes are groups.
    pub net: Mesh,
    /// Weights of the groups at each node.
    pub embedding: Embedding,
    fixed: Vec<u32>,
    links: CoarseLinks,
}

impl<'a> Plan<'a> {
    /// Groups the nodes if the options ask for it.
    ///
    /// # Errors
    /// A number of cells out of range.
    pub fn new(mesh: &'a Mesh, fixed: &'a [u32], options: &'a BakeOptions) -> Result<Self> {
        let used = mesh.nodes_m.len() - mesh.unused.len();
        let coarse = match options.cells {
            Some(cells) if cells != used => Some(Coarse::new(mesh, fixed, options, cells)?),
            _ => None,
        };
        Ok(Self { mesh, fixed, options, coarse })
    }

    /// Returns the mesh as it was given.
    pub fn mesh(&self) -> &Mesh {
        self.mesh
    }

    /// Returns the mesh whose nodes are the cells.
    pub fn net(&self) -> &Mesh {
        self.coarse.as_ref().map_or(self.mesh, |coarse| &coarse.net)
    }

    /// Returns its fixed nodes.
    pub fn fixed(&self) -> &[u32] {
        self.coarse.as_ref().map_or(self.fixed, |coarse| &coarse.fixed)
    }

    /// Returns true if cells are groups.
    pub fn is_grouped(&self) -> bool {
        self.coarse.is_some()
    }

    /// Returns the groups, if cells are groups.
    pub fn coarse(&self) -> Option<&Coarse> {
        self.coarse.as_ref()
    }

    /// Returns the node of [`Self::net`] that a used node of the mesh belongs to.
    pub fn net_node(&self, node: u32) -> u32 {
        self.coarse.as_ref().map_or(node, |coarse| coarse.groups.of[node as usize])
    }

    /// Returns the input id of every cell.
    pub fn input_ids(&self, body: &OrderedCells) -> Vec<u32> {
        match &self.coarse {
            None => body.node.clone(),
            Some(coarse) => {
                body.node.iter().map(|&group| coarse.groups.node[group as usize]).collect()
            }
        }
    }

    /// Returns the half-width of the band of every link.
    pub fn alpha(&self, links: &[Link]) -> OfLinks {
        let coarse = self.coarse.as_ref().map(|coarse| &coarse.links.alpha);
        let varies = matches!(self.options.alpha, PerCell::Each(_));
        self.of_links(links, &self.options.alpha, coarse.filter(|_| varies), varies)
    }

    /// Returns the stiffness of every link \[N/m\]; in a body of tissue it does not vary.
    pub fn stiffness(&self, links: &[Link]) -> OfLinks {
        let coarse = self.coarse.as_ref().map(|coarse| &coarse.links.stiffness_n_per_m);
        let given = &self.options.stiffness_n_per_m;
        let is_of_links = self.options.tissue.is_none();
        let varies = is_of_links && (coarse.is_some() || matches!(given, PerCell::Each(_)));
        let mut stiffness = self.of_links(links, given, coarse, varies);
        // That of links which relax is the instantaneous one.
        if let Some(relaxation) = &self.options.link_relaxation {
            let rise = relaxation.instant_rise();
            stiffness.each.iter_mut().for_each(|stiffness| *stiffness *= rise);
        }
        stiffness
    }

    fn of_links(
        &self,
        links: &[Link],
        fine: &PerCell,
        coarse: Option<&Vec<f64>>,
        varies: bool,
    ) -> OfLinks {
        let of_link = |at: usize| match coarse {
            Some(values) => values[at],
            None => fine.of_link(self.net().links[at]),
        };
        OfLinks { each: links.iter().map(|&(_, at)| of_link(at)).collect(), varies }
    }
}

impl Coarse {
    fn new(mesh: &Mesh, fixed: &[u32], options: &BakeOptions, cells: usize) -> Result<Self> {
        let groups = partition(mesh, fixed, cells)?;
        let each = |value: &PerCell| -> Vec<f64> {
            mesh.links.iter().map(|&link| value.of_link(link)).collect()
        };
        let stiffness = each(&options.stiffness_n_per_m);
        let mut links = couple(mesh, &groups, &stiffness, &each(&options.alpha));
        if links.links.is_empty() {
            return Err(Error::input(format!(
                "`cells` {cells}: each part of the body would be one cell; take more cells"
            )));
        }
        let mut embedding = embed(mesh, &groups, &links.links);
        let cells_m: Vec<[f64; 3]> =
            groups.node.iter().map(|&node| mesh.nodes_m[node as usize]).collect();
        let k = &mut links.stiffness_n_per_m;
        let factor = stiffening(mesh, &stiffness, &cells_m, &links.links, k, &embedding);
        k.iter_mut().for_each(|k| *k *= factor);
        log::info!("links of groups stiffened by {factor}, {} nodes rough", embedding.rough);
        embedding.pin(&groups);
        let net = Mesh { nodes_m: cells_m, links: links.links.clone(), ..Mesh::default() };
        let fixed = (0_u32..).zip(&groups.fixed).filter(|entry| *entry.1).map(|entry| entry.0);
        Ok(Self { fixed: fixed.collect(), groups, net, embedding, links })
    }
}
