//! Programs that use the scene's names for messages of another release or make.

use chaincell_tests::outsider::tools::Poses;
use chaincell_tests::outsider::{OtherPoses, OtherService, PosesOfAnotherRelease};
use chaincell_tests::{Running, run, turn};

use super::*;

// REQ-COS-04
#[test]
fn a_service_of_another_release_or_layout_is_refused_by_name() {
    let _turn = turn();
    let place = Place::stiff("other-type");
    let args = ["serve", text(&place.model), "--scene", &place.scene, "--contact", "40"];
    {
        let _release =
            OtherService::<PosesOfAnotherRelease>::create(&place.scene, "tools").unwrap();
        for ended in [run(args), run(["control", "--scene", &place.scene])] {
            let ended = ended.with(2);
            for part in [
                &format!("chaincell/{}/tools", place.scene),
                "chaincell.ToolPoses.v3 of 24 bytes",
                "chaincell.ToolPoses.v2 of 344 bytes",
                "--scene NAME",
            ] {
                assert!(ended.err.contains(part), "{}", ended.err);
            }
            assert!(!ended.out.contains("ready"), "{}", ended.out);
        }
    }
    {
        let _layout = OtherService::<OtherPoses>::create(&place.scene, "tools").unwrap();
        let ended = run(args).with(2);
        assert!(ended.err.contains("chaincell.ToolPoses.v2 of 32 bytes"), "{}", ended.err);
    }
    {
        // Our own messages, in fewer places.
        let _small = OtherService::<Poses>::create(&place.scene, "tools").unwrap();
        let ended = run(args).with(2);
        assert!(ended.err.contains("start chaincell serve first"), "{}", ended.err);
    }
    // Once it is gone the scene is ours.
    place.serve(&[]).interrupt().with(130);
}

// REQ-COS-04
#[test]
fn a_program_of_another_release_or_layout_cannot_join_and_disturbs_nobody() {
    let _turn = turn();
    one_of_a_few(|| {
        let (place, serve, outsider) = served("other-joins");
        let control: Running = holding_control(&place, 800);
        let mut seen = until(&outsider, |force| force.tick >= 250);
        assert!(OtherService::<PosesOfAnotherRelease>::create(&place.scene, "tools").is_err());
        assert!(OtherService::<OtherPoses>::create(&place.scene, "tools").is_err());
        assert!(OtherService::<OtherPoses>::create(&place.scene, "forces").is_err());
        let (ended, more) = until_end(control, &outsider);
        seen.extend(more);
        undisturbed("programs with another layout or release", ended, serve, &seen, 800)
    });
}
