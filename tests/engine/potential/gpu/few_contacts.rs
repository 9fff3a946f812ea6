//! More contacts than there is room for: the deepest of the step's start are kept, and the rest is told.

use super::case::{case, device, potential, start};
use std::sync::Arc;
use supple::internal::random_avatar;
use supple::potential::{Difference, Evaluation, GpuOptions, Potential, Trial};

#[test]
fn the_deepest_are_kept_through_a_step_and_the_rest_is_counted() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(6, 3, 5, 40, 100));
    let case = case(3, &avatar);
    let evaluate = |contacts: usize| {
        let options = GpuOptions {
            contacts,
            ..GpuOptions::default()
        };
        let mut on_device = potential(&gpu, &avatar, 1, options);
        pollster::block_on(async {
            on_device.begin_step(&[start(&case)], &[true]).await?;
            let mut of_states = Vec::new();
            for state in [&case.current, &case.states[0], &case.states[1]] {
                let mut out = [Evaluation::default()];
                let states = std::slice::from_ref(state);
                on_device.evaluate(states, &[true], &mut out).await?;
                let [evaluation] = out;
                of_states.push(evaluation);
            }
            let trial = Trial {
                instance: 0,
                base: &case.states[0],
                state: &case.states[1],
            };
            let mut difference = [Difference::default()];
            on_device
                .energy_differences(&[trial], &mut difference)
                .await?;
            Ok::<_, supple::Error>((of_states, difference[0].energy))
        })
        .unwrap()
    };
    let (all, _) = evaluate(4096);
    let touching = all[0].contacts;
    assert!(touching > 8, "{touching} contacts");
    assert!(all.iter().all(|e| e.contacts_left_out == 0));
    let room = touching / 2;
    let (few, difference) = evaluate(room);
    // At qⁿ itself the room is full, and what touches beyond it is told.
    assert_eq!(few[0].contacts, room);
    assert_eq!(few[0].contacts + few[0].contacts_left_out, touching);
    for (few, all) in few.iter().zip(&all) {
        assert!(few.contacts <= room);
        assert_eq!(few.contacts + few.contacts_left_out, all.contacts);
        assert!(few.contact_force.length() < all.contact_force.length() * 2.0);
    }
    // One function of q: energies measured from qⁿ and from each other agree to f32's resolution of E.
    let [a, b] = [&few[1], &few[2]].map(|e| e.energies.total());
    let size = [&few[1], &few[2]].map(|e| {
        let e = e.energies;
        e.inertia.abs() + e.elastic.abs() + e.damping.abs() + e.contact.abs() + e.friction.abs()
    });
    let error = (b - a - difference).abs();
    assert!(
        error < 1e-5 * (size[0] + size[1]),
        "{error:e} J of {size:?}"
    );
}
