//! Table 1's tests.
use poropunch_maker::*;
fn main() {
    let arg: Vec<String> = std::env::args().collect();
    let num = |i: usize, d: f64| arg.get(i).map_or(d, |s| s.parse().unwrap());
    let rate = num(1, 1.6e-3);
    let fine = Fineness { edge: num(2, 0.004), growth: num(3, 0.55), near: num(4, 0.3) };
    let tol = num(5, 2e-4);
    let friction = num(6, 1.0);
    let t1 = 1.1e-3 / rate;
    let motion = Motion::new(vec![(0.0, -1e-4), (t1, 1e-3), (t1 + 90.0, 1e-3)]).unwrap();
    let start = std::time::Instant::now();
    let h = simulate(&Specimen::table1(), &motion, friction, fine, tol).unwrap();
    eprintln!("{:?}", start.elapsed());
    for t in [0.1, 0.2, t1, t1 + 0.02, t1 + 0.1, t1 + 1.0, t1 + 3.0, t1 + 10.0, t1 + 30.0, t1 + 90.0] {
        println!("{t:8.4} {:9.5}", h.at(t) * 1e3);
    }
}
