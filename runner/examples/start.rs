//! Scratch.
use runner::data::{Reading, Wanted, read_tests};
use runner::inference::start::{Face, Known, Rig, Start};
fn main() {
    let files: Vec<std::path::PathBuf> = std::env::args().skip(1).map(Into::into).collect();
    let mut rig = Rig {
        face: Face::Flat { radius: 2e-3 },
        sample_radius: 1e-2,
        sample_height: 1e-2,
        bonded_face: true,
        bonded_support: true,
    };
    if std::env::var("SPHERE").is_ok() {
        rig.face = Face::Sphere { radius: 1.5e-4, shank: 1.5e-4 };
    }
    for f in &files {
        let tests = read_tests(&[f.clone()], Wanted::MotionAndForce, &Reading::default()).unwrap();
        let t = std::time::Instant::now();
        let s = Start::of(
            &[&tests[0].measurement],
            &Known { rig, lambda_star_pa: 1e5, fluid_viscosity_pa_s: 0.89e-3 },
            1,
        );
        println!("{} {:.2} s {}", f.display(), t.elapsed().as_secs_f64(), s.unwrap().in_words());
    }
}
