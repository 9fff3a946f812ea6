use std::sync::Arc;
use supple::figures::press::{Pressed, press, press_full_space};
use supple::reference::min_det_f;
const DEPTHS: [f64; 4] = [0.0, 0.004, 0.008, 0.012];
use supple::bake::{Recipe, all_tets, bake};
use supple::glam::DVec3;
use supple::sample::Limb;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let limb = if args[1] == "S" { Limb::S } else { Limb::M };
    let body = limb.body().unwrap();
    let truth_file = format!("/tmp/truth_{}.json", args[1]);
    let mut truth: Option<Pressed> = std::fs::read_to_string(&truth_file).ok().map(|t| {
        let (d, force, m): (Vec<[f64; 3]>, f64, f64) = serde_json::from_str(&t).unwrap();
        {
            let _ = m;
            Pressed {
                displacement: d.into_iter().map(DVec3::from).collect(),
                forces: vec![force],
                state: supple::model::State {
                    frames: vec![],
                    handles: vec![],
                },
            }
        }
    });
    for file in &args[2..] {
        let text = if file.contains('=') {
            file.replace(';', "\n")
        } else {
            std::fs::read_to_string(file).unwrap()
        };
        let base = "captured_under_gravity = false\nmaterial = { stable_neo_hookean = { youngs_modulus = 30e3, poissons_ratio = 0.4 } }\n";
        let recipe: Recipe = toml::from_str(&format!("{base}{text}")).unwrap();
        let t0 = std::time::Instant::now();
        let baked = bake(&body, &recipe, &mut |_| {});
        let Ok((avatar, report)) = baked else {
            println!("{file}: {:?}", baked.err());
            continue;
        };
        let tb = t0.elapsed().as_secs_f64();
        let truth = truth.get_or_insert_with(|| {
            let p = press_full_space(&avatar, &DEPTHS).unwrap();
            let d: Vec<[f64; 3]> = p.displacement.iter().map(|d| d.to_array()).collect();
            std::fs::write(
                &truth_file,
                serde_json::to_string(&(d, p.force(), 0.0)).unwrap(),
            )
            .unwrap();
            println!("truth {} N", p.force());
            p
        });
        let t0 = std::time::Instant::now();
        let avatar = Arc::new(avatar);
        let c = press(&avatar, &DEPTHS).unwrap();
        let tc = t0.elapsed().as_secs_f64();
        let all = if std::env::var("ALL").is_ok() {
            press(&Arc::new(all_tets(&avatar).unwrap()), &DEPTHS)
                .unwrap()
                .relative_error(truth)
        } else {
            f64::NAN
        };
        println!(
            "{} handles {} points, {:.1}/{} a point, {:.1} a vertex: error {:.2} % (all tets {:.2} %), {:.2} N, det F {:.3}, bake {:.1} s press {:.1} s | {}",
            avatar.handles.len(),
            avatar.cubature.len(),
            report.basis.handles_per_point.0,
            report.basis.handles_per_point.1,
            report.basis.handles_per_vertex.0,
            100.0 * c.relative_error(truth),
            100.0 * all,
            c.force(),
            min_det_f(&avatar.layer, &c.state),
            tb,
            tc,
            file.replace('\n', " ")
        );
    }
}
