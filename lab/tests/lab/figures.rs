//! Every figure at its small size: what it draws can be drawn, and all of its checks hold. A figure's test is
//! called like the figure.

use super::RUNNER;
use supple_lab::{FIGURES, Figure};

fn holds(name: &str) {
    let figure: &Figure = FIGURES.iter().find(|f| f.name == name).unwrap();
    let page = (figure.draw)(&RUNNER).unwrap();
    for check in &page.checks {
        println!("{check}");
    }
    assert!(!page.checks.is_empty(), "{name} checks nothing");
    let failures: Vec<String> = page.failures().map(ToString::to_string).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A test for each figure, and one that none is forgotten.
macro_rules! figures {
    ($($name:ident),* $(,)?) => {
        $(
            #[test]
            fn $name() {
                holds(stringify!($name));
            }
        )*

        #[test]
        fn every_figure_is_tested() {
            let listed: Vec<&str> = FIGURES.iter().map(|f| f.name).collect();
            assert_eq!(listed, [$(stringify!($name)),*]);
        }
    };
}

figures![
    static_poses,
    rigid_soft,
    layers,
    spin,
    cylinders,
    walk,
    finger_slide,
    ragdolls,
    lift,
    cubature,
    reduced_full,
    table_1,
    bases_hand,
    bases_chest,
    pin_press,
    convergence,
    stability,
    slope,
    jiggle,
    bone_press,
    compression,
    elastic_extension,
    press_anywhere,
    sway,
];
