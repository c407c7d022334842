//! A scene's trace, written and played in a scene's own tissue, as firmware does it.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::trace::{End, Played, Reader, header_bytes};
use chaincell_kernel::{Budget, Dynamics, Model, TissueMut};
use chaincell_scenes::{Act, Run, SCENES, Scene, box7_track, stage};

/// The trace of a scene's first ticks.
struct Record(u32);

impl Act for Record {
    type Output = Option<Vec<u8>>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        let mut trace = vec![0; header_bytes(scene.held.len())];
        let (mut writer, bytes) = run.begin_trace(&mut trace)?;
        assert_eq!(bytes, trace.len());
        for _ in 0..self.0 {
            trace.extend(writer.record(&run.record()));
        }
        Some(trace)
    }
}

/// Plays a trace in a tissue of the scene.
struct Play<'t>(&'t [u8]);

impl Act for Play<'_> {
    type Output = Played;

    fn act<D: Dynamics>(self, scene: &'static Scene, mut tissue: TissueMut<'_, D>) -> Played {
        let trace = Reader::open(self.0).unwrap();
        assert!(trace.header().is_of::<D>());
        let model = Model::from_bytes(scene.image).unwrap();
        let network = trace.header().network(model).unwrap();
        let mut room = [0; 16];
        tissue.reset(&network).unwrap();
        let cells = trace.contact_cells(&model, &mut room).unwrap();
        tissue.choose_contacts(&network, cells).unwrap();
        let played = trace.play(|record| {
            tissue.tick(&network, &[record.sample], Budget::again(record.sweeps));
            tissue.state_hash(&model)
        });
        played.unwrap()
    }
}

// REQ-TRC-01
#[test]
fn the_trace_of_every_scene_is_played_to_the_same_bits() {
    let tiers = |scene: &'static Scene| scene.tiers.iter().map(move |&tier| (scene, tier));
    for (scene, tier) in SCENES.into_iter().flat_map(tiers) {
        let trace = stage(scene.name, tier, Record(80)).unwrap();
        // The poses of tools take records of their own.
        assert_eq!(trace.is_none(), scene.tools().is_some());
        let Some(trace) = trace else { continue };
        let played = stage(scene.name, tier, Play(&trace)).unwrap();
        let wanted = Played { ticks: 80, compared: 80, end: End::Complete };
        assert_eq!(played, wanted, "{}", scene.name);
    }
}

#[test]
fn a_trace_needs_room_for_its_header() {
    let mut tissue = box7_track::Body::new();
    let run = Run::new(&box7_track::SCENE, tissue.view()).unwrap();
    assert!(run.begin_trace(&mut [0; 87]).is_none());
    assert!(run.begin_trace(&mut [0; 88]).is_some());
}
