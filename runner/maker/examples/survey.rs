//! Every effect in several sizes, or materials a factor of ten either way: does it run, how long, what does it do?
//! `survey effects|materials [name] [cycles] [sizes]`
use poropunch_maker::*;

/// P2 with some cycles; one ends with its hold.
fn p2(cycles: usize) -> Motion {
    let (mut t, mut from) = (0.0, -0.1);
    let mut points = vec![(0.0, -1e-4)];
    for _ in 0..cycles {
        for (to, speed, rest) in [(1.0, 1.6, 90.0), (-3.0, 1.0, 60.0), (-0.1, 1.0, 60.0)] {
            t += f64::abs(to - from) / speed;
            from = to;
            points.push((t, to * 1e-3));
            t += rest;
            points.push((t, to * 1e-3));
            if cycles == 1 {
                break;
            }
        }
    }
    Motion::new(points).expect("a motion")
}

fn report(name: &str, specimen: &Specimen, motion: &Motion, effects: &[Effect]) {
    let start = std::time::Instant::now();
    let marks = [0.05, 0.3, 0.6875, 0.75, 1.6875, 10.0, 90.6, 91.0, 92.0];
    let end = motion.points().last().expect("points").0;
    let mut times: Vec<f64> = marks.into_iter().chain([218.27, 308.2, 309.0]).filter(|&t| t <= end).collect();
    times.push(end);
    match Run::new(specimen, motion, effects).map(|run| run.readings_n(&times, effects)) {
        Ok(f) => print!(
            "{:5.1} s {}",
            start.elapsed().as_secs_f64(),
            f.iter().map(|f| format!("{:8.3}", f * 1e3)).collect::<String>()
        ),
        Err(e) => print!("{:5.1} s FAILED: {e}", start.elapsed().as_secs_f64()),
    }
    println!("  {name}");
}

fn effects(size: f64) -> Vec<Effect> {
    vec![
        Effect::SlowPair { size, time_s: 200.0 },
        Effect::Carreau { size },
        Effect::ExponentialPermeability { size },
        Effect::LogarithmicSkeleton { size: size.min(1.3) },
        Effect::EnergySoftening { size },
        Effect::SaturatingAgeing { size, time_s: 300.0 },
        Effect::Batch { size },
        Effect::Dimensions { size: size.min(1.5) },
        Effect::Film { size },
        Effect::LowFriction { coefficient: 0.1 / size },
        Effect::LeakyFace { size },
        Effect::TightBottom { size },
        Effect::TightSide { size },
        Effect::ExponentialAdhesion { size },
        Effect::ShiftedSurface { size },
        Effect::ShiftedSurface { size: -size },
        Effect::StiffeningFrame { size, force: 0.02 },
        Effect::SaturatingDrift { size, time_s: 300.0 },
        Effect::TwoPoleLag { size },
        Effect::Coarse { size: size.min(2.0) },
        Effect::Overshoot { length: 1e-5 * size, frequency: 8.0, decay_s: 0.15 },
        Effect::Wave { force: 1e-4 * size, period_s: 31.0, phase: 1.0 },
        Effect::GripStep { length: 1e-5 * size, time_s: 30.0 },
        Effect::Meniscus { force: 2e-4 * size, reach: 5e-4 },
        Effect::Tilt { height: 3e-5 * size },
        Effect::Clip { part: 0.9 },
        Effect::Clock { rate: 1e-3 * size },
        Effect::Bubble { loss: (0.05 * size).min(0.6), time_s: 25.0 },
        Effect::WarmingFrame { length: 1e-5 * size, time_s: 40.0 },
        Effect::Backlash { length: 5e-6 * size },
        Effect::Gain { part: 0.02 * size, from_s: 20.0, to_s: 40.0 },
    ]
}

fn main() {
    let arg: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |name: &str| arg.get(1).is_none_or(|a| name.contains(a.as_str()));
    let chosen = |i: usize| arg.get(1).is_none_or(|a| a.split(',').any(|a| a == i.to_string()));
    let cycles = arg.get(2).map_or(1, |c| c.parse().expect("a number of cycles"));
    if arg[0] == "effects" {
        report("plain", &Specimen::table1(), &p2(cycles), &[]);
        let sizes = arg.get(3).map_or("1,10", |s| s);
        for size in sizes.split(',').map(|s| s.parse().expect("a size")) {
            for effect in effects(size) {
                let name = format!("{effect:?}");
                if wanted(&name) {
                    report(&name, &Specimen::table1(), &p2(cycles), &[effect]);
                }
            }
        }
        return;
    }
    // Log-uniform within a factor of ten either way, by a generator of our own.
    let mut seed = 12345u64;
    let mut factor = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        10f64.powf(2.0 * ((seed >> 11) as f64 / (1u64 << 53) as f64) - 1.0)
    };
    for i in 0..20 {
        let mut s = Specimen::table1();
        let m = &mut s.material;
        let mut spring = |o: &mut Ogden| {
            let modulus = o.shear_modulus() * factor();
            o.alpha = -(-o.alpha * factor()).clamp(1.0, 30.0);
            o.mu = 2.0 * modulus / o.alpha;
            modulus
        };
        spring(&mut m.equilibrium);
        let moduli: Vec<(f64, f64)> =
            m.branches.iter_mut().map(|b| (b.relaxation_time(), spring(&mut b.spring))).collect();
        for (b, (time, modulus)) in m.branches.iter_mut().zip(moduli) {
            b.eta = time * factor() * modulus;
        }
        m.lambda *= factor();
        m.permeability *= factor();
        if chosen(i) {
            report(&format!("{i}: {m:?}"), &s, &p2(cycles), &[]);
        }
    }
}
