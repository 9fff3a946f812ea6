//! Offsets of the skin on the device: sent where they change, and never under what was recorded with others.

use super::case::{case, device, potential, run, start};
use std::sync::Arc;
use supple::internal::{pose_offsets, random_avatar};
use supple::potential::{Evaluation, GpuOptions, Potential};

/// A step's start only waits for its first evaluation: a skin that is posed meanwhile has offsets of its own.
#[test]
fn a_skin_posed_between_start_and_evaluation_does_not_change_the_step() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(3, 4, 8, 100, 200));
    let case = case(2, &avatar);
    let others = pose_offsets(8, &avatar, 5e-3);
    assert!(!case.offsets.is_empty());
    let mut potential = potential(&gpu, &avatar, 1, GpuOptions::default());
    let state = std::slice::from_ref(&case.states[0]);
    let mut evaluated = |offsets: Option<&[[f32; 3]]>| {
        let mut out = [Evaluation::default()];
        pollster::block_on(async {
            potential.begin_step(&[start(&case)], &[true]).await?;
            if let Some(offsets) = offsets {
                potential.pose_skin(state, &[offsets], &[]).await?;
            }
            potential.evaluate(state, &[true], &mut out).await
        })
        .unwrap();
        let [evaluation] = out;
        evaluation
    };
    let wanted = evaluated(None);
    assert!(wanted.contacts > 0);
    // With the device's own offsets unsent, of the step before, and with new ones.
    for offsets in [&others[..], &[], &case.offsets, &others] {
        assert_eq!(evaluated(Some(offsets)), wanted);
    }
}

#[test]
fn offsets_that_are_taken_away_leave_no_trace() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(3, 4, 8, 100, 200));
    let (with, without) = (case(2, &avatar), case(3, &avatar));
    assert!(!with.offsets.is_empty() && without.offsets.is_empty());
    let mut fresh = potential(&gpu, &avatar, 1, GpuOptions::default());
    let wanted = run(&mut fresh, &[&without]);
    let mut used = potential(&gpu, &avatar, 1, GpuOptions::default());
    assert!(run(&mut used, &[&with]) != wanted);
    assert_eq!(run(&mut used, &[&without]), wanted);
}
