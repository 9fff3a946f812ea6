//! The benchmark's limb.

use std::collections::BTreeSet;
use std::path::Path;
use supple::model::TetMesh;
use supple_bake::Limb;
use supple_files::read_tet_mesh;

#[test]
fn generated_mesh_is_the_benchmarks_own() {
    for (limb, name) in [(Limb::S, "mesh_S.txt"), (Limb::M, "mesh_M.txt")] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../../shared/benchmarks")
            .join(name);
        if !path.exists() {
            println!(
                "skipped: {} is not there; counts and volume are checked anyway",
                path.display()
            );
            continue;
        }
        let file = read_tet_mesh(&path).unwrap();
        let (mesh, pinned, surface) = limb.mesh().unwrap();
        assert!(pinned == file.pinned && surface == file.surface);
        assert_eq!(mesh.nodes.len(), file.mesh.nodes.len());
        for (a, b) in mesh.nodes.iter().zip(&file.mesh.nodes) {
            assert!((*a - *b).length() < 1e-9, "{a} {b}");
        }
        let set = |mesh: &TetMesh| -> BTreeSet<[u32; 4]> {
            let sorted = |tet: &[u32; 4]| {
                let mut tet = *tet;
                tet.sort_unstable();
                tet
            };
            mesh.tets.iter().map(sorted).collect()
        };
        assert!(set(&mesh) == set(&file.mesh), "the tets differ");
    }
}
