//! The frame of a running scene, as it is sent to a page.
//!
//! Little-endian, one part after the other:
//!
//! | part | each |
//! |---|---|
//! | head, 68 bytes | version u32 = 4, model checksum u32, tick u64, ticks answered u64, state hash u64, flags u32, sweeps u32, step u32 \[ns\], energy f32 \[J\], numbers of tools, points, cells, contacts and stresses u32 |
//! | tools, 72 bytes each | number u32, engaged u16, opening of scissors u16 \[2^-16 turn\], position 3 f32 \[m\], orientation x, y, z, w f32, force 3 f32 \[N\], torque 3 f32 \[N m\], contacts u32, flags u32, error of the force f32 \[N\] |
//! | points, 36 bytes each | tick u64, force 3 f32 \[N\], its error f32 \[N\] and position 3 f32 \[m\] of tool 0, oldest first |
//! | contacts, 20 bytes each | cell u32, position 3 f32 \[m\], pressure f32 \[Pa\]: one for each triangle and part of a tool, at the cell of the corner with the largest share |
//! | stresses, 4 bytes each | stress after von Mises f32 \[Pa\] of each cell, or none |
//! | cells, 12 bytes each | position 3 f32 \[m\], in the order of the model image; copies of split cells after them |
//! | triangles, 24 bytes each, up to the end | cells 3 u32, and 3 u32 the cells of the whole body that these are or were made from: of a body with copies the surface as it is cut, else none |
//!
//! An error that is not known is below 0. Points are the last ticks, up to 64: a page that skips frames has the
//! curves without gaps.
//!
//! Positions are of the head's tick, tools too while states come. Contacts are the newest ones: the server sends
//! them apart from the positions, so they are of the same tick or at most two periods of its `--state-hz` from it.
//! Stresses are there while a page asks for them, of the newest pass of the server over the body.

use chaincell_kernel::{Model, ToolPose};

use crate::error::{Error, Result};
use crate::session::ipc::contacts::Contact;
use crate::session::ipc::payload::{NodePosition, StateHeader};
use crate::session::ipc::stress::NodeStress;
use crate::session::ipc::tools::{OneToolForce, OneToolPose, ToolForces, ToolPoses, UNKNOWN_N};
use crate::session::ipc::watching::WatchPorts;

/// Version of the layout.
const VERSION: u32 = 4;

/// The body and the tools that a page shows.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Checksum of its model image.
    pub checksum: u32,
    /// Row of each cell in a state.
    rows: Vec<u32>,
    /// Input id and cell of each row.
    ids: Vec<(u32, u32)>,
    tools: usize,
    /// True for a body whose server sends its surface.
    can_be_cut: bool,
}

/// The body as its server has sent it.
#[derive(Debug, Clone, Default)]
pub struct Body {
    /// Header of the state.
    pub header: StateHeader,
    /// Its nodes.
    pub nodes: Vec<NodePosition>,
    /// Copies of those that a cut has split.
    pub copies: Vec<NodePosition>,
    /// Corners of the surface's triangles, by their rows in `nodes` and the `copies` after them; none of a body that
    /// cannot be cut.
    pub triangles: Vec<[u32; 3]>,
}

/// All that the server has sent of a body.
#[derive(Debug, Clone, Copy)]
pub struct Sent<'a> {
    /// The body.
    pub body: &'a Body,
    /// The newest contacts.
    pub contacts: &'a [Contact],
    /// The newest stresses; none of another number than the nodes are shown.
    pub stresses: &'a [NodeStress],
}

impl Subject {
    /// The body of a model under so many tools, 0 where the tool holds cells.
    ///
    /// # Errors
    /// A model whose states do not have its cells.
    pub fn new(model: &Model<'_>, tools: usize) -> Result<Self> {
        if model.fine_nodes() > 0 {
            return Err(Error::input(
                "this model was baked with --cells: its states are those of the input's nodes, which a page \
                 does not show; serve and view a model without --cells",
            ));
        }
        let mut ids: Vec<(u32, u32)> = model.input_id().iter().copied().zip(0..).collect();
        ids.sort_unstable();
        let mut rows = vec![0; ids.len()];
        for (row, (_, cell)) in (0..).zip(&ids) {
            rows[*cell as usize] = row;
        }
        let can_be_cut = model.tetrahedra_to_cut() > 0;
        Ok(Self { checksum: model.checksum(), rows, ids, tools: tools.max(1), can_be_cut })
    }

    /// Returns true if the server of this body sends its surface.
    #[must_use]
    pub fn can_be_cut(&self) -> bool {
        self.can_be_cut
    }

    /// Returns true if a body is this one.
    #[must_use]
    pub fn is_of(&self, body: &Body) -> bool {
        body.header.model_checksum == self.checksum && body.nodes.len() == self.rows.len()
    }

    /// The frame of a state of this body, with the tools of a tick and the curves of the last ones.
    #[must_use]
    pub fn frame(&self, sent: Sent<'_>, tick: u64, ports: &WatchPorts) -> Vec<u8> {
        let (poses, answer) = (find_pose(ports, tick), find_answer(ports, tick));
        let points: Vec<Point> = ports
            .answers()
            .iter()
            .filter_map(|of| Point::new(of, find_pose(ports, of.tick)))
            .collect();
        self.encode(sent, &poses.unwrap_or_default(), &answer.unwrap_or_default(), &points)
    }

    fn encode(
        &self,
        Sent { body, contacts, stresses }: Sent<'_>,
        poses: &ToolPoses,
        answer: &ToolForces,
        points: &[Point],
    ) -> Vec<u8> {
        let Body { header, nodes, copies, triangles } = body;
        let presses: Vec<Press> = contacts.iter().filter_map(|of| self.press(of)).collect();
        let stresses = if stresses.len() == self.rows.len() { stresses } else { &[] };
        // A body without copies has the triangles of its model.
        let triangles = if copies.is_empty() { &[] } else { &triangles[..] };
        let rows = 72 * self.tools + 36 * points.len() + 20 * presses.len() + 16 * nodes.len();
        let rows_of_cuts = 12 * copies.len() + 24 * triangles.len();
        let mut frame = Frame(Vec::with_capacity(68 + rows + rows_of_cuts));
        // The head.
        frame.whole(VERSION).whole(header.model_checksum);
        frame.long(header.tick).long(header.ticks_answered).long(header.state_hash);
        frame.whole(header.flags).whole(answer.sweeps).whole(answer.step_ns).real(answer.energy_j);
        frame.count(self.tools).count(points.len()).count(self.rows.len() + copies.len());
        frame.count(presses.len()).count(stresses.len());
        // The tools: one that no message has is away.
        for number in 0..self.tools {
            let in_use = poses.each.iter().take(poses.tools as usize);
            let away = ToolPose::AWAY;
            let pose = in_use.copied().find(|of| of.number as usize == number);
            let pose =
                pose.unwrap_or(OneToolPose { orientation: away.orientation, ..Default::default() });
            let force = answer.each_tool().find(|(of, _)| *of == number);
            let none = OneToolForce { force_error_n: UNKNOWN_N, ..OneToolForce::default() };
            let force = force.map_or(none, |(_, force)| *force);
            let opening = u32::from(pose.opening_turns_q16) << 16;
            frame.count(number).whole(u32::from(pose.engaged) | opening);
            frame.reals(&pose.position_m).reals(&pose.orientation);
            frame.reals(&force.force_n).reals(&force.torque_n_m);
            frame.whole(force.contacts).whole(force.flags).real(force.force_error_n);
        }
        // The points, the contacts, the stresses, the cells and the triangles.
        for Point { tick, force_n, force_error_n, position_m } in points {
            frame.long(*tick).reals(force_n).real(*force_error_n).reals(position_m);
        }
        for Press { cell, position_m, pressure_pa } in &presses {
            frame.whole(*cell).reals(position_m).real(*pressure_pa);
        }
        for &row in self.rows.iter().take(stresses.len()) {
            frame.real(stresses.get(row as usize).map_or(0.0, |of| of.von_mises_pa));
        }
        for &row in &self.rows {
            frame.reals(&nodes.get(row as usize).copied().unwrap_or_default().position_m);
        }
        copies.iter().for_each(|copy| _ = frame.reals(&copy.position_m));
        for corners in triangles {
            let [a, b, c] = corners.map(|row| self.cell(copies, row));
            [a, b, c].iter().for_each(|(cell, _)| _ = frame.whole(*cell));
            [a, b, c].iter().for_each(|(_, origin)| _ = frame.whole(*origin));
        }
        frame.0
    }

    /// The cell at a row of nodes and copies, and the one of the whole body that it is or was made from. Copies have
    /// the numbers of their rows.
    fn cell(&self, copies: &[NodePosition], row: u32) -> (u32, u32) {
        if let Some(&(_, cell)) = self.ids.get(row as usize) {
            return (cell, cell);
        }
        let copy = (row as usize).checked_sub(self.ids.len()).and_then(|copy| copies.get(copy));
        let origin = copy.and_then(|copy| self.cell_of(copy.node));
        // A row that is none is at the first cell.
        origin.map_or((0, 0), |origin| (row, origin))
    }

    /// The cell of a node.
    fn cell_of(&self, node: u32) -> Option<u32> {
        let row = self.ids.binary_search_by_key(&node, |(id, _)| *id).ok()?;
        self.ids.get(row).map(|(_, cell)| *cell)
    }

    /// A contact at a cell of this body; `None` at another node, and without an area.
    fn press(&self, contact: &Contact) -> Option<Press> {
        let cell = self.cell_of(contact.node)?;
        let normal_n = contact.normal_n.map(|part| part * part).iter().sum::<f32>().sqrt();
        let pressure_pa = normal_n / contact.area_m2;
        let press = Press { cell, position_m: contact.position_m, pressure_pa };
        pressure_pa.is_finite().then_some(press)
    }
}

/// A contact as a page shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Press {
    cell: u32,
    position_m: [f32; 3],
    pressure_pa: f32,
}

/// A point of the curves: tool 0 in a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    tick: u64,
    force_n: [f32; 3],
    force_error_n: f32,
    position_m: [f32; 3],
}

impl Point {
    /// Of an answer and the poses that it answers; `None` where one of them does not have tool 0.
    fn new(answer: &ToolForces, poses: Option<ToolPoses>) -> Option<Self> {
        let (_, force) = answer.each_tool().find(|(number, _)| *number == 0)?;
        let poses = poses?;
        let pose = poses.each.iter().take(poses.tools as usize).find(|of| of.number == 0)?;
        let OneToolForce { force_n, force_error_n, .. } = *force;
        Some(Self { tick: answer.tick, force_n, force_error_n, position_m: pose.position_m })
    }
}

/// The poses of a tick.
fn find_pose(ports: &WatchPorts, tick: u64) -> Option<ToolPoses> {
    ports.poses().iter().rev().find(|of| of.tick == tick).copied()
}

/// The answer to a tick: the last one, since the force of a silence falls in several.
fn find_answer(ports: &WatchPorts, tick: u64) -> Option<ToolForces> {
    ports.answers().iter().rev().find(|of| of.tick == tick).copied()
}

/// Bytes in the order of the layout.
struct Frame(Vec<u8>);

impl Frame {
    fn whole(&mut self, number: u32) -> &mut Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn long(&mut self, number: u64) -> &mut Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn real(&mut self, number: f32) -> &mut Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn reals(&mut self, numbers: &[f32]) -> &mut Self {
        numbers.iter().for_each(|&number| _ = self.real(number));
        self
    }

    fn count(&mut self, number: usize) -> &mut Self {
        self.whole(u32::try_from(number).unwrap_or(u32::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads a frame by its layout.
    struct Words<'a>(&'a [u8]);

    impl Words<'_> {
        fn take<const N: usize>(&mut self) -> [u8; N] {
            let (word, rest) = self.0.split_first_chunk().unwrap();
            self.0 = rest;
            *word
        }

        fn whole(&mut self) -> u32 {
            u32::from_le_bytes(self.take())
        }

        fn long(&mut self) -> u64 {
            u64::from_le_bytes(self.take())
        }

        fn reals<const N: usize>(&mut self) -> [f32; N] {
            std::array::from_fn(|_| f32::from_le_bytes(self.take()))
        }
    }

    fn subject() -> Subject {
        let ids = vec![(10, 1), (20, 2), (30, 0)];
        Subject { checksum: 0xC4EC, rows: vec![2, 0, 1], ids, tools: 2, can_be_cut: true }
    }

    /// Three nodes, each at its number.
    fn body() -> Body {
        let nodes = [10, 20, 30].map(|node| NodePosition { node, position_m: [node as f32; 3] });
        Body { header: header(), nodes: nodes.to_vec(), ..Body::default() }
    }

    fn header() -> StateHeader {
        StateHeader {
            tick: 1 << 40,
            ticks_answered: 7,
            state_hash: 0xFEDC_BA98_7654_3210,
            nodes: 3,
            flags: 8,
            model_checksum: 0xC4EC,
            reserved: 0,
        }
    }

    #[test]
    fn a_frame_holds_the_state_in_the_order_of_the_cells() {
        let (subject, body) = (subject(), body());
        let mut poses = ToolPoses { tick: 1 << 40, tools: 1, ..ToolPoses::default() };
        poses.each[0] = OneToolPose {
            number: 1,
            engaged: 1,
            position_m: [1.0, 2.0, 3.0],
            orientation: [0.0, 0.6, 0.0, 0.8],
            ..OneToolPose::default()
        };
        let mut answer = ToolForces {
            sweeps: 4,
            step_ns: 260_000,
            energy_j: 0.5,
            tools: 2,
            ..ToolForces::default()
        };
        answer.each[0].number = 5;
        answer.each[1] = OneToolForce {
            number: 1,
            contacts: 6,
            force_n: [0.1, 0.2, 0.3],
            torque_n_m: [4.0, 5.0, 6.0],
            flags: 16,
            force_error_n: 0.03,
            ..OneToolForce::default()
        };
        let point = Point { tick: 9, force_n: [1.5; 3], force_error_n: 0.75, position_m: [2.5; 3] };
        let contact = Contact {
            node: 30,
            position_m: [7.0, 8.0, 9.0],
            normal_n: [0.3, 0.0, 0.4],
            tangential_n: [9.0; 3],
            area_m2: 0.25,
            ..Contact::default()
        };
        // One at another node and one without an area are left out.
        let contacts =
            [Contact { node: 31, ..contact }, contact, Contact { area_m2: 0.0, ..contact }];
        let stresses = [10, 20, 30].map(|node| NodeStress {
            node,
            von_mises_pa: 100.0 * node as f32,
            ..Default::default()
        });
        let sent = Sent { body: &body, contacts: &contacts, stresses: &stresses };
        let frame = subject.encode(sent, &poses, &answer, &[point]);
        assert_eq!(frame.len(), 68 + 2 * 72 + 36 + 20 + 3 * 16);
        let mut words = Words(&frame);
        assert_eq!([words.whole(), words.whole()], [VERSION, 0xC4EC]);
        assert_eq!([words.long(), words.long(), words.long()], [1 << 40, 7, 0xFEDC_BA98_7654_3210]);
        assert_eq!([words.whole(), words.whole(), words.whole()], [8, 4, 260_000]);
        assert_eq!(words.reals(), [0.5]);
        assert_eq!(std::array::from_fn(|_| words.whole()), [2, 1, 3, 1, 3]);
        // No message has tool 0.
        assert_eq!([words.whole(), words.whole()], [0, 0]);
        assert_eq!(words.reals(), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(words.reals(), [0.0; 6]);
        assert_eq!([words.whole(), words.whole()], [0, 0]);
        assert_eq!(words.reals(), [UNKNOWN_N]);
        assert_eq!([words.whole(), words.whole()], [1, 1]);
        assert_eq!(words.reals(), [1.0, 2.0, 3.0, 0.0, 0.6, 0.0, 0.8]);
        assert_eq!(words.reals(), [0.1, 0.2, 0.3, 4.0, 5.0, 6.0]);
        assert_eq!([words.whole(), words.whole()], [6, 16]);
        assert_eq!(words.reals(), [0.03]);
        assert_eq!(words.long(), 9);
        assert_eq!(words.reals(), [1.5, 1.5, 1.5, 0.75, 2.5, 2.5, 2.5]);
        assert_eq!(words.whole(), 0);
        assert_eq!(words.reals(), [7.0, 8.0, 9.0, 2.0]);
        assert_eq!(words.reals(), [3000.0, 1000.0, 2000.0]);
        assert_eq!(words.reals(), [30.0, 30.0, 30.0, 10.0, 10.0, 10.0, 20.0, 20.0, 20.0]);
        assert!(words.0.is_empty());
    }

    #[test]
    fn stresses_of_another_body_are_left_out() {
        let (subject, body) = (subject(), body());
        let stresses = [NodeStress::default(); 3];
        let bytes = |stresses| {
            let sent = Sent { body: &body, contacts: &[], stresses };
            subject.encode(sent, &ToolPoses::default(), &ToolForces::default(), &[]).len()
        };
        assert_eq!(bytes(&stresses), bytes(&stresses[..2]) + 12);
    }

    #[test]
    fn a_body_with_copies_has_its_triangles_behind_the_cells() {
        let (subject, whole) = (subject(), body());
        let copies = vec![NodePosition { node: 20, position_m: [0.5; 3] }];
        let triangles = vec![[0, 1, 2], [3, 2, 0], [0, 9, 1]];
        let frame = |body: &Body| {
            let sent = Sent { body, contacts: &[], stresses: &[] };
            subject.encode(sent, &ToolPoses::default(), &ToolForces::default(), &[])
        };
        let bytes = frame(&whole);
        let without_copies = Body { triangles: triangles.clone(), ..whole.clone() };
        assert_eq!(frame(&without_copies), bytes, "a whole body has the triangles of its model");
        let cut = frame(&Body { copies, triangles, ..whole });
        // The number of cells is one more; all up to the last cell is the same.
        let number = 68 - 12;
        assert_eq!([bytes[number], cut[number]], [3, 4]);
        assert_eq!(cut[number + 4..bytes.len()], bytes[number + 4..]);
        let mut words = Words(&cut[bytes.len()..]);
        assert_eq!(words.reals(), [0.5; 3]);
        // Nodes 10, 20, 30 are the cells 1, 2, 0; the copy of node 20 is cell 3; row 9 is none.
        let mut triangle = || -> [u32; 6] { std::array::from_fn(|_| words.whole()) };
        assert_eq!(triangle(), [1, 2, 0, 1, 2, 0]);
        assert_eq!(triangle(), [3, 0, 1, 2, 0, 1]);
        assert_eq!(triangle(), [1, 0, 2, 1, 0, 2]);
        assert!(words.0.is_empty());
    }

    #[test]
    fn a_state_of_another_model_or_length_is_none_of_the_body() {
        let (subject, body) = (subject(), body());
        let header = StateHeader { model_checksum: 1, ..body.header };
        let other = Body { header, ..body.clone() };
        assert!(subject.is_of(&body) && !subject.is_of(&other));
        let with = |nodes: &[NodePosition]| Body { nodes: nodes.to_vec(), ..body.clone() };
        assert!(!subject.is_of(&with(&body.nodes[..2])) && !subject.is_of(&with(&[])));
        let longer = [&body.nodes[..], &body.nodes[..1]].concat();
        assert!(!subject.is_of(&with(&longer)));
    }

    /// Rows of states are in the order of the ids, those of a frame in the order of the cells.
    #[test]
    fn a_contact_is_at_the_cell_of_its_node() {
        let image = crate::bake::organ().unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let subject = Subject::new(&model, 1).unwrap();
        for (cell, &node) in (0..).zip(model.input_id()) {
            let contact =
                Contact { node, normal_n: [0.0, 3.0, 4.0], area_m2: 2.0, ..Contact::default() };
            let wanted = Press { cell, position_m: [0.0; 3], pressure_pa: 2.5 };
            assert_eq!(subject.press(&contact), Some(wanted));
            assert_eq!(subject.ids[subject.rows[cell as usize] as usize], (node, cell));
        }
        assert_eq!(subject.press(&Contact { node: u32::MAX, ..Contact::default() }), None);
    }
}
