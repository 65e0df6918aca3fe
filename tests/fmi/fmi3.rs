//! The acceptance list A to F for FMI 3.0 (B, the state machine, is `cdylib/tests/fmi3_in_every_state.rs`).

use super::support::{
    archive, archive3, check_bad_steps, check_contents, check_lint, check_states, choose_coarse, initialise,
    load, python, python3,
};
use poropunch::model_description::fmi3::{instantiation_token, xml};
use runner::fmi::{Fmu, FmuInstance, Version};
use runner::package::{documentation3, lint};
use std::sync::OnceLock;
use std::time::Instant;

fn fmu() -> &'static Fmu {
    static FMU: OnceLock<Fmu> = OnceLock::new();
    FMU.get_or_init(|| Fmu::open(archive3()).unwrap())
}

fn reference(name: &str) -> u32 {
    fmu().description().variable(name).unwrap().value_reference
}

/// A coarse instance that follows the inputs, ready to step.
fn running() -> FmuInstance {
    let mut instance = fmu().instantiate("test").unwrap();
    choose_coarse(&mut instance);
    initialise(&mut instance, None);
    instance
}

fn number(arguments: &[&str]) -> f64 {
    python3(arguments).trim().parse().unwrap()
}

#[test]
fn a_validators_and_lint_find_no_problem() {
    assert_eq!(python3(&["validate", archive3().to_str().unwrap()]).trim(), "");
    assert_eq!(lint(archive3()).unwrap().own, Vec::<String>::new());
}

#[test]
fn a_the_lint_finds_each_planted_problem() {
    let good = xml();
    let planted = [
        (good.replacen("start=\"-418.0 ", "start=\"NaN ", 1), "is not finite"),
        (
            good.replacen("canGetAndSetFMUState=\"true\"", "canGetAndSetFMUState=\"false\"", 1),
            "canSerializeFMUstate without",
        ),
        (good.replacen(instantiation_token(), " ", 1), "the GUID is empty"),
        (
            good.replacen("<Output valueReference=\"2\"", "<Output valueReference=\"3\"", 1),
            "a variable twice",
        ),
        (good.replacen(" nominal=\"0.01\"", "", 1), "no nominal value"),
        (good.replacen("causality=\"independent\"", "causality=\"local\"", 1), "one independent variable"),
    ];
    check_lint(&good, planted);
}

#[test]
fn a_has_everything_and_is_the_same_byte_for_byte() {
    let expected = [
        "modelDescription.xml",
        "terminalsAndIcons/terminalsAndIcons.xml",
        "terminalsAndIcons/icon.png",
        "documentation/index.html",
        "documentation/licenses/third-party.txt",
        "binaries/x86_64-linux/poropunch.so",
    ];
    check_contents(Version::Three, archive3(), &expected);
    let page = documentation3();
    for port in poropunch::variables::ports::Port::all() {
        assert!(page.contains(&format!("<code>{}</code>", port.name())), "{} undocumented", port.name());
    }
}

/// The elements of arrays have the names that they have in FMI 2.0, and their starts, ranges and units.
#[test]
fn a_both_descriptions_say_the_same() {
    let two = Fmu::builtin().unwrap();
    for variable in two.description().variables.iter().filter(|v| !v.name.ends_with("_number")) {
        let three = fmu().description().variable(&variable.name).unwrap();
        assert_eq!((three.kind, &three.causality), (variable.kind, &variable.causality), "{}", variable.name);
        assert_eq!((&three.start, three.range), (&variable.start, variable.range));
        assert_eq!((&three.unit, three.display_factor), (&variable.unit, variable.display_factor));
        assert_eq!(three.items, variable.items);
    }
}

#[test]
fn c_bad_steps_are_errors_and_reset_helps() {
    check_bad_steps(running, "fmi3DoStep");
}

#[test]
fn c_bad_values_are_refused_and_the_old_ones_stay() {
    let mut instance = running();
    let input = [reference("displacement")];
    instance.set_real(&input, &[1e-4]).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        let error = instance.set_real(&input, &[bad]).unwrap_err().to_string();
        assert!(error.contains("displacement") && error.contains("not a finite number"), "{error}");
    }
    assert_eq!(instance.get_real(&input).unwrap(), [1e-4]);
    let error = instance.set_real(&[reference("material.branch[2].mu")], &[-1.0]).unwrap_err().to_string();
    assert!(error.contains("material.branch.mu is fixed"), "{error}");
    load(&mut instance, 0.0, 0.1, 2);
    let parts = ["force", "force_solid", "force_fluid"].map(reference);
    let [force, solid, fluid] = instance.get_real(&parts).unwrap()[..] else { panic!() };
    assert!((force - solid - fluid).abs() <= force * f64::EPSILON);
}

#[test]
fn d_states_repeat_bit_for_bit_and_corrupt_bytes_are_refused() {
    assert_eq!(python3(&["states", archive3().to_str().unwrap()]), "");
    check_states(running(), fmu().instantiate("other").unwrap());
}

#[test]
fn e_many_at_once_equal_one_after_the_other() {
    let serial = load(&mut running(), 0.0, 0.05, 6);
    std::thread::scope(|scope| {
        let all: Vec<_> = (0..32).map(|_| scope.spawn(|| load(&mut running(), 0.0, 0.05, 6))).collect();
        all.into_iter().for_each(|one| assert_eq!(one.join().unwrap(), serial));
    });
}

#[test]
fn e_strange_paths_and_many_runs_leave_the_host_as_it_was() {
    let fmu = archive3().to_str().unwrap();
    assert_eq!(python(&["strange", fmu]), "");
    let growth: f64 = python(&["many", fmu, "40"]).trim().parse().unwrap();
    println!("40 simulations: growth {growth:.2} MB");
    assert!(growth < 2.0);
}

#[test]
fn f_both_versions_give_the_same_numbers() {
    let (two, three) = (archive().to_str().unwrap(), archive3().to_str().unwrap());
    for (what, arguments) in [
        ("trapezoid and inputs", vec!["equal", two, three]),
        ("arrays", vec!["arrays", two, three]),
        ("history", vec!["history", three]),
        ("intermediate update", vec!["intermediate", three]),
    ] {
        let worst = number(&arguments);
        println!("{what}: {worst:.1e}");
        assert!(worst < 1e-12, "{what}: {worst:e}");
    }
}

/// Two cycles in steps of 0.5 s: FMPy meets every corner, every touch and every separation, and the peak.
#[test]
fn f_events_are_met_whatever_the_steps() {
    let printed = python3(&["events", archive3().to_str().unwrap()]);
    let mut lines = printed.lines();
    let mut parse =
        || lines.next().unwrap().split(' ').map(|n| n.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let (times, peak) = (parse(), parse()[0]);
    for corner in [0.0625, 0.6875, 0.9875, 4.9875, 5.1875, 8.0875, 8.1875, 8.875, 9.175] {
        assert!(times.iter().any(|t| (t - corner).abs() < 1e-9), "{corner} s is missing in {times:?}");
    }
    // Separations on the way up, and the second touch, later than at the true surface: the sample keeps a dent.
    for (from, to) in [(0.9875, 1.9875), (8.25, 8.4), (9.175, 10.175)] {
        assert!(times.iter().any(|&t| t > from && t < to), "no event within {from} s to {to} s in {times:?}");
    }
    assert!((peak / 11.97e-3 - 1.0).abs() < 1e-3, "{peak}");
}

#[test]
fn f_a_call_costs_less_than_two_microseconds() {
    let mut instance = running();
    let force = [reference("force")];
    let batch = (0..20).map(|_| {
        let begun = Instant::now();
        for _ in 0..1000 {
            assert!(instance.get_real(&force).unwrap()[0].abs() < 1.0);
        }
        begun.elapsed().as_secs_f64() / 1000.0
    });
    let cost = batch.fold(f64::INFINITY, f64::min);
    println!("GetFloat64 through the loader: {:.0} ns", cost * 1e9);
    assert!(cost < 2e-6, "{cost} s");
}
