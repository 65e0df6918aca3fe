//! Compares Table 1 with a curve of `runner simulate --points N [--cycles N]` or of `tests/reference`:
//! `compare CURVE.csv P1|P2 [tolerance] [edge growth near]`.
use poropunch_maker::*;

fn main() {
    let arg: Vec<String> = std::env::args().collect();
    let num = |i: usize, d: f64| arg.get(i).map_or(d, |s| s.parse().expect("a number"));
    let text = std::fs::read_to_string(&arg[1]).expect("a curve");
    let rows: Vec<Vec<f64>> =
        text.lines().filter_map(|l| l.split(',').take(3).map(|v| v.parse().ok()).collect()).collect();
    let (rate, up) = if arg[2] == "P1" { (1.0, 3.8) } else { (1.6, 3.0) };
    let gap = -rows[0][1];
    let end = rows[rows.len() - 1][0];
    let mut points = vec![(0.0, -gap * 1e-3)];
    let mut t = 0.0;
    let mut from = -gap;
    while t < end - 1e-6 {
        for (to, speed, rest) in [(1.0, rate, 90.0), (-up, 1.0, 60.0), (-0.1, 1.0, 60.0)] {
            t += f64::abs(to - from) / speed;
            from = to;
            points.push((t, to * 1e-3));
            t += rest;
            points.push((t, to * 1e-3));
        }
    }
    points.retain(|p| p.0 <= end + 1e-3);
    let motion = Motion::new(points).expect("a motion");
    let fine = Fineness { edge: num(4, 0.004), growth: num(5, 0.5), near: num(6, 0.2) };
    let start = std::time::Instant::now();
    let h = simulate_plain(&Specimen::table1(), &motion, fine, num(3, 5e-4)).expect("a solution");
    eprintln!("{:.1} s", start.elapsed().as_secs_f64());
    let peak = rows.iter().map(|r| r[2]).fold(0.0, f64::max);
    let mut phase = 0;
    let mut worst = (0.0f64, 0.0, 0.0, 0.0);
    let print = |phase: usize, w: (f64, f64, f64, f64)| {
        println!(
            "piece {phase:2}: {:+7.3} % of the peak at {:8.3} s: {:8.4} mN, {:8.4}",
            w.0 * 100.0,
            w.1,
            w.2,
            w.3
        );
    };
    for r in &rows {
        while r[0] > motion.points()[phase + 1].0 + 1e-3 {
            print(phase, worst);
            (phase, worst) = (phase + 1, (0.0, 0.0, 0.0, 0.0));
        }
        let force = h.at(r[0]) * 1e3;
        let off = (force - r[2]) / peak;
        if off.abs() > worst.0.abs() {
            worst = (off, r[0], force, r[2]);
        }
    }
    print(phase, worst);
}
