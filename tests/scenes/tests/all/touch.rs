//! Scenes of tools on a surface: what they are there for, without sleep, and with late ticks.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{Budget, Dynamics, Flags, Model, Network, TissueMut};
use chaincell_scenes::{Act, Run, Scene, Tier, blade5_track, stage, touch6_predict, touch6_tools};

/// Ticks that are played.
const TICKS: u32 = 200;
const SCENES: [&Scene; 3] = [&touch6_predict::SCENE, &touch6_tools::SCENE, &blade5_track::SCENE];

fn played<A: Act>(scene: &Scene, act: A) -> A::Output {
    stage(scene.name, Tier::F32, act).unwrap()
}

/// Flags seen, most contacts, and most samples that each of two tools grips.
struct Watch;

impl Act for Watch {
    type Output = (Flags, u32, [usize; 2]);

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        let (mut flags, mut contacts, mut gripped) = (Flags(0), 0, [0; 2]);
        for _ in 0..TICKS {
            let (output, _) = run.tick();
            flags.insert(output.flags);
            contacts = contacts.max(output.contacts);
            gripped = [0, 1].map(|tool: usize| gripped[tool].max(run.gripped(tool)));
        }
        (flags, contacts, gripped)
    }
}

// REQ-CON-04
#[test]
fn a_sphere_touches_and_two_tools_grip_with_too_few_slots() {
    let (flags, contacts, gripped) = played(&touch6_predict::SCENE, Watch);
    assert!(!flags.contains(Flags::CONTACT_CAPACITY) && contacts > 4, "{flags:?} {contacts}");
    assert_eq!(gripped, [0, 0]);
    let (flags, contacts, gripped) = played(&touch6_tools::SCENE, Watch);
    assert!(flags.contains(Flags::CONTACT_CAPACITY) && contacts > 4, "{flags:?} {contacts}");
    assert!(gripped.iter().all(|&samples| samples > 4), "{gripped:?}");
}

/// The digest, without sleep or as it is.
struct Digest(bool);

impl Act for Digest {
    type Output = u64;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        if self.0 {
            run.forbid_sleep();
        }
        run.play(TICKS, |_, _| {});
        run.digest()
    }
}

// REQ-BIT-03
#[test]
fn sleep_changes_no_bit() {
    for scene in SCENES {
        assert_eq!(played(scene, Digest(false)), played(scene, Digest(true)), "{}", scene.name);
    }
}

/// State hashes with every third tick late and every fifth short, with the vector unit or without.
struct Late {
    scalar: bool,
}

impl Act for Late {
    type Output = Vec<(u64, [u32; 3])>;

    fn act<D: Dynamics>(self, scene: &'static Scene, mut tissue: TissueMut<'_, D>) -> Self::Output {
        let model = Model::from_bytes(scene.image).unwrap();
        let network = Network::new(model, (scene.settings)(&model)).unwrap();
        let tools = scene.tools().unwrap();
        tissue.reset(&network).unwrap();
        tissue.choose_tools(&network, tools.parts, tools.friction).unwrap();
        if self.scalar {
            tissue.go_scalar();
        }
        let tick = |tick: u32| {
            let poses = tools.poses(&scene.sample(tick));
            let output = match (tick % 3, tick % 5) {
                (2, _) => tissue.tick(&network, &poses, Budget::LATE),
                (_, 4) => tissue.tick(&network, &poses, Budget::While(&mut |done| done < 1)),
                _ => tissue.tick(&network, &poses, Budget::All),
            };
            (tissue.state_hash(&model), output.force_n.data.0[0].map(f32::to_bits))
        };
        (0..TICKS).map(tick).collect()
    }
}

// REQ-BIT-02
#[test]
fn late_and_short_ticks_have_the_same_bits_with_and_without_the_vector_unit() {
    for scene in SCENES {
        let [vector, scalar] = [false, true].map(|scalar| played(scene, Late { scalar }));
        assert!(vector.iter().zip(&scalar).all(|(a, b)| a == b), "{}", scene.name);
        let mut states: Vec<u64> = vector.iter().map(|(state, _)| *state).collect();
        states.dedup();
        assert!(states.len() > TICKS as usize / 3, "{}: the body hardly moves", scene.name);
    }
}
