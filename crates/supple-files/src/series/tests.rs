use super::*;
use supple::sim::Load;

fn example() -> Series {
    let vectors = |scale: f64| -> Vec<DVec3> {
        let place = |k: u32| scale * DVec3::new(f64::from(k), 0.5, -1.0);
        (0..6).map(place).collect()
    };
    Series {
        time: vec![0.01, 0.02],
        vertices: vectors(1.0),
        displacement: vectors(1e-3),
        contact_force: vectors(0.1),
        loads: vec![
            [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            [0.0; 6],
            [0.5; 6],
            [-1.0; 6],
        ],
        energies: vec![std::array::from_fn(|k| k as f64), [1e-9; ENERGY_TERMS]],
        faces: vec![[0, 1, 2]],
        bone_names: vec!["root".into(), "tip".into()],
    }
}

#[test]
fn what_is_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("series.npz");
    write_series(&example(), &path).unwrap();
    assert_eq!(read_series(&path).unwrap(), example());
    // The same bytes, whenever they are written.
    let bytes = std::fs::read(&path).unwrap();
    write_series(&example(), &path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
}

#[test]
fn lengths_that_do_not_fit_are_named() {
    let path = std::env::temp_dir().join("never_written.npz");
    let mut series = example();
    series.loads.pop();
    let message = write_series(&series, &path).unwrap_err().to_string();
    assert!(
        message.starts_with("series.loads: 3 values, expected 4"),
        "{message}"
    );
    assert!(!path.exists());
}

#[test]
fn loads_of_one_bone_add_up() {
    let load = |bone, x| Load {
        bone,
        force: DVec3::X * x,
        torque: DVec3::Z,
    };
    // Of a body behind the bones nothing is said.
    let loads = loads_by_bone(&[load(1, 1.0), load(1, 2.0), load(2, 9.0)], 2);
    assert_eq!(loads, [[0.0; 6], [3.0, 0.0, 0.0, 0.0, 0.0, 2.0]]);
}
