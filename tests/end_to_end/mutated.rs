//! `inspect` over files with an error in them: no panic, no hang, nothing absurd accepted.
//!
//! Set-up: the shapes of `lab_files` and the shipped data, each mutated at random - bytes, fields, columns, rows - and read
//! with and without the answers. Tolerance: none; what is accepted has finite, possible numbers in it.

use super::lab_files::shapes;
use super::program::repository;
use runner::data::{Measurement, Reading, SpecimenFiles, Wanted};
use runner::inspection::{Options, examine, page, table};
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

const FIELDS: [&[u8]; 12] =
    [b"1e30", b"-1e30", b"NaN", b"inf", b"", b"-9999", b"1e-400", b"0x10", b"1,5", b"12:30", b"\"", b"#N/A"];

/// One error put into a file.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    let line_start =
        |bytes: &[u8], at: usize| bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    let line_end = |bytes: &[u8], at: usize| {
        bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |i| at + i + 1)
    };
    let is_separator = |b: &u8| b",;\t\n".contains(b);
    match random.below(9) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => drop(bytes.splice(at..at, [random.next() as u8])),
        2 => bytes.truncate(at),
        3 => {
            let (from, to) = (line_start(bytes, at), line_end(bytes, at));
            let line = bytes[from..to].to_vec();
            drop(bytes.splice(from..from, line));
        }
        4 => drop(bytes.drain(line_start(bytes, at)..line_end(bytes, at))),
        5 => {
            let to = bytes[at..].iter().position(is_separator).map_or(bytes.len(), |i| at + i);
            let from = bytes[..at].iter().rposition(is_separator).map_or(0, |i| i + 1);
            drop(bytes.splice(from..to.max(from), FIELDS[random.below(FIELDS.len())].to_vec()));
        }
        6 => {
            // A column twice: the first field of every line again at its end.
            let lines = bytes.split(|b| *b == b'\n').map(|line| {
                let end = line.iter().position(is_separator).unwrap_or(line.len());
                let separator = line.get(end).copied().into_iter();
                line.iter().copied().chain(separator).chain(line[..end].iter().copied()).collect::<Vec<u8>>()
            });
            *bytes = lines.collect::<Vec<_>>().join(&b'\n');
        }
        7 => {
            let (old, new) =
                ([b',', b';', b'.', b'\t'][random.below(4)], [b',', b';', b'.', b' '][random.below(4)]);
            bytes.iter_mut().filter(|b| **b == old).for_each(|b| *b = new);
        }
        _ => {
            let (from, to) = (line_start(bytes, at), line_end(bytes, at));
            let line = bytes.drain(from..to).collect::<Vec<u8>>();
            let elsewhere = random.below(bytes.len());
            let other = line_start(bytes, elsewhere);
            drop(bytes.splice(other..other, line));
        }
    }
    if bytes.is_empty() {
        bytes.push(b'\n');
    }
}

/// What was accepted is a measurement.
fn check(m: &Measurement) {
    assert!(m.len() >= 5 && m.time_s.windows(2).all(|w| w[1] > w[0]));
    let possible = |values: &[f64], most: f64| values.iter().all(|v| v.is_finite() && v.abs() <= most);
    assert!(possible(&m.time_s, 1e9) && possible(&m.displacement_m, 20.0), "{:?}", m.file);
    assert!(m.curves_n().iter().all(|c| c.len() == m.len() && possible(c, 2e6)), "{:?}", m.file);
    assert!(m.depth_m() > 0.0);
}

/// Reads and inspects one file; whether it was accepted.
fn inspect(file: &Path, reading: &Reading) -> bool {
    let Ok(tests) = SpecimenFiles::of(file).and_then(|f| f.read(Wanted::MotionAndForce, reading)) else {
        return false;
    };
    check(&tests.measurement);
    let options = Options { contact_threshold_n: 1e-3, water: None, command: String::new() };
    match examine(&[tests], &options) {
        Ok(found) => {
            let text = serde_json::to_string(&found).expect("JSON");
            serde_json::from_str::<runner::inspection::Inspection>(&text)
                .expect("JSON that can be read back");
            assert!(!table(&found).contains("NaN") && page(&found).contains("</html>"));
            true
        }
        Err(error) => {
            assert!(error.to_string().contains("remedy"), "{error}");
            false
        }
    }
}

/// Nothing takes longer, also unoptimised and on a busy machine.
const LIMIT: Duration = Duration::from_secs(60);

fn over(files: usize) {
    let d = tempfile::tempdir().expect("a directory");
    let mut sources: Vec<Vec<u8>> = shapes().into_iter().map(|s| s.bytes).collect();
    for shipped in ["data/measurement/table1-one-cycle/P2.csv", "data/measured/hayes_relax_1.csv"] {
        sources.push(std::fs::read(repository(shipped)).expect("data"));
    }
    let answered =
        Reading { zero: "contact".parse().ok(), tare: "off-contact".parse().ok(), ..Reading::default() };
    let (mut accepted, mut slowest) = (0, Duration::ZERO);
    for k in 0..files {
        let mut random = Random(k as u64);
        let mut bytes = sources[k % sources.len()].clone();
        for _ in 0..=random.below(3) {
            mutate(&mut bytes, &mut random);
        }
        let file = d.path().join(format!("mutated_{k}.csv"));
        std::fs::write(&file, &bytes).expect("a file");
        let reading = if k % 2 == 0 { answered.clone() } else { Reading::default() };
        let (begun, (tell, told), path) = (Instant::now(), channel(), file.clone());
        // Left behind if it hangs: the test must end.
        std::thread::spawn(move || tell.send(inspect(&path, &reading)));
        accepted += usize::from(match told.recv_timeout(LIMIT) {
            Ok(is_accepted) => is_accepted,
            Err(RecvTimeoutError::Timeout) => panic!("file {k} (seed {k}) takes longer than {LIMIT:?}"),
            Err(RecvTimeoutError::Disconnected) => panic!("file {k} (seed {k}): see the panic above"),
        });
        slowest = slowest.max(begun.elapsed());
        std::fs::remove_file(&file).expect("removed");
    }
    println!("{accepted} of {files} accepted, slowest {slowest:?}");
    assert!(accepted > files / 20, "{accepted} of {files}: the mutations test the first check only");
}

#[test]
fn a_thousand_mutated_files_are_read_or_refused() {
    over(1000);
}

#[test]
#[ignore = "long: some minutes"]
fn ten_thousand_mutated_files_are_read_or_refused() {
    over(10_000);
}
