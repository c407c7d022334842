//! The frame of a running scene, as it is sent to a page.
//!
//! Little-endian, one part after the other:
//!
//! | part | each |
//! |---|---|
//! | head, 64 bytes | version u32 = 1, model checksum u32, tick u64, ticks answered u64, state hash u64, flags u32, sweeps u32, step u32 \[ns\], energy f32 \[J\], numbers of tools, points and cells u32, 0 u32 |
//! | tools, 68 bytes each | number u32, engaged u32, position 3 f32 \[m\], orientation x, y, z, w f32, force 3 f32 \[N\], torque 3 f32 \[N m\], contacts u32, flags u32 |
//! | points, 32 bytes each | tick u64, force 3 f32 \[N\] and position 3 f32 \[m\] of tool 0, oldest first |
//! | cells, 12 bytes each | position 3 f32 \[m\], in the order of the model image |
//!
//! Points are the last ticks, up to 64: a page that skips frames has the curves without gaps.

use chaincell_kernel::{Model, ToolPose};

use crate::error::{Error, Result};
use crate::session::ipc::payload::{NodePosition, StateHeader};
use crate::session::ipc::tools::{OneToolForce, OneToolPose, ToolForces, ToolPoses};
use crate::session::ipc::watching::WatchPorts;

/// Version of the layout.
const VERSION: u32 = 1;

/// The body and the tools that a page shows.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Checksum of its model image.
    pub checksum: u32,
    /// Row of each cell in a state.
    rows: Vec<u32>,
    tools: usize,
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
        let ids = model.input_id();
        let mut cells: Vec<usize> = (0..model.cells()).collect();
        cells.sort_unstable_by_key(|&cell| ids.get(cell));
        let mut rows = vec![0; cells.len()];
        for (row, cell) in (0..).zip(cells) {
            rows[cell] = row;
        }
        Ok(Self { checksum: model.checksum(), rows, tools: tools.max(1) })
    }

    /// Returns true if a state is one of this body.
    #[must_use]
    pub fn is_of(&self, header: &StateHeader, nodes: &[NodePosition]) -> bool {
        header.model_checksum == self.checksum && nodes.len() == self.rows.len()
    }

    /// The frame of a state of this body, with the tools of a tick and the curves of the last ones.
    #[must_use]
    pub fn frame(
        &self,
        header: &StateHeader,
        nodes: &[NodePosition],
        tick: u64,
        ports: &WatchPorts,
    ) -> Vec<u8> {
        let (poses, answer) = (find_pose(ports, tick), find_answer(ports, tick));
        let points: Vec<Point> = ports
            .answers()
            .iter()
            .filter_map(|of| Point::new(of, find_pose(ports, of.tick)))
            .collect();
        self.encode(header, nodes, &poses.unwrap_or_default(), &answer.unwrap_or_default(), &points)
    }

    fn encode(
        &self,
        header: &StateHeader,
        nodes: &[NodePosition],
        poses: &ToolPoses,
        answer: &ToolForces,
        points: &[Point],
    ) -> Vec<u8> {
        let mut frame =
            Frame(Vec::with_capacity(64 + 68 * 8 + 32 * points.len() + 12 * nodes.len()));
        // The head.
        frame.whole(VERSION).whole(header.model_checksum);
        frame.long(header.tick).long(header.ticks_answered).long(header.state_hash);
        frame.whole(header.flags).whole(answer.sweeps).whole(answer.step_ns).real(answer.energy_j);
        frame.count(self.tools).count(points.len()).count(self.rows.len()).whole(0);
        // The tools: one that no message has is away.
        for number in 0..self.tools {
            let in_use = poses.each.iter().take(poses.tools as usize);
            let away = ToolPose::AWAY;
            let pose = in_use.copied().find(|of| of.number as usize == number);
            let pose =
                pose.unwrap_or(OneToolPose { orientation: away.orientation, ..Default::default() });
            let force = answer.each_tool().find(|(of, _)| *of == number);
            let force = force.map_or_else(OneToolForce::default, |(_, force)| *force);
            frame.count(number).whole(pose.engaged);
            frame.reals(&pose.position_m).reals(&pose.orientation);
            frame.reals(&force.force_n).reals(&force.torque_n_m);
            frame.whole(force.contacts).whole(force.flags);
        }
        // The points and the cells.
        for Point { tick, force_n, position_m } in points {
            frame.long(*tick).reals(force_n).reals(position_m);
        }
        for &row in &self.rows {
            frame.reals(&nodes.get(row as usize).copied().unwrap_or_default().position_m);
        }
        frame.0
    }
}

/// A point of the curves: tool 0 in a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    tick: u64,
    force_n: [f32; 3],
    position_m: [f32; 3],
}

impl Point {
    /// Of an answer and the poses that it answers; `None` where one of them does not have tool 0.
    fn new(answer: &ToolForces, poses: Option<ToolPoses>) -> Option<Self> {
        let (_, force) = answer.each_tool().find(|(number, _)| *number == 0)?;
        let poses = poses?;
        let pose = poses.each.iter().take(poses.tools as usize).find(|of| of.number == 0)?;
        Some(Self { tick: answer.tick, force_n: force.force_n, position_m: pose.position_m })
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

    #[test]
    fn a_frame_holds_the_state_in_the_order_of_the_cells() {
        let subject = Subject { checksum: 0xC4EC, rows: vec![2, 0, 1], tools: 2 };
        let header = StateHeader {
            tick: 1 << 40,
            ticks_answered: 7,
            state_hash: 0xFEDC_BA98_7654_3210,
            nodes: 3,
            flags: 8,
            model_checksum: 0xC4EC,
            reserved: 0,
        };
        let nodes = [10, 20, 30].map(|node| NodePosition { node, position_m: [node as f32; 3] });
        let mut poses = ToolPoses { tick: 1 << 40, tools: 1, ..ToolPoses::default() };
        poses.each[0] = OneToolPose {
            number: 1,
            engaged: 1,
            position_m: [1.0, 2.0, 3.0],
            orientation: [0.0, 0.6, 0.0, 0.8],
            reserved: 0,
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
            reserved: 0,
        };
        let point = Point { tick: 9, force_n: [1.5; 3], position_m: [2.5; 3] };
        let frame = subject.encode(&header, &nodes, &poses, &answer, &[point]);
        assert_eq!(frame.len(), 64 + 2 * 68 + 32 + 3 * 12);
        let mut words = Words(&frame);
        assert_eq!([words.whole(), words.whole()], [VERSION, 0xC4EC]);
        assert_eq!([words.long(), words.long(), words.long()], [1 << 40, 7, 0xFEDC_BA98_7654_3210]);
        assert_eq!([words.whole(), words.whole(), words.whole()], [8, 4, 260_000]);
        assert_eq!(words.reals(), [0.5]);
        assert_eq!([words.whole(), words.whole(), words.whole(), words.whole()], [2, 1, 3, 0]);
        // No message has tool 0.
        assert_eq!([words.whole(), words.whole()], [0, 0]);
        assert_eq!(words.reals(), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(words.reals(), [0.0; 6]);
        assert_eq!([words.whole(), words.whole()], [0, 0]);
        assert_eq!([words.whole(), words.whole()], [1, 1]);
        assert_eq!(words.reals(), [1.0, 2.0, 3.0, 0.0, 0.6, 0.0, 0.8]);
        assert_eq!(words.reals(), [0.1, 0.2, 0.3, 4.0, 5.0, 6.0]);
        assert_eq!([words.whole(), words.whole()], [6, 16]);
        assert_eq!(words.long(), 9);
        assert_eq!(words.reals(), [1.5, 1.5, 1.5, 2.5, 2.5, 2.5]);
        assert_eq!(words.reals(), [30.0, 30.0, 30.0, 10.0, 10.0, 10.0, 20.0, 20.0, 20.0]);
        assert!(words.0.is_empty());
        let other = StateHeader { model_checksum: 1, ..header };
        assert!(subject.is_of(&header, &nodes) && !subject.is_of(&other, &nodes));
        assert!(!subject.is_of(&header, &nodes[..2]));
    }
}
