//! The content that all formats collect from a file.

use std::collections::{BTreeMap, HashMap};

use super::file::File;
use crate::error::{Error, Result};
use crate::mesh::RawMesh;
use crate::mesh::bytes::shown;
use crate::mesh::groups::Groups;

/// Nodes, tetrahedra and groups read so far.
pub(super) struct Content {
    unit_m: f64,
    nodes_m: Vec<[f64; 3]>,
    /// Position of each node tag.
    places: HashMap<u64, u32>,
    tetrahedra: Vec<[u32; 4]>,
    /// Elements that are no tetrahedra.
    others: usize,
    /// Name of each group, by dimension and number.
    names: BTreeMap<(u64, i64), String>,
    /// Nodes of each dimension and number: physical groups in 2.2, entities in 4.1.
    members: BTreeMap<(u64, i64), Vec<u32>>,
    /// Physical groups of each dimension and entity; none in 2.2, where members name their group.
    pub(super) physicals: Option<BTreeMap<(u64, i64), Vec<i64>>>,
}

impl Content {
    pub(super) fn new(unit_m: f64) -> Self {
        Self {
            unit_m,
            nodes_m: Vec::new(),
            places: HashMap::new(),
            tetrahedra: Vec::new(),
            others: 0,
            names: BTreeMap::new(),
            members: BTreeMap::new(),
            physicals: None,
        }
    }

    /// `$PhysicalNames`, the same in both formats: text in binary files too. After the name's second quotation
    /// mark the line is a remark.
    pub(super) fn names(&mut self, file: &mut File) -> Result<()> {
        for _ in 0..file.count("the number of names")? {
            let line = file.name_line("a name")?;
            let mut words = line.split_ascii_whitespace();
            let dimension = file.bytes.whole_of(words.next().unwrap_or(""), "the dimension")?;
            let number = file.bytes.signed_of(words.next().unwrap_or(""), "the group number")?;
            let text = words.collect::<Vec<_>>().join(" ");
            let name = text.strip_prefix('"').and_then(|text| text.split_once('"'));
            let Some((name, _)) = name else {
                return Err(file.refuse(&format!(
                    "the group name is '{}'; put it between double quotes",
                    shown(&text)
                )));
            };
            self.names.insert((dimension, number), name.to_string());
        }
        Ok(())
    }

    /// Refuses nodes or elements out of order, which no save produces.
    pub(super) fn begin_nodes(&self, at: &File) -> Result<()> {
        if self.nodes_m.is_empty() {
            return Ok(());
        }
        Err(at.refuse("a second $Nodes section; save the mesh as one file"))
    }

    /// See [`Content::begin_nodes`].
    pub(super) fn begin_elements(&self, at: &File) -> Result<()> {
        if self.nodes_m.is_empty() {
            return Err(at.refuse(
                "there is no node before $Elements; mesh the geometry (gmsh -3) and save it",
            ));
        }
        if self.others + self.tetrahedra.len() > 0 {
            return Err(at.refuse("a second $Elements section; save the mesh as one file"));
        }
        Ok(())
    }

    /// Accepts the sections after a second `$MeshFormat`, at `at`, if they are an appended view, which the
    /// body does not need.
    pub(super) fn view(&self, at: &File) -> Result<()> {
        let holds =
            |section: &[u8]| at.bytes.rest().windows(section.len()).any(|part| part == section);
        let meshes: [&[u8]; 3] = [b"$Nodes", b"$ParametricNodes", b"$Elements"];
        if !self.nodes_m.is_empty() && !meshes.into_iter().any(holds) {
            return Ok(());
        }
        Err(at.refuse(
            "a second $MeshFormat with a mesh of its own; join them (gmsh -save -format msh41 -o OUT.msh \
             IN.msh) or keep one",
        ))
    }

    /// Assigns the next position to a node's tag, which is at `at` in the file.
    pub(super) fn tag(&mut self, tag: u64, at: &File) -> Result<()> {
        let place = u32::try_from(self.places.len())
            .map_err(|_| at.refuse("more than 4294967295 nodes, the limit; mesh it coarser"))?;
        match self.places.insert(tag, place) {
            None => Ok(()),
            Some(_) => Err(at.refuse(&format!(
                "node tag {tag} is given twice; give each node a tag of its \
                 own and save the mesh again"
            ))),
        }
    }

    /// Takes the coordinates of the next position.
    pub(super) fn position(&mut self, from: &mut File) -> Result<()> {
        self.nodes_m.push(from.position_m(self.unit_m)?);
        Ok(())
    }

    /// Reads the node tag of an element: 64 bits in binary files of format 4.1, which alone have entities.
    fn node_tag(&self, from: &mut File) -> Result<u64> {
        let is_long = self.physicals.is_some();
        if is_long { from.long("a node tag") } else { from.whole("a node tag") }
    }

    /// Takes the nodes of an element, the next `N` node tags.
    pub(super) fn corners<const N: usize>(
        &self,
        element: u64,
        from: &mut File,
    ) -> Result<[u32; N]> {
        let mut ids = [0; N];
        for id in &mut ids {
            let tag = self.node_tag(from)?;
            *id = *self.places.get(&tag).ok_or_else(|| {
                from.refuse(&format!(
                    "element {element} refers to node tag {tag}, which $Nodes does not have; save \
                     the mesh again"
                ))
            })?;
        }
        Ok(ids)
    }

    /// Adds a tetrahedron.
    pub(super) fn tetrahedron(&mut self, element: u64, ids: [u32; 4], at: &File) -> Result<()> {
        if (1..4).any(|corner| ids[..corner].contains(&ids[corner])) {
            return Err(at.refuse(&format!(
                "element {element} is a tetrahedron that has a node twice; delete it or mesh again"
            )));
        }
        self.tetrahedra.push(ids);
        Ok(())
    }

    /// Counts an element that is no tetrahedron.
    pub(super) fn other(&mut self) {
        self.others += 1;
    }

    /// Notes nodes as members of a group (2.2) or an entity (4.1).
    pub(super) fn member(&mut self, dimension: u64, number: i64, ids: &[u32]) {
        self.members.entry((dimension, number)).or_default().extend(ids);
    }

    /// Returns the body, or the reason for none; `refuse` makes an error of the file as a whole.
    pub(super) fn finish(self, refuse: impl FnOnce(&str) -> Error) -> Result<RawMesh> {
        let why = match (self.nodes_m.len(), self.tetrahedra.len(), self.others) {
            (0, _, _) => "it has no nodes; mesh the geometry (gmsh -3) and save it".to_string(),
            (_, 0, 0) => "it has no elements; mesh the volume (gmsh -3) and save all elements \
                          (Mesh.SaveAll = 1)"
                .to_string(),
            (_, 0, others) => format!(
                "it has {others} elements but no tetrahedra; a volume mesh is needed: mesh the \
                 volume inside (gmsh -3) and save all elements (Mesh.SaveAll = 1)"
            ),
            _ => return Ok(self.body()),
        };
        Err(refuse(&why))
    }

    fn body(mut self) -> RawMesh {
        let mut groups = Groups::default();
        for ((dimension, number), ids) in self.members {
            let own = [number];
            let physicals = match &self.physicals {
                None => own.as_slice(),
                Some(of) => of.get(&(dimension, number)).map_or(&[][..], Vec::as_slice),
            };
            for physical in physicals.iter().filter(|physical| **physical != 0) {
                // The sign is only the orientation.
                let key = (dimension, physical.saturating_abs());
                let name = self.names.entry(key).or_insert_with(|| key.1.to_string());
                groups.add(&name, ids.iter().copied());
            }
        }
        RawMesh { nodes_m: self.nodes_m, tetrahedra: self.tetrahedra, groups: groups.finish() }
    }
}
